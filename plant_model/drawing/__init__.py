"""A machine from its drawing: one page of geometry, expanded into an ordinary machine file."""
