"""What can be hidden in this machine: what the catalogue names, and things that it does not."""

from __future__ import annotations

from functools import cache

from benchmarks.gap.hidden import Hidden, found_in


@cache
def everything() -> dict[str, type[Hidden]]:
    """Return all effects by name, found by walking this folder."""
    return found_in(__path__, __name__)


BEYOND = {
    "windage": 500.0,
    "motor_iron_loss": 1500.0,
    "copper_loss": 3500.0,
    "forced_convection": 10.0,
    "column_bending": 90.0,
    "slow_structure": 60.0,
    "fixture_warming": 14.0,
    "centrifugal_shift": 60.0,
    "tool_heating": 20.0,
    "sensor_lag": 45.0,
    "sensor_drift": 9.0,
}
"""Amplitudes beyond what is usual, where the truth means by them what the catalogue does."""
