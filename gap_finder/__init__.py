"""Where a machine's model and measured runs disagree, and what is missing in the model."""
