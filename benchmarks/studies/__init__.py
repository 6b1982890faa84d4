"""The studies' own experiment: learn on a spectrum of speeds, predict, compensate."""
