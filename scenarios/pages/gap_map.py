"""The regime map: the residual of each channel in each regime of the machine, run by run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gap_finder.regimes import RunResiduals, regimes
from scenarios.pages.svg import mixed

KINDS = ("standing", "warming up", "steady", "cooling down")


@dataclass(frozen=True)
class Cell:
    """One channel in one regime of one run: text and background colour."""

    text: str
    colour: str


@dataclass(frozen=True)
class RegimeMap:
    """A table of channels against regimes.

    Attributes
    ----------
    runs : tuple of (str, int)
        Name and number of columns of each run.
    kinds : tuple of str
        Regime of each column.
    rows : tuple of (str, tuple of Cell)
        Channels and their cells.
    """

    runs: tuple[tuple[str, int], ...]
    kinds: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell, ...]], ...]


def regime_map(residuals: Sequence[RunResiduals]) -> RegimeMap:
    """Return RMS residuals in tolerances, by channel, run and regime; blank if not measured."""
    runs, kinds = [], []
    columns: list[dict[str, float]] = []
    for run in residuals:
        time = run.observed.time_s
        rows = {kind: np.zeros(len(time), dtype=bool) for kind in KINDS}
        for start, end, regime in regimes(run.observed):
            rows[regime.partition(",")[0]] |= (time >= start) & (time <= end)
        present = [kind for kind in KINDS if rows[kind].any()]
        runs.append((run.observed.run.name, len(present)))
        kinds += present
        for kind in present:
            part = run.values[rows[kind]] / run.observed.tolerance
            ratios = np.sqrt(pd.DataFrame(part**2).mean()).tolist()
            columns.append(dict(zip(run.observed.channels, ratios, strict=True)))
    # A channel that is broken in every held-out run is left out.
    channels = dict.fromkeys(name for run in residuals for name in run.observed.channels)
    return RegimeMap(
        tuple(runs),
        tuple(kinds),
        tuple(
            (name, tuple(_cell(column.get(name, np.nan)) for column in columns))
            for name in channels
        ),
    )


def _cell(ratio: float) -> Cell:
    if not np.isfinite(ratio):
        return Cell("", "none")
    above = 1.0 - 1.0 / max(ratio, 1.0)  # the share above the tolerance
    return Cell(f"{ratio:.1f}", mixed(above, "#ffffff", "#de6e4b"))
