"""A scenario as one file for other tools: System Structure and Parameterization (SSP)."""
