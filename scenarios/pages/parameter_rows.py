"""The table of calibrated parameters that pages show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gap_finder.calibrate import ParameterEstimate

DETERMINED = 0.5
"""Prior contraction above which the runs count as determining a parameter [1]: set on no data."""


def is_determined(parameter: ParameterEstimate) -> bool:
    """Return whether the runs determine a parameter, or moved it far."""
    return parameter.prior_contraction >= DETERMINED or parameter.is_far


def parameter_rows(
    parameters: Sequence[ParameterEstimate], added: Sequence[str] = ()
) -> list[dict[str, Any]]:
    """Return the rows of the template ``parameters.html``, best determined first.

    Parameters
    ----------
    parameters : sequence of ParameterEstimate
        Calibration's estimates of its free parameters.
    added : sequence of str
        Parameters that the machine did not have before, and which have no earlier value.
    """
    return [
        {
            "name": parameter.name,
            "unit": "" if parameter.unit == "1" else parameter.unit,
            "prior": None if parameter.name in added else parameter.prior,
            "value": parameter.value,
            "low": parameter.low,
            "high": parameter.high,
            "range": parameter.range,
            "contraction": parameter.prior_contraction,
            "is_loose": parameter.prior_contraction < DETERMINED,
            "deviations": parameter.deviations,
            "is_far": parameter.is_far,
            "is_told": is_determined(parameter),
        }
        for parameter in sorted(parameters, key=lambda parameter: -parameter.prior_contraction)
    ]
