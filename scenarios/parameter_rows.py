"""The table of calibrated parameters that pages show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gap_finder.calibrate import ParameterEstimate
from plant_model.machine import Machine

DETERMINED = 0.5
"""Prior contraction from which the runs are said to determine a parameter [1]."""


def parameter_rows(
    machine: Machine, parameters: Sequence[ParameterEstimate], added: Sequence[str] = ()
) -> list[dict[str, Any]]:
    """Return the rows of the template ``parameters.html``, best determined first.

    Parameters
    ----------
    machine : Machine
        Says the ranges.
    parameters : sequence of ParameterEstimate
        What calibration says of its free parameters.
    added : sequence of str
        Those that the machine did not have before: nothing is known of them from before.
    """
    ranges = machine.parameters
    return [
        {
            "name": one.name,
            "unit": "" if one.unit == "1" else one.unit,
            "prior": None if one.name in added else one.prior,
            "value": one.value,
            "low": one.low,
            "high": one.high,
            "range": (ranges[one.name].low, ranges[one.name].high),
            "contraction": one.prior_contraction,
            "deviations": one.deviations,
            "is_far": one.is_far,
            "is_told": one.prior_contraction >= DETERMINED or one.is_far,
        }
        for one in sorted(parameters, key=lambda one: -one.prior_contraction)
    ]
