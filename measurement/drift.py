"""Converts rig readings to the drift of the tool tip, and defines where drift counts from.

Fitting, comparing, replaying and summarising all count drift with `counted`, so a compensator
fitted to drift from a run's start is also judged by drift from a run's start.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from measurement.rig import AXES, DirectRig, FivePointRig, Rig
from measurement.runs import Run
from measurement.units import RAD_PER_URAD, UM_PER_MM

FROM_START = {"rise": True, "level": True, "absolute": False}
"""Whether drift counts from a run's first reading, by the input form of an error model."""


def counted(frame: pd.DataFrame, input_form: str) -> pd.DataFrame:
    """Return measured quantities of a run, counted as an input form requires.

    Parameters
    ----------
    frame : DataFrame, shape (rows, quantities)
        Displacements, a pose or a drift; NaN where a reading is missing or unusable.
    input_form : {"rise", "level", "absolute"}
        ``rise`` and ``level`` count each quantity from its first reading, so that the gauge's
        initial reading is not drift; ``absolute`` takes it as read.

    Returns
    -------
    DataFrame
        A quantity without any reading stays NaN.
    """
    if not FROM_START[input_form] or frame.empty:
        return frame
    return frame - frame.bfill().iloc[0]


def late_by(
    time_s: npt.NDArray[np.float64], measured: npt.NDArray[np.float64], input_form: str
) -> float:
    """Return how long after a run's start its drift begins to count [s]; 0 for absolute readings.

    Parameters
    ----------
    time_s : array (n,)
        Increasing [s].
    measured : array (n, m)
        Displacements; a row counts only if all of them are read. NaN is missing.
    input_form : str
        See `counted`.
    """
    if not FROM_START[input_form]:
        return 0.0
    known = np.flatnonzero(np.isfinite(measured).all(axis=1))
    return float(time_s[known[0]] - time_s[0]) if len(known) else 0.0


def predicted_drift(
    sent: npt.NDArray[np.float64], drift: npt.NDArray[np.float64], input_form: str
) -> npt.NDArray[np.float64]:
    """Return the drift that offsets predict, counted like the measured drift.

    If an axis was first read after the run's start, its readings do not show the drift before then;
    so the movement of the offsets up to that reading does not count either.

    Parameters
    ----------
    sent : array (n, axes)
        Offsets, row by row [um].
    drift : array (n, axes)
        Measured drift from `measured_drift`; NaN where not measured [um].
    input_form : str
        See `counted`.

    Returns
    -------
    array (n, axes)
        [um]
    """
    if not FROM_START[input_form] or not len(sent):
        return -sent
    first = np.isfinite(drift).argmax(axis=0)
    before = sent[first, np.arange(sent.shape[1])] - sent[0]
    return np.asarray(before - sent)


def error_left(
    drift: pd.DataFrame, sent: Sequence[npt.NDArray[np.float64]], input_form: str
) -> pd.DataFrame:
    """Return the error that remains of a measured drift with offsets, under its column names [um].

    Parameters
    ----------
    drift : DataFrame
        Measured drift from `measured_drift` [um].
    sent : sequence of array (n,)
        Offsets, one array per column of *drift* [um].
    input_form : str
        See `counted`.
    """
    return drift - predicted_drift(np.column_stack(sent), drift.to_numpy(float), input_form)


def measured_drift(run: Run, rig: Rig, tool_length_mm: float, input_form: str) -> pd.DataFrame:
    """Return the measured drift of the tool tip in a run.

    dX = x + (L - l1) tan(yaw), dY = y + (L - l1) tan(pitch), dZ = L - (L + E) cos(tilt), with x, y
    the radial drift at the near sensors, l1 their distance from the gauge line, E the elongation.
    Displacement columns that each measure one axis are that drift directly.

    Parameters
    ----------
    run : Run
        With the rig's columns.
    rig : FivePointRig or DirectRig
        Defines the columns.
    tool_length_mm : float
        L, from the gauge line to the tool tip; a direct rig ignores it [mm].
    input_form : str
        Where the drift counts from: see `counted`.

    Returns
    -------
    DataFrame
        ``drift_X_um`` ... for the measured axes; NaN where a reading is missing.

    Raises
    ------
    BadInput
        If the run lacks a column of the rig.
    """
    measured = rig.targets(run)
    if isinstance(rig, DirectRig):
        return counted(rig.drift(measured), input_form)
    return tool_tip_drift(counted(measured, input_form), rig, tool_length_mm)


def tool_tip_drift(pose: pd.DataFrame, rig: FivePointRig, tool_length_mm: float) -> pd.DataFrame:
    """Return the drift of the tool tip [um] for poses from `FivePointRig.pose`."""
    slopes = [np.tan(pose[name] * RAD_PER_URAD) for name in ("yaw_urad", "pitch_urad")]
    length = tool_length_mm * UM_PER_MM
    beyond = length - rig.near_to_gauge_mm * UM_PER_MM
    cosine = 1.0 / np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
    drift = (
        pose["near_x_um"] + beyond * slopes[0],
        pose["near_y_um"] + beyond * slopes[1],
        length - (length + pose["elongation_um"]) * cosine,
    )
    names = (f"drift_{axis}_um" for axis in AXES)
    return pd.DataFrame(dict(zip(names, drift, strict=True)))
