"""Laws of this machine; the base laws have the form that its owner's page claims."""

from __future__ import annotations

import numpy as np

AIR_CONDUCTIVITY = 0.0262  # W/(m K)
AIR_VISCOSITY = 15.7e-6  # m2/s
AIR_PRANDTL = 0.71


def gap_film(speed: float, radius_m: float, gap_m: float) -> float:
    """Return the film between shaft and housing [W/(m2 K)].

    At rest conduction and 4.5 W/(m2 K) of radiation; turning, Nu = 0.44 (Ta Pr)^(1/4) of Aoki,
    Nohira and Arai (Bull. JSME 10 (1967) 523-532) on the gap, Ta = omega^2 r s^3 / nu^2; the two
    joined smoothly.
    """
    omega = abs(speed) * np.pi / 30.0
    taylor = omega**2 * radius_m * gap_m**3 / AIR_VISCOSITY**2
    turning = 0.44 * (taylor * AIR_PRANDTL) ** 0.25
    return float((1.0 + turning**3) ** (1.0 / 3.0) * AIR_CONDUCTIVITY / gap_m + 4.5)


def turning_film(diameter_m: float, speed: float) -> float:
    """Return what turning adds to the film on a cylinder [W/(m2 K)].

    Nu = 0.095 (0.5 Re^2)^0.35 in still air, Re = omega d^2 / (2 nu): Kays and Bjorklund, Trans.
    ASME 80 (1958) 70-78.
    """
    reynolds = abs(speed) * np.pi / 30.0 * diameter_m**2 / (2.0 * AIR_VISCOSITY)
    nusselt = 0.095 * (0.5 * reynolds**2) ** 0.35
    return float(nusselt * AIR_CONDUCTIVITY / diameter_m)


def turning_share(relative: float) -> float:
    """Return `turning_film` at a share of a speed, over that at the speed [1]."""
    return abs(relative) ** 0.7


def viscous_torque(f0: float, nu: float, speed: float, diameter_mm: float) -> float:
    """Return Palmgren's load-free torque of one bearing [N mm]."""
    product = nu * abs(speed)
    factor = 160.0 if product < 2000.0 else product ** (2.0 / 3.0)
    return 1e-7 * f0 * diameter_mm**3 * factor


def watts(speed: float, torque: float) -> float:
    """Return the heat of a torque [N mm] at a speed [r/min]."""
    return np.pi / 30.0 * 1e-3 * abs(speed) * torque


def walther(nu_40: float, nu_100: float, degc: float) -> float:
    """Return the viscosity of a base oil [mm2/s] by Walther's equation, lg lg (nu + 0.8)."""
    t = np.log10(np.array([40.0, 100.0, degc]) + 273.15)
    w = np.log10(np.log10(np.array([nu_40, nu_100]) + 0.8))
    line = w[0] + (w[1] - w[0]) / (t[1] - t[0]) * (t[2] - t[0])
    return float(10.0 ** (10.0**line) - 0.8)
