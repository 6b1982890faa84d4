"""Sweeps: one scenario many times, over a grid and over random draws of what may vary."""
