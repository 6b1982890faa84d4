"""Error models of the studies as they run: one file a model, a twin in C beside it."""
