"""From what a rig measured to the drift of the tool tip, and from when drift counts.

Fitting, comparing, replaying and summarising all count drift by `counted`: a compensator that was
fitted to drift from a run's start is judged by drift from a run's start.
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
    """Return measured quantities of a run as an input form counts them.

    Parameters
    ----------
    frame : DataFrame, shape (rows, quantities)
        Displacements, a pose or a drift; NaN where a reading is missing or not to be used.
    input_form : {"rise", "level", "absolute"}
        ``rise`` and ``level`` count every quantity from its own first reading, ``absolute`` takes
        it as read. What a gauge shows at the start is then no drift.

    Returns
    -------
    DataFrame
        A quantity without a reading stays NaN.
    """
    if not FROM_START[input_form] or frame.empty:
        return frame
    return frame - frame.bfill().iloc[0]


def late_by(
    time_s: npt.NDArray[np.float64], measured: npt.NDArray[np.float64], input_form: str
) -> float:
    """Return how long after a run's start its drift begins to count [s]; 0 if from nothing.

    Parameters
    ----------
    time_s : array (n,)
        Increasing [s].
    measured : array (n, m)
        Displacements, which must be read together; NaN is missing.
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
    """Return the drift that offsets stand for, counted as the measured one is.

    Where an axis was first read after the run's start, none of its readings shows what it had
    drifted before; so what the offsets had moved by then counts for nothing, either.

    Parameters
    ----------
    sent : array (n, axes)
        Offsets, row by row [um].
    drift : array (n, axes)
        Measured, as `measured_drift` gives it; NaN where it was not [um].
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
    """Return what offsets leave of a measured drift, under its column names [um].

    Parameters
    ----------
    drift : DataFrame
        As `measured_drift` gives it [um].
    sent : sequence of array (n,)
        Offsets, one for each of its columns [um].
    input_form : str
        See `counted`.
    """
    return drift - predicted_drift(np.column_stack(sent), drift.to_numpy(float), input_form)


def measured_drift(run: Run, rig: Rig, tool_length_mm: float, input_form: str) -> pd.DataFrame:
    """Return the drift of the tool tip that a run shows.

    dX = x + (L - l1) tan(yaw), dY = y + (L - l1) tan(pitch), dZ = L - (L + E) cos(tilt), with x, y
    the radial drift at the near sensors, l1 their distance from the gauge line, E the elongation.
    Displacement columns that each stand for an axis are that drift themselves.

    Parameters
    ----------
    run : Run
        With the rig's columns.
    rig : FivePointRig or DirectRig
        What the columns are.
    tool_length_mm : float
        L, from the gauge line to the tool tip; a direct rig takes no notice of it [mm].
    input_form : str
        What the drift counts from: see `counted`.

    Returns
    -------
    DataFrame
        ``drift_X_um`` ... for the axes known; NaN where a reading is missing.

    Raises
    ------
    BadInput
        If the run has no such column.
    """
    if isinstance(rig, DirectRig):
        return counted(rig.drift(run.frame), input_form)
    return tool_tip_drift(counted(rig.pose(run.frame), input_form), rig, tool_length_mm)


def tool_tip_drift(pose: pd.DataFrame, rig: FivePointRig, tool_length_mm: float) -> pd.DataFrame:
    """Return the drift of the tool tip [um] for poses as `FivePointRig.pose` gives them."""
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
