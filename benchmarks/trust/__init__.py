"""How far compensators can be trusted, in conditions like their training and unlike it."""
