"""A scenario as one file that other tools run: System Structure and Parameterization, SSP 1.0."""
