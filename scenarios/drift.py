"""From what a rig measured to the drift of the tool tip: the measured side of a comparison."""

from __future__ import annotations

import numpy as np
import pandas as pd

from measurement.rig import AXES, DirectRig, FivePointRig, Rig
from measurement.runs import Run

UM_PER_MM = 1e3
RAD_PER_URAD = 1e-6


def measured_drift(run: Run, rig: Rig, tool_length_mm: float, *, from_first: bool) -> pd.DataFrame:
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
    from_first : bool
        Count from each quantity's first valid sample.

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
        return _from_first(rig.drift(run.frame)) if from_first else rig.drift(run.frame)
    pose = _from_first(rig.pose(run.frame)) if from_first else rig.pose(run.frame)
    return tool_tip_drift(pose, rig, tool_length_mm)


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


def _from_first(frame: pd.DataFrame) -> pd.DataFrame:
    return frame - frame.bfill().iloc[0]
