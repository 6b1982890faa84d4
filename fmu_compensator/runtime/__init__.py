"""What runs inside the FMU: input checks, error model, offset geometry, limits.

Standard library only. Modules here never name their own root package in a string, because the
FMU carries them under another root.
"""
