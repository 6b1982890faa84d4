"""Correlations of the truth; the base laws have the form that the machine's description claims."""

from __future__ import annotations

import numpy as np

from benchmarks.gap.cells import Array

AIR_CONDUCTIVITY = 0.0263  # W/(m K), 27 degC
AIR_VISCOSITY = 15.9e-6  # m2/s
AIR_PRANDTL = 0.707
BEARING_DIAMETER = 70.0  # mm


def gap_film(speed: float, radius_m: float, gap_m: float) -> float:
    """Return the film coefficient across an annular gap [W/(m2 K)].

    Conduction joined smoothly to the vortex law Nu = 0.42 (Ta Pr)^(1/4), Nu and Ta = Re^2 s/r on
    the gap s; the form of Tachibana and Fukui (JSME Bulletin 7 (1964) 385).
    """
    reynolds = speed * np.pi / 30.0 * radius_m * gap_m / AIR_VISCOSITY
    vortices = 0.42 * (reynolds**2 * gap_m / radius_m * AIR_PRANDTL) ** 0.25
    return float((1.0 + vortices**4) ** 0.25 * AIR_CONDUCTIVITY / gap_m)


def viscous_torque(f0: Array, nu: Array | float, speed: float) -> Array:
    """Return Palmgren's load-free torque of each bearing [N mm]."""
    product = nu * speed
    size = 1e-7 * f0 * BEARING_DIAMETER**3
    return np.asarray(size * np.where(product < 2000.0, 160.0, np.abs(product) ** (2.0 / 3.0)))


def watts(speed: float, torque: Array) -> Array:
    """Return the heat of a torque [N mm] at a speed [r/min]."""
    return np.asarray(np.pi / 30.0 * 1e-3 * speed * torque)


def vogel_factor(rise: Array, slope: float, temperature: float = 25.0) -> Array:
    """Return nu(T0 + rise) / nu(T0) by Vogel's equation, whose slope at T0 is *slope* [1/K].

    nu ~ exp(B / (T + C)), with C = 110 K as usual for mineral oils; so the slope itself falls
    with temperature, unlike in an exponential.
    """
    c = 110.0
    b = slope * (temperature + c) ** 2
    return np.asarray(np.exp(b / (temperature + c + rise) - b / (temperature + c)))
