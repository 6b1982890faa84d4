"""Pages and figures: what the commands draw, for people to look at."""
