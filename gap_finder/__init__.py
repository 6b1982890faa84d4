"""Finds where a machine's model and measured runs disagree, and what the model lacks."""
