"""A hundred bad inputs: what each command says of them, and that nothing of the user's is lost."""
