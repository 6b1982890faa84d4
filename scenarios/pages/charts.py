"""The contents of figures, independent of how they are drawn.

A chart is a stack of panels over one time axis. From the same description `figures` draws PNG
files and `report` an interactive page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np
import numpy.typing as npt

from measurement.naming import lowered
from measurement.resampling import GAP_INTERVALS
from scenarios.signals.base import FloatArray

CHART_WIDTH, PANEL = 900, 230
"""Width of a chart and height of a panel [px], a hundredth of an inch on paper: set on no data."""

INTERVAL = "#9fb9d6"
"""Colour of the interval."""

BEFORE = "#8b929c"
"""Colour of uncompensated drift."""

MEASURED = "#3a414b"
"""Colour of measurements."""

LINES = ("#1d5fa8", "#d9822b", "#2f8f6b", "#8a5a9e", "#b8435c", "#5f7a30")
"""Colours of curves to be distinguished, in order."""

SHOWN = len(LINES)
"""Number of runs, models, numbers or lags that are drawn or named, the first or the farthest."""

MANY = (
    "#332288",
    "#cc6677",
    "#ddaa33",
    "#117733",
    "#88ccee",
    "#882255",
    "#44aa99",
    "#999933",
    "#aa4499",
    "#1d5fa8",
    "#777777",
    "#d9822b",
)
"""Colours of many thermometers."""


@dataclass(frozen=True)
class Line:
    """One curve: *values* over *time_s*, both of shape (samples,).

    *held* means that the value jumps and then stays; lines of a higher *rank* are drawn on top.
    """

    label: str
    time_s: FloatArray
    values: FloatArray
    colour: str
    held: bool = False
    thin: bool = False
    rank: int = 1


def interval(time_s: FloatArray, half_width: FloatArray, of: str = "") -> list[Line]:
    """Return the lines between which a compensator expects most of its remaining error.

    Parameters
    ----------
    time_s, half_width : array (samples,)
        [s], [um]; a half-width below 0 is unknown.
    of : str
        The curve to which it belongs, where there are several.
    """
    width = np.where(half_width >= 0.0, half_width, np.nan)
    if not np.isfinite(width).any():
        return []
    label = f"interval of the remaining error{f', {lowered(of)}' if of else ''}"
    return [Line(label, time_s, sign * width, INTERVAL, thin=True, rank=0) for sign in (1.0, -1.0)]


@dataclass(frozen=True)
class Panel:
    """Curves with one vertical axis, whose label gives the unit; *from_zero* includes zero."""

    y_label: str
    lines: tuple[Line, ...]
    from_zero: bool = False
    log: bool = False


@dataclass(frozen=True)
class Chart:
    """Panels over one axis.

    Attributes
    ----------
    name : str
        Name of the file and of the element on the page.
    title, note : str
        What it shows, and what to look for.
    panels : tuple of Panel
        From top to bottom.
    x_label : str
        Label of the axis below them.
    x_unit : float
        One unit of that axis, in terms of the lines' *time_s*.
    """

    name: str
    title: str
    note: str
    panels: tuple[Panel, ...]
    x_label: str = "time [h]"
    x_unit: float = 3600.0


def convergence_chart(curves: Mapping[str, Sequence[float]]) -> Chart:
    """Return the mean squared errors of networks, by title, over the iterations of training."""
    lines = [
        Line(title, np.arange(len(curve), dtype=np.float64), np.asarray(curve), colour)
        for (title, curve), colour in zip(curves.items(), cycle(LINES), strict=False)
    ]
    panel = Panel("mean squared error, scaled [1]", tuple(lines), log=True)
    label = "iteration of Levenberg-Marquardt"
    title = next(iter(curves)) if len(curves) == 1 else "How the networks converged"
    return Chart("convergence", title, "", (panel,), label, 1.0)


def with_gaps(time_s: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a curve through its known samples, broken at gaps that are long for these.

    It bridges single missing samples, and joins measurements that are always far apart.

    Parameters
    ----------
    time_s : array, shape (samples,)
        [s]
    values : array, shape (samples,)
        NaN: missing.

    Returns
    -------
    time_s, values : array, shape (known samples + gaps,)
    """
    there = ~np.isnan(values)
    time_s, values = time_s[there], values[there]
    steps = np.diff(time_s)
    if not len(steps):
        return time_s, values
    cuts = np.flatnonzero(steps > GAP_INTERVALS * np.median(steps)) + 1
    return np.insert(time_s, cuts, time_s[cuts - 1]), np.insert(values, cuts, np.nan)


def kept(values: FloatArray, most: int = CHART_WIDTH) -> npt.NDArray[np.intp]:
    """Return the few samples that a drawing needs, including all extremes.

    The samples are cut into equal stretches; the smallest, the largest and the first missing one of
    each are kept, and the first and last of all.

    Parameters
    ----------
    values : array, shape (samples,)
        NaN marks a missing value.
    most : int
        About as many samples are kept; shorter arrays are kept whole.

    Returns
    -------
    array of int
        Increasing indices.
    """
    count = len(values)
    if count <= most:
        return np.arange(count)
    width = -(-count // (most // 2))
    rows = -(-count // width)
    padded = np.full(rows * width, np.nan)
    padded[:count] = values
    table = padded.reshape(rows, width)
    missing = np.isnan(table)
    starts = np.arange(rows) * width
    picked = [
        np.where(missing, np.inf, table).argmin(axis=1) + starts,
        np.where(missing, -np.inf, table).argmax(axis=1) + starts,
        (missing.argmax(axis=1) + starts)[missing.any(axis=1)],
        np.array([0, count - 1]),
    ]
    chosen = np.unique(np.concatenate(picked))
    return chosen[chosen < count]


def kept_steps(values: FloatArray) -> npt.NDArray[np.intp]:
    """Return the samples that a drawing of a held value needs: each one that begins a new level."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    if len(changes) > CHART_WIDTH:
        return kept(values)
    return np.unique(np.concatenate(([0], changes, [len(values) - 1])))
