"""Sweeps: one scenario simulated many times, over a grid and over random draws."""
