"""The gap finder's benchmark."""
