"""Error models of the studies as they are fitted."""
