"""Residuals of a machine before and after, compared with what any model could achieve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gap_finder.observations import Observations
from gap_finder.periods import in_step
from gap_finder.regimes import (
    RunResiduals,
    by_channel,
    floor_of,
    gap_of,
    mean_squares,
    residuals,
)
from plant_model.machine import Machine


class GapComparison:
    """Residuals of the machine before and after, on some runs.

    Parameters
    ----------
    before, after : Machine
    observed : sequence of Observations
    """

    def __init__(self, before: Machine, after: Machine, observed: Sequence[Observations]) -> None:
        self.before: list[RunResiduals] = [residuals(before, run) for run in observed]
        self.after = self.before
        if after is not before:
            self.after = [residuals(after, in_step(after, run)) for run in observed]

    def gap(self) -> dict[str, float]:
        """Return the gap before and after, and its floor [1]."""
        return {
            "before": gap_of(self.before),
            "after": gap_of(self.after),
            "floor": gap_of(floor_of(self.before)),
        }

    def gap_against(self, reference: list[RunResiduals]) -> dict[str, float]:
        """Return the gap, the gap of the reference, and the reducible difference.

        Parameters
        ----------
        reference : list of RunResiduals
            What no description of this machine could remove.

        Returns
        -------
        dict of str to float
            ``before``, ``after``, ``reference`` and ``reducible``, which is never below 0 [1].
        """
        table = self.gap()
        least = gap_of(reference)
        return table | {"reference": least, "reducible": max(table["after"] - least, 0.0)}

    def worst(self) -> float:
        """Return the gap afterwards in the run where it is largest [1]."""
        return max(gap_of([run]) for run in self.after)

    def channels(self) -> dict[str, dict[str, Any]]:
        """Return every channel's residual before and after, its noise and its noise floor.

        ``no_model`` is the residual without a model: the distance from the first reading.
        """
        observed = self.before[0].observed
        parts = (self.before, self.after, floor_of(self.before))
        first, last, floor = (by_channel(part) for part in parts)
        no_model = np.sqrt(mean_squares([run.observed.moved for run in self.before]))
        return {
            name: {
                "before": first[name],
                "after": last[name],
                "noise": float(observed.noise[i]),
                "floor": floor[name],
                "no_model": float(no_model[i]),
                "unit": observed.unit_of(i),
            }
            for i, name in enumerate(observed.channels)
            if name in first
        }

    def channels_against(self, reference: list[RunResiduals]) -> dict[str, dict[str, Any]]:
        """Return the channels, each with the residual of the reference and the reducible rest.

        Parameters
        ----------
        reference : list of RunResiduals
            As in `gap_against`.

        Returns
        -------
        dict of str to dict
            By channel [K, um].
        """
        table = self.channels()
        least = by_channel(reference)
        for name, entry in table.items():
            entry["reference"] = least[name]
            entry["reducible"] = max(entry["after"] - least[name], 0.0)
        return table
