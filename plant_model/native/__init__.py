"""The plant without Python: its equations, traced from the effects and written as C99."""
