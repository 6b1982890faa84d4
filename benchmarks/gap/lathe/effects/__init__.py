"""What can be hidden in the lathe: what the catalogue names, and things that it does not."""

from __future__ import annotations

from functools import cache

from benchmarks.gap.hidden import Hidden, found_in


@cache
def everything() -> dict[str, type[Hidden]]:
    """Return all effects by name, found by walking this folder."""
    return found_in(__path__, __name__)


BEYOND = {
    "motor_iron_loss": 2500.0,
    "forced_convection": 10.0,
    "slow_structure": 70.0,
    "fixture_warming": 15.0,
    "sensor_lag": 45.0,
    "sensor_drift": 9.0,
}
"""Amplitudes beyond what is usual, where the truth means by them what the catalogue does."""
