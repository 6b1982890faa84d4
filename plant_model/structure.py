"""Position of the nose and the tool tip from temperatures.

This is the plant's own geometry. The compensator's geometry is written separately, so that the two
cannot share a mistake.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.effects import Effect
from plant_model.effects.base import NONE, POSE, Inputs
from plant_model.parameters import FloatArray

UM_PER_MM, RAD_PER_URAD = 1e3, 1e-6
"""As given by the SI; a plant FMU contains nothing of `measurement`."""


def pose(
    effects: Sequence[Effect],
    slices: dict[str, slice],
    inputs: Inputs,
    rise: FloatArray,
    states: FloatArray,
) -> FloatArray:
    """Return the pose, shape (sets, times, 6), in the order of ``effects.base.POSE``.

    Parameters
    ----------
    effects : sequence of Effect
        Those in force.
    slices : dict of str to slice
        Positions of each effect's own states.
    inputs : mapping of str to array, shape (times,)
    rise : array, shape (sets, times, nodes)
        Temperature above its start [K].
    states : array, shape (sets, times, own states)
    """
    out = np.zeros((*rise.shape[:2], len(POSE)))
    for effect in effects:
        own = states[..., slices[effect.key]] if effect.states else NONE
        effect.displacement(inputs, rise, own, out)
    return out


def drift_at(pose_now: FloatArray, length_mm: float | FloatArray) -> FloatArray:
    """Return the drift of a point on the tool [um], shape (..., 3).

    Parameters
    ----------
    pose_now : array, shape (..., 6)
        See :func:`pose`.
    length_mm : float or array, shape (...)
        Distance from the gauge line along the tool [mm].

    Notes
    -----
    X and Y follow the exact tangent. Along Z the nose grows towards -Z, the tool grows with its
    own warming, and a tilted tool is shorter by L (1 - cos).
    """
    x, y, elongation, yaw, pitch, strain = (pose_now[..., i] for i in range(6))
    lever = length_mm * UM_PER_MM
    tan_yaw, tan_pitch = np.tan(yaw * RAD_PER_URAD), np.tan(pitch * RAD_PER_URAD)
    # 1 - cos of the total tilt, in a form without cancellation at small angles.
    tilt_squared = tan_yaw**2 + tan_pitch**2
    secant = np.sqrt(1.0 + tilt_squared)
    shortening = lever * tilt_squared / (secant * (1.0 + secant))
    out = np.empty((*np.broadcast_shapes(x.shape, np.shape(length_mm)), 3))
    out[..., 0] = x + lever * tan_yaw
    out[..., 1] = y + lever * tan_pitch
    out[..., 2] = shortening - elongation - strain * length_mm
    return out
