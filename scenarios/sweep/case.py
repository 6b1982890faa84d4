"""Simulates one case of a sweep, and keeps what the table and the figure need."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fmu_packaging.reference import DECIMALS
from measurement.files import json_ready
from measurement.rig import AXES
from scenarios.cosimulation import simulate
from scenarios.fmu import FmuError
from scenarios.fmu_file import Shelf
from scenarios.sweep.plan import Job
from scenarios.table import group_of

POINTS = 240
"""Number of time intervals at which a case's curves are kept: set on no data."""


def outcome_of(job: Job, places: Mapping[str, Path], shelf: Shelf | None = None) -> dict[str, Any]:
    """Simulate a job and return its outcome, ready for JSON.

    Parameters
    ----------
    job : Job
    places : mapping of str to Path
        The FMUs by SHA-256.
    shelf : Shelf, optional
        Keeps the FMUs open from one job to the next.

    Returns
    -------
    dict
        ``number``; ``problem``, empty on success; ``axes``, by axis the figures of
        `scenarios.table.CompensationRow`; ``valid_percent``, share of the time with valid
        offsets; ``time_s`` and ``curves``, drift and error over time [um].

    Raises
    ------
    BadInput
        If the case does not fit the FMUs.
    """
    with contextlib.ExitStack() as stack:
        opened = shelf or stack.enter_context(Shelf())
        plant, compensator = (
            opened.file(places[key]) if key else None for key in (job.plant, job.compensator)
        )
        assert plant is not None
        try:
            frame = simulate(job.case, plant, compensator, quiet=True).frame
        except FmuError as error:
            return failed(job, str(error))
    axes = group_of("", [("case", "", frame)]).rows[-1].axes
    chosen = np.unique(np.linspace(0, len(frame) - 1, POINTS + 1).round().astype(int))
    names = [f"{what}_{axis}_um" for what in ("drift", "error") for axis in AXES]
    return {
        "number": job.number,
        "problem": "",
        "axes": {
            axis: {k: v for k, v in row.to_dict().items() if k != "samples"}
            for axis, row in axes.items()
        },
        "valid_percent": 100.0 * float(frame["valid_1"].mean()) if "valid_1" in frame else None,
        "time_s": frame["time_s"].to_numpy()[chosen].tolist(),
        "curves": {name: _curve(frame, name, chosen) for name in names if name in frame},
    }


def failed(job: Job, problem: str) -> dict[str, Any]:
    """Return the outcome of a job without a result."""
    return {
        "number": job.number,
        "problem": problem,
        "axes": {},
        "valid_percent": None,
        "time_s": [],
        "curves": {},
    }


def _curve(frame: pd.DataFrame, name: str, chosen: np.ndarray) -> list[float | None]:
    values = np.round(frame[name].to_numpy(dtype=np.float64)[chosen], DECIMALS)
    return list(json_ready(values.tolist()))
