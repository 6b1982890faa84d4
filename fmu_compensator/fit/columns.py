"""Targets of runs whose displacement columns need not be assigned to axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from measurement.errors import BadInput
from measurement.rig import FivePointRig, Rig, rig_from_table
from measurement.runs import Run

NOT_READINGS = ("offset_", "error_", "drift_")
"""Prefixes of the columns that a simulation adds to its sensors' readings."""


@dataclass(frozen=True)
class MeasuredColumns:
    """Displacement columns, each of which is a target.

    Attributes
    ----------
    columns : list of str
        Run-file columns.
    """

    columns: list[str]

    def targets(self, run: Run) -> pd.DataFrame:
        """Return the columns of a run, as measured.

        Raises
        ------
        BadInput
            If one is missing.
        """
        for name in self.columns:
            if name not in run.frame.columns:
                raise BadInput(run.path or run.name, f"column {name}", "is missing")
        return run.frame[self.columns].copy()


def targets_of(runs: Sequence[Run], machine_rig: Mapping[str, Any] | None) -> Rig | MeasuredColumns:
    """Return the meaning of the displacement columns of runs, as needed by models.

    Parameters
    ----------
    runs : sequence of Run
        All runs to be compared.
    machine_rig : mapping, optional
        A machine file's rig. It is used if the runs have its columns; otherwise every
        displacement column shared by all runs is a target.

    Raises
    ------
    BadInput
        If the runs share no displacement column.
    """
    if machine_rig is not None:
        rig = rig_from_table(dict(machine_rig), "rig")
        if all(rig.fits(run) for run in runs):
            return rig
    shared = [
        name
        for name in runs[0].displacements
        if not name.startswith(NOT_READINGS) and all(name in run.frame.columns for run in runs)
    ]
    if not shared:
        names = ", ".join(run.name for run in runs[:5])
        raise BadInput("runs", names, "they share no displacement column (_um)")
    return MeasuredColumns(shared)


def shown_targets(rig: Rig | MeasuredColumns, targets: Sequence[str]) -> dict[str, int]:
    """Return the targets that a comparison shows: place among *targets*, by displayed name.

    Those of a five-point rig are elongation, yaw and pitch (the near radial drifts are also fitted,
    but only for the offsets); others have the names of their columns.
    """
    if isinstance(rig, FivePointRig):
        return {name: targets.index(name) for name in ("elongation", "yaw", "pitch")}
    return {f"{name}_um": place for place, name in enumerate(targets)}


def unit_of(rig: Rig | MeasuredColumns, name: str) -> str:
    """Return the unit of a target: um, or urad for the tilts of a five-point rig."""
    return "urad" if name in ("yaw", "pitch") and not isinstance(rig, MeasuredColumns) else "um"
