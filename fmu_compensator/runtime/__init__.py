"""The code that runs inside the FMU: input checks, error model, offset geometry, limits.

Standard library only. Modules here never name their own root package in a string, because the
FMU bundles them under another root.
"""
