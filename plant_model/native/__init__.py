"""The plant without Python: its equations traced from the effects, written as C99."""
