"""What the sensors of a five-point rig show in a pose: `FivePointRig.pose` the other way round."""

import numpy as np
import pandas as pd

from measurement.rig import POSE, FivePointRig

UM_PER_MM = 1e3


def readings_of(rig: FivePointRig, pose: pd.DataFrame) -> pd.DataFrame:
    """Return the five readings [um] of each row."""
    elongation, yaw, pitch, x, y = (pose[name].to_numpy(dtype=float) for name in POSE)
    slope_x, slope_y = np.tan(1e-6 * yaw), np.tan(1e-6 * pitch)
    bar, spacing = rig.test_bar_mm * UM_PER_MM, rig.spacing_mm * UM_PER_MM
    if bar:
        elongation = (elongation + bar) / np.sqrt(1.0 + slope_x**2 + slope_y**2) - bar
    values = (
        rig.near_x_sign * x,
        rig.near_y_sign * y,
        rig.distal_x_sign * (x + spacing * slope_x),
        rig.distal_y_sign * (y + spacing * slope_y),
        rig.axial_sign * elongation,
    )
    return pd.DataFrame(dict(zip(rig.columns, values, strict=True)), index=pose.index)
