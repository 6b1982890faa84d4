"""Film coefficients and bearing friction from the study of the finite-element spindle."""

from __future__ import annotations

import numpy as np
from scipy.constants import g

from plant_model.drawing.films import USUAL_RISE
from studies.finite_elements.description import Bearings

AIR_CONDUCTIVITY, AIR_VISCOSITY, AIR_PRANDTL, MEAN_KELVIN = 0.026, 16e-6, 0.701, 298.0
"""Properties of air and its temperature, given by the study [W/(m K), m2/s, 1, K]."""
RADIATION = 5.0
"""Radiation of a painted surface near room temperature [W/(m2 K)], given by the VDI Heat Atlas,
part K."""


def turning_film(speed: float, diameter_m: float) -> float:
    """Return the film coefficient of a rotating surface [W/(m2 K)].

    Parameters
    ----------
    speed : float
        [r/min]
    diameter_m : float
        Of the surface [m].

    Notes
    -----
    Nu = 0.133 Re^(2/3) Pr^(1/3), Re = u d / nu with the surface speed u. Natural convection at
    standstill and whenever this is smaller.
    """
    reynolds = np.pi * abs(speed) / 60.0 * diameter_m**2 / AIR_VISCOSITY
    nusselt = 0.133 * reynolds ** (2.0 / 3.0) * AIR_PRANDTL ** (1.0 / 3.0)
    return float(max(nusselt * AIR_CONDUCTIVITY / diameter_m, still_film(diameter_m)))


def still_film(diameter_m: float) -> float:
    """Return the film coefficient of a stationary surface [W/(m2 K)], including radiation.

    Notes
    -----
    Nu = 0.53 (Gr Pr)^(1/4), McAdams' law for cylinders in still air, at the usual rise.
    """
    grashof = g * USUAL_RISE * diameter_m**3 / (MEAN_KELVIN * AIR_VISCOSITY**2)
    nusselt = 0.53 * (grashof * AIR_PRANDTL) ** 0.25
    return float(nusselt * AIR_CONDUCTIVITY / diameter_m + RADIATION)


def gap_conductivity(speed: float, radius_m: float, gap_m: float) -> float:
    """Return the effective conductivity of an air gap at a speed [W/(m K)].

    Notes
    -----
    Nu for twice the gap: 2 at rest, 0.128 Ta^0.367 from Ta = 1700, 0.409 Ta^0.241 from 1e4, with
    Ta = omega^2 r s^3 / nu^2; Becker and Kaye, J. Heat Transfer 84 (1962) 97,
    doi:10.1115/1.3684335.
    """
    omega = abs(speed) * np.pi / 30.0
    taylor = omega**2 * radius_m * gap_m**3 / AIR_VISCOSITY**2
    nusselt = 2.0
    if taylor > 1e4:
        nusselt = max(nusselt, 0.409 * taylor**0.241)
    elif taylor > 1700.0:
        nusselt = max(nusselt, 0.128 * taylor**0.367)
    return float(nusselt / 2.0 * AIR_CONDUCTIVITY)


def friction_numbers(bearings: Bearings) -> tuple[float, float, float, float]:
    """Return (a, n0, c, b) of a bearing set's friction heat a n^(5/3) + b n; c n + b n below n0.

    Notes
    -----
    H = 1.047e-4 n (M0 + M1) [W; r/min, N mm]; M1 = f1 P dm; M0 = 1e-7 f0 (nu n)^(2/3) dm^3 for
    nu n >= 2000, else 160e-7 f0 dm^3. Harris and Kotzalas, Essential Concepts of Bearing
    Technology, 5th ed., ch. 10.
    """
    size = bearings.f0 * bearings.mean_diameter_mm**3
    each = 1.047e-4 * bearings.count
    viscous = each * 1e-7 * size * bearings.viscosity_mm2_s ** (2.0 / 3.0)
    slow = each * 160e-7 * size
    load = each * bearings.f1 * bearings.preload_n * bearings.mean_diameter_mm
    return viscous, 2000.0 / bearings.viscosity_mm2_s, slow, load


def friction_heat(speed: float, numbers: tuple[float, float, float, float]) -> float:
    """Return the heat of a source at a speed [W].

    Parameters
    ----------
    speed : float
        With either sign [r/min].
    numbers : tuple of four floats
        From `friction_numbers`.
    """
    n = abs(speed)
    viscous, threshold, slow, load = numbers
    torque_part = viscous * n ** (5.0 / 3.0) if n >= threshold else slow * n
    return torque_part + load * n
