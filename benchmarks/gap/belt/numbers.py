"""The numbers of one particular machine: its drawing, and what no drawing tells.

A drawing is known to whoever writes the machine's page. What it does not tell (joints, films,
friction) is drawn anew for every machine, about the values that handbooks give for the class.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

Numbers = dict[str, float]

SPREAD = {
    "material": (0.03, 0.06),
    "mass": (0.05, 0.12),
    "joint": (0.3, 0.7),
    "film": (0.2, 0.45),
    "friction": (0.25, 0.5),
    "share": (0.05, 0.1),
    "size": (0.02, 0.04),
}
"""Standard deviation of the logarithm and the largest deviation allowed, by kind of number."""

HIDDEN: dict[str, tuple[float, str]] = {
    # Steel and cast iron: heat capacity [J/(m3 K)], conductivity [W/(m K)], growth [1e-6/K].
    "heat_steel": (3.68e6, "material"),
    "heat_iron": (3.6e6, "material"),
    "k_steel": (45.0, "material"),
    "k_iron": (50.0, "material"),
    "alpha_steel": (11.5, "material"),
    "alpha_iron": (10.5, "material"),
    # Joints: seats and pulley [W/(m2 K)], the others [W/K].
    "seat": (5000.0, "joint"),
    "pulley_seat": (2500.0, "joint"),
    "balls": (12.5, "joint"),
    "balls_front": (2.2, "share"),
    "balls_rear": (1.0, "share"),
    "clamp": (45.0, "joint"),
    "guide": (11.0, "joint"),
    "bolts": (16.0, "joint"),
    "nut_joint": (9.0, "joint"),
    "taper": (0.9, "joint"),
    # How well headstock and column even out along themselves [W/K from end to end].
    "along_headstock": (170.0, "share"),
    "along_column": (110.0, "share"),
    # Films [W/(m2 K)]; the first is common to all surfaces in still air.
    "still": (8.5, "film"),
    "still_housing": (1.0, "share"),
    "still_headstock": (1.0, "share"),
    "still_column": (1.0, "share"),
    "turning": (1.0, "film"),
    "walls": (6.0, "film"),
    "air_heat": (3.8e4, "film"),
    "gap": (1.0, "film"),
    # Heat: f0 and f1 of ball and roller bearings, preload [N], oil at running temperature [mm2/s].
    "f0_front": (0.6, "friction"),
    "f0_rear": (0.8, "friction"),
    "f1_front": (0.001, "share"),
    "f1_rear": (0.0003, "share"),
    "preload_front": (420.0, "friction"),
    "preload_rear": (350.0, "friction"),
    "viscosity": (12.0, "share"),
    "inner_share": (0.5, "share"),
    # Belt [W/(1000 r/min)] and feed axis [W/(m/min)].
    "belt": (11.0, "friction"),
    "pulley_share": (0.5, "share"),
    "feed": (16.0, "friction"),
}
"""Class value and kind of every number that the drawing does not tell."""


@dataclass(frozen=True)
class Body:
    """A casting or a lump: mass [kg] and surface in the air [m2]."""

    mass: float
    surface: float


@dataclass(frozen=True)
class Stretch:
    """A piece of shaft or housing [mm]."""

    start: float
    end: float
    outer: float
    inner: float


@dataclass(frozen=True)
class Drawing:
    """What the drawing tells; lengths in mm along the axis from the mounting face to the nose.

    Attributes
    ----------
    shaft, housing : tuple of Stretch
    front, rear : tuple of (float, float)
        Where each bearing sits.
    bores, outsides : tuple of float
        Of the front and the rear bearings.
    pulley : Stretch
    clamp : tuple of float
        Where the headstock holds the housing.
    bodies : dict of str to Body
        ``headstock``, ``column_top``, ``column``, ``z_nut``.
    tool_length, tool_diameter : float
    volume, walls : float
        Of the enclosure [m3, m2].
    grows_y, grows_z : float
        Headstock that moves the nose.
    bend_width, bend_length, bend_lever : float
        Headstock against the column behind it.
    """

    shaft: tuple[Stretch, ...]
    housing: tuple[Stretch, ...]
    front: tuple[tuple[float, float], ...]
    rear: tuple[tuple[float, float], ...]
    bores: tuple[float, float]
    outsides: tuple[float, float]
    pulley: Stretch
    clamp: tuple[float, float]
    bodies: dict[str, Body]
    tool_length: float
    tool_diameter: float
    volume: float
    walls: float
    grows_y: float
    grows_z: float
    bend_width: float
    bend_length: float
    bend_lever: float

    @property
    def gauge_line(self) -> float:
        """The end of the shaft [mm]."""
        return self.shaft[-1].end


FRONT_AT, REAR_AT = 22.0, -200.0
"""Middles of the bearing sets, which thermometers sit over, too [mm]."""

YAW = 0.25
"""How far the headstock bends sideways, of how far it bends upwards [1]."""


def about(rng: np.random.Generator, value: float, kind: str) -> float:
    """Return a number of a kind, drawn about its class value."""
    deviation, most = SPREAD[kind]
    return value * float(np.exp(np.clip(deviation * rng.standard_normal(), -most, most)))


def draw_hidden(
    rng: np.random.Generator, table: Mapping[str, tuple[float, str]] = HIDDEN
) -> Numbers:
    """Return what no drawing tells, for one machine of the class."""
    return {name: about(rng, value, kind) for name, (value, kind) in table.items()}


def draw_drawing(rng: np.random.Generator) -> Drawing:
    """Return the drawing of one machine of the class: a milling spindle of 8,000 r/min."""

    def size(value: float) -> float:
        return float(round(about(rng, value, "size")))

    def body(mass: float, surface: float) -> Body:
        return Body(round(about(rng, mass, "mass"), 1), round(about(rng, surface, "mass"), 2))

    barrel, flange, nose, end = size(135.0), size(178.0), size(88.0), size(85.0)
    return Drawing(
        shaft=(
            Stretch(-330.0, -170.0, 55.0, 24.0),
            Stretch(-170.0, 45.0, 60.0, 24.0),
            Stretch(45.0, end, nose, 36.0),
        ),
        housing=(
            Stretch(-240.0, -160.0, barrel - 6.0, 90.0),
            Stretch(-160.0, 0.0, barrel, 104.0),
            Stretch(0.0, 45.0, flange, 95.0),
        ),
        front=((4.0, 22.0), (22.0, 40.0)),
        rear=((-213.0, -187.0),),
        bores=(60.0, 55.0),
        outsides=(95.0, 90.0),
        pulley=Stretch(-325.0, -275.0, size(105.0), 55.0),
        clamp=(-230.0, 0.0),
        bodies={
            "headstock": body(240.0, 2.0),
            "column_top": body(330.0, 1.6),
            "column": body(850.0, 2.7),
            "z_nut": body(13.0, 0.12),
        },
        tool_length=size(110.0),
        tool_diameter=32.0,
        volume=2.0,
        walls=round(about(rng, 9.0, "mass"), 2),
        grows_y=size(260.0),
        grows_z=size(55.0),
        bend_width=size(360.0),
        bend_length=size(280.0),
        bend_lever=size(330.0),
    )
