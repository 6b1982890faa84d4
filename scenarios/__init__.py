"""Scenarios: plant and compensator in a loop, results, reports, and the command line."""
