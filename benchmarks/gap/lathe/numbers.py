"""The numbers of one lathe: its parts as drawn, and what no drawing tells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.gap.belt.numbers import about

HIDDEN: dict[str, tuple[float, str]] = {
    "heat_steel": (470.0, "material"),
    "heat_iron": (500.0, "material"),
    "alpha_steel": (11.5, "material"),
    "alpha_iron": (10.5, "material"),
    # How well bars even out along themselves [W/K from end to end].
    "along_spindle": (1.1, "share"),
    "along_headstock": (14.0, "share"),
    "along_bed": (6.5, "share"),
    "along_carriage": (25.0, "share"),
    "along_slide": (25.0, "share"),
    "along_z_screw": (0.9, "share"),
    "along_x_screw": (0.9, "share"),
    # Joints [W/K].
    "seat_shaft": (60.0, "joint"),
    "seat": (70.0, "joint"),
    "balls": (20.0, "joint"),
    "foot": (45.0, "joint"),
    "z_guide": (30.0, "joint"),
    "x_guide": (25.0, "joint"),
    "z_nut_joint": (14.0, "joint"),
    "x_nut_joint": (12.0, "joint"),
    "z_motor_joint": (8.0, "joint"),
    "x_motor_joint": (7.0, "joint"),
    "z_screw_ends": (3.0, "joint"),
    "x_screw_ends": (3.0, "joint"),
    "z_ball": (6.0, "joint"),
    "x_ball": (6.0, "joint"),
    "motor_foot": (5.0, "joint"),
    # Films [W/(m2 K)], openings of the enclosure [W/K], the air inside with its sheet metal [J/K].
    "hall": (8.0, "film"),
    "inside": (8.0, "film"),
    "chuck": (25.0, "film"),
    "walls": (45.0, "film"),
    "air_heat": (6.0e4, "film"),
    # Heat.
    "f0_front": (1.0, "friction"),
    "f0_rear": (1.0, "friction"),
    "f1_front": (0.001, "share"),
    "f1_rear": (0.001, "share"),
    "preload_front": (1000.0, "friction"),
    "preload_rear": (900.0, "friction"),
    "viscosity": (28.0, "share"),
    "inner_share": (0.5, "share"),
    "motor": (40.0, "friction"),
    "z_nut_loss": (10.0, "friction"),
    "z_screw_loss": (6.0, "friction"),
    "z_motor_loss": (12.0, "friction"),
    "x_nut_loss": (8.0, "friction"),
    "x_screw_loss": (4.0, "friction"),
    "x_motor_loss": (9.0, "friction"),
}
"""Class value and kind of every number that the drawing does not tell."""

COUNTS, DIAMETERS = (2, 1), (95.0, 90.0)
"""Bearings of the front and the rear set, and their mean diameters [mm]."""


@dataclass(frozen=True)
class Part:
    """A part of the lathe.

    Attributes
    ----------
    mass : float
        [kg]
    surface : float
        In its air [m2].
    air : str
        ``hall`` or ``inside``.
    cells : int
        Fine stretches.
    metal : str
    """

    mass: float
    surface: float
    air: str
    cells: int
    metal: str = "iron"


PARTS = {
    "spindle": Part(34.0, 0.0, "inside", 18, "steel"),
    "headstock": Part(330.0, 1.6, "hall", 12),
    "bed": Part(1500.0, 4.6, "hall", 24),
    "carriage": Part(170.0, 0.9, "inside", 4),
    "slide": Part(130.0, 0.8, "inside", 4),
    "z_nut": Part(6.0, 0.05, "inside", 1, "steel"),
    "z_screw": Part(9.0, 0.12, "inside", 12, "steel"),
    "z_motor": Part(11.0, 0.25, "hall", 1, "steel"),
    "x_nut": Part(5.0, 0.04, "inside", 1, "steel"),
    "x_screw": Part(4.0, 0.06, "inside", 6, "steel"),
    "x_motor": Part(9.0, 0.2, "inside", 1, "steel"),
    "spindle_motor": Part(55.0, 0.7, "hall", 1, "steel"),
}
"""The class."""

LENGTHS = {
    "spindle": 150.0,
    "headstock_z": 230.0,
    "headstock_x": 310.0,
    "bed": 450.0,
    "z_screw": 320.0,
    "slide": 120.0,
    "x_screw": 90.0,
}
"""Of what moves tool against work [mm], of the class."""


@dataclass(frozen=True)
class Drawing:
    """What the drawing tells: parts, and lengths of what moves tool against work [mm]."""

    parts: dict[str, Part]
    lengths: dict[str, float]


def draw_drawing(rng: np.random.Generator) -> Drawing:
    """Return the drawing of one lathe of the class."""
    parts = {
        name: Part(
            round(about(rng, one.mass, "mass"), 1),
            round(about(rng, one.surface, "mass"), 3),
            one.air,
            one.cells,
            one.metal,
        )
        for name, one in PARTS.items()
    }
    lengths = {name: float(round(about(rng, value, "mass"))) for name, value in LENGTHS.items()}
    return Drawing(parts, lengths)
