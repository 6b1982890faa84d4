"""Rig measurements: run files, the five-point pose, figures of merit, ISO 230-3 summaries."""
