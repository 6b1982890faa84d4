"""Error models of the studies at run time: one file per model, next to its C twin."""
