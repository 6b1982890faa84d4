"""The numbers of one particular machine: its drawing, and what no drawing tells.

A drawing is known to whoever writes the machine's page. What it does not tell (joints, films,
friction) is drawn anew for every machine, about the values that handbooks give for the class.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.gap.numbers import Class, tables

CLASS = Class(**tables(__file__))
"""With what no drawing tells."""


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


def draw_drawing(rng: np.random.Generator) -> Drawing:
    """Return the drawing of one machine of the class: a milling spindle of 8,000 r/min."""

    def size(value: float) -> float:
        return float(round(CLASS.about(rng, value, "size")))

    def body(mass: float, surface: float) -> Body:
        return Body(
            round(CLASS.about(rng, mass, "mass"), 1), round(CLASS.about(rng, surface, "mass"), 2)
        )

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
        walls=round(CLASS.about(rng, 9.0, "mass"), 2),
        grows_y=size(260.0),
        grows_z=size(55.0),
        bend_width=size(360.0),
        bend_length=size(280.0),
        bend_lever=size(330.0),
    )
