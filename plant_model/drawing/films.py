"""Film coefficients on surfaces and in channels, from the library ``ht`` if it has them."""

from __future__ import annotations

from math import pi

from plant_model.drawing.coolants import Coolant
from plant_model.effects.radiation import STEFAN_BOLTZMANN

AIR = {"conductivity": 0.026, "viscosity": 1.56e-5, "prandtl": 0.71, "expansion": 1.0 / 295.0}
"""Air at 22 degC: [W/(m K)], [m2/s], [1], [1/K]."""

USUAL_RISE = 5.0
"""Temperature rise of a surface above the air for a constant film [K]: set on no data."""


def channel_film(fluid: Coolant, flow_lpm: float, width_mm: float, depth_mm: float) -> float:
    """Return the film coefficient in a rectangular channel [W/(m2 K)].

    ``ht.Nu_conv_internal`` on the hydraulic diameter: Churchill and Zajic if the flow is
    turbulent, 3.66 if it is laminar.
    """
    import ht

    width, depth = width_mm * 1e-3, depth_mm * 1e-3
    diameter = 2.0 * width * depth / (width + depth)
    speed = flow_lpm / 60000.0 / (width * depth)
    reynolds = fluid.density * speed * diameter / fluid.viscosity
    prandtl = fluid.viscosity * fluid.specific_heat / fluid.conductivity
    return float(ht.Nu_conv_internal(reynolds, prandtl)) * fluid.conductivity / diameter


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
