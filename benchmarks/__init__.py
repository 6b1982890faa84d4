"""Measurements of speed, each a program: ``python -m benchmarks.<name>``."""
