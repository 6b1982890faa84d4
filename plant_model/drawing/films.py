"""Film coefficients on surfaces, from the library ``ht`` if it has them, and in channels."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from plant_model.drawing.coolants import Coolant
from plant_model.effects.radiation import STEFAN_BOLTZMANN

AIR = {"conductivity": 0.026, "viscosity": 1.56e-5, "prandtl": 0.71, "expansion": 1.0 / 295.0}
"""Air at 22 degC: [W/(m K)], [m2/s], [1], [1/K]."""

USUAL_RISE = 5.0
"""Temperature rise of a surface above the air for a constant film [K]: set on no data."""


TURBULENT = 22_000.0
"""Reynolds number from which flow in a coil is fully turbulent [1], given by its law."""


def channel_film(
    fluid: Coolant, flow_lpm: float, width_mm: float, depth_mm: float, coil_mm: float
) -> float:
    """Return the film coefficient in a rectangular channel wound around a cylinder [W/(m2 K)].

    Parameters
    ----------
    fluid : Coolant
    flow_lpm : float
        [l/min].
    width_mm, depth_mm : float
        Of the channel [mm].
    coil_mm : float
        Mean diameter of its windings [mm].

    Notes
    -----
    Gnielinski's law for coils on the hydraulic diameter d: Proc. 8th Int. Heat Transfer Conf. 6
    (1986) 2847-2854, also in the VDI Heat Atlas. A channel of diameter D bends the flow, which
    mixes it long before it is turbulent: laminar up to 2300 (1 + 8.6 (d/D)^0.45), turbulent from
    22,000 on, linear in the Reynolds number between. Without the correction for a warm wall.
    """
    width, depth = width_mm * 1e-3, depth_mm * 1e-3
    diameter = 2.0 * width * depth / (width + depth)
    speed = flow_lpm / 60000.0 / (width * depth)
    reynolds = fluid.density * speed * diameter / fluid.viscosity
    prandtl = fluid.viscosity * fluid.specific_heat / fluid.conductivity
    bend = diameter / (coil_mm * 1e-3)
    critical = min(2300.0 * (1.0 + 8.6 * float(bend**0.45)), TURBULENT)
    ends = _laminar(min(reynolds, critical), prandtl, bend), _turbulent(reynolds, prandtl, bend)
    nusselt = float(np.interp(reynolds, [critical, TURBULENT], ends))
    return nusselt * fluid.conductivity / diameter


def _laminar(reynolds: float, prandtl: float, bend: float) -> float:
    """Return the Nusselt number of laminar flow in a coil [1]."""
    power = reynolds ** (0.5 + 0.2903 * bend**0.194) * prandtl ** (1.0 / 3.0)
    return float(3.66 + 0.08 * (1.0 + 0.8 * bend**0.9) * power)


def _turbulent(reynolds: float, prandtl: float, bend: float) -> float:
    """Return the Nusselt number of turbulent flow in a coil, from `TURBULENT` on [1]."""
    reynolds = max(reynolds, TURBULENT)
    drag = (0.3164 / reynolds**0.25 + 0.03 * sqrt(bend)) / 8.0
    near_wall = 12.7 * sqrt(drag) * (prandtl ** (2.0 / 3.0) - 1.0)
    return float(drag * reynolds * prandtl / (1.0 + near_wall))


def still_air(diameter_mm: float, emissivity: float) -> float:
    """Return free convection and radiation of a cylinder in still air [W/(m2 K)].

    ``ht.Nu_horizontal_cylinder`` (Morgan) at a rise of 5 K; 4 eps sigma T^3 at 22 degC.
    """
    import ht

    diameter = diameter_mm * 1e-3
    grashof = 9.81 * AIR["expansion"] * USUAL_RISE * diameter**3 / AIR["viscosity"] ** 2
    free = ht.Nu_horizontal_cylinder(AIR["prandtl"], grashof) * AIR["conductivity"] / diameter
    return float(free) + 4.0 * emissivity * STEFAN_BOLTZMANN * 295.15**3


def blown(diameter_mm: float, speed_m_per_s: float) -> float:
    """Return the film coefficient of air blowing across a cylinder [W/(m2 K)].

    ``ht.Nu_external_cylinder`` (Sanitjai and Goldstein).
    """
    import ht

    diameter = diameter_mm * 1e-3
    reynolds = speed_m_per_s * diameter / AIR["viscosity"]
    return float(ht.Nu_external_cylinder(reynolds, AIR["prandtl"])) * AIR["conductivity"] / diameter


def turning(diameter_mm: float, speed_rpm: float) -> float:
    """Return the increase of a cylinder's film coefficient by rotation [W/(m2 K)].

    Nu = 0.133 Re^(2/3) Pr^(1/3), Re = u d / nu: Becker, Int. J. Heat Mass Transfer 6 (1963)
    1053-1062; ``ht`` does not have it.
    """
    diameter = diameter_mm * 1e-3
    reynolds = pi * diameter**2 * abs(speed_rpm) / 60.0 / AIR["viscosity"]
    nusselt = 0.133 * reynolds ** (2.0 / 3.0) * AIR["prandtl"] ** (1.0 / 3.0)
    return float(nusselt * AIR["conductivity"] / diameter)
