"""Scenarios: plant and compensator in closed loop, results, reports, and the command line."""
