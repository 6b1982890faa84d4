"""The headline table: drift of the tool tip before and after compensation, as in the studies."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from measurement.figures import improvement
from measurement.files import json_ready
from measurement.rig import AXES

NO_COMPENSATION = "No compensation"


@dataclass(frozen=True)
class CompensationRow:
    """The drift along one axis, before and after compensation.

    Attributes
    ----------
    before_max_um, before_mean_um, after_max_um, after_mean_um : float
        Largest and mean absolute drift, without and with compensation [um].
    improvement_percent : float
        Reduction of the mean [%].
    samples : int
        Number of samples that have both values.
    """

    before_max_um: float
    before_mean_um: float
    after_max_um: float
    after_mean_um: float
    improvement_percent: float
    samples: int

    def to_dict(self) -> dict[str, Any]:
        """Return the row ready for JSON; an undefined figure is null."""
        return dict(json_ready(asdict(self)))


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    name : str
        The variant or the run; empty for the line without compensation.
    label : str
        Text in the table.
    axes : dict of str to CompensationRow
        By axis: those of X, Y, Z that are known.
    """

    name: str
    label: str
    axes: dict[str, CompensationRow]

    @property
    def is_reference(self) -> bool:
        """Whether this is the line without compensation."""
        return not self.name


@dataclass(frozen=True)
class Group:
    """Lines that share the same drift, the one without compensation first."""

    title: str
    rows: tuple[Row, ...]

    def with_only(self, names: Iterable[str]) -> Group:
        """Return the group with only the reference line and the lines of these names.

        Parameters
        ----------
        names : iterable of str
            Unknown names are ignored.
        """
        wanted = set(names)
        rows = tuple(row for row in self.rows if row.is_reference or row.name in wanted)
        return Group(self.title, rows)


def group_of(title: str, results: Iterable[tuple[str, str, pd.DataFrame]]) -> Group:
    """Return the lines of several results that share the same drift.

    Parameters
    ----------
    title : str
        What they share, for example the tool length.
    results : iterable of (name, label, frame)
        Frames with ``drift_X_um`` ... and ``error_X_um`` ... [um].
    """
    rows: list[Row] = []
    for name, label, frame in results:
        if not rows:
            rows.append(Row("", NO_COMPENSATION, _by_axis(frame, "drift")))
        rows.append(Row(name, label, _by_axis(frame, "error")))
    return Group(title, tuple(rows))


def overall(groups: Sequence[Group], title: str) -> Group:
    """Return the lines of all groups combined: largest maximum, mean over all samples.

    Each group must have the line without compensation first, followed by the same lines.
    """
    axes = sorted({axis for group in groups for axis in group.rows[0].axes})
    reference: dict[str, CompensationRow] = {}
    lines = []
    for place, label in enumerate([row.label for row in groups[0].rows][1:], 1):
        after: dict[str, CompensationRow] = {}
        for axis in axes:
            rows = [group.rows[place].axes.get(axis) for group in groups]
            counted = [row for row in rows if row is not None and row.samples]
            if counted:
                reference[axis], after[axis] = _taken_together(counted)
        lines.append(Row("overall" if place == 1 else f"overall_{place}", label, after))
    return Group(title, (Row("", NO_COMPENSATION, reference), *lines))


def _taken_together(
    rows: Sequence[CompensationRow],
) -> tuple[CompensationRow, CompensationRow]:
    samples = sum(row.samples for row in rows)
    before = sum(row.before_mean_um * row.samples for row in rows) / samples
    after = sum(row.after_mean_um * row.samples for row in rows) / samples
    before_max = max(row.before_max_um for row in rows)
    after_max = max(row.after_max_um for row in rows)
    gain = 100.0 * improvement(before, after)
    return (
        CompensationRow(before_max, before, before_max, before, 0.0, samples),
        CompensationRow(before_max, before, after_max, after, gain, samples),
    )


def _by_axis(frame: pd.DataFrame, after: str) -> dict[str, CompensationRow]:
    """Return the row of each axis, for what is left in the columns ``<after>_X_um`` ..."""
    rows: dict[str, CompensationRow] = {}
    for axis in AXES:
        names = [f"{what}_{axis}_um" for what in ("drift", after)]
        if set(names) <= set(frame):
            # A sample counts only if it has both values.
            both = frame[names].dropna().abs().to_numpy(dtype=np.float64)
            most, means = [math.nan, math.nan], [math.nan, math.nan]
            if len(both):
                most, means = both.max(axis=0).tolist(), both.mean(axis=0).tolist()
            gain = 100.0 * improvement(*means)
            rows[axis] = CompensationRow(most[0], means[0], most[1], means[1], gain, len(both))
    return rows


def as_text(groups: Sequence[Group]) -> str:
    """Return the table as fixed-width text: values after compensation, the reference line on top.

    Parameters
    ----------
    groups : sequence of Group
    """
    axes = sorted({axis for group in groups for row in group.rows for axis in row.axes})
    labels = [row.label for group in groups for row in group.rows] + [g.title for g in groups]
    width = max(len(label) for label in labels) + 3
    cells = "max    mean  better"
    lines = [
        " " * width + "".join(f"{axis + ' [um]':^24}" for axis in axes),
        " " * width + "".join(f"{cells:>22}  " for _ in axes),
    ]
    for group in groups:
        lines.append(group.title)
        for row in group.rows:
            values = "".join(_cells(row.axes.get(axis), row.is_reference) for axis in axes)
            lines.append(f"  {row.label}".ljust(width) + values)
    return "\n".join(line.rstrip() for line in lines)


def _cells(row: CompensationRow | None, reference: bool) -> str:
    if row is None:
        return f"{'-':>7}{'-':>8}{'-':>8} "
    better = "" if reference else percent(row.improvement_percent)
    return f"{number(row.after_max_um):>7}{number(row.after_mean_um):>8} {better:>7} "


def number(value: float) -> str:
    """Return a displacement as text for tables [um]."""
    return "-" if math.isnan(value) else f"{value:.1f}"


def percent(value: float) -> str:
    """Return an improvement as text for tables [%]."""
    return "-" if math.isnan(value) else f"{value:.0f} %"


def as_list(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Return the table ready for JSON; an undefined figure is null."""
    return list(json_ready([asdict(group) for group in groups]))
