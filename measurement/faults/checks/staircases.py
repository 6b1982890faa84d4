"""Displacements that are read in coarse steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.faults.series import lengths_of
from measurement.runs import FloatArray, Run

COARSE_SHARE = 1 / 200
"""A channel is a staircase if its median step is more than this share of its range and most samples
repeat the previous one [1]: set on no data."""


class Staircases(Check):
    """Errors below the step cannot be resolved; the readings are otherwise sound."""

    kinds: ClassVar = {"staircase": Kind("kept: no error smaller than the step can be seen")}

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the displacements of a run that are staircases."""
        for name in lengths_of(run):
            values: FloatArray = run.frame[name].dropna().to_numpy()
            moves = np.abs(np.diff(values))
            if not (moves > 0).any():
                continue
            still = float((moves == 0).mean())
            usual = float(np.median(moves[moves > 0]))
            if usual > COARSE_SHARE * float(np.ptp(values)) and still > 0.5:
                text = (
                    f"a staircase with steps of {usual:.2g} um, unchanged in {still:.0%} of samples"
                )
                yield Fault.between(run, name, "staircase", 0, -1, text)
