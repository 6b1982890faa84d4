"""The numbers of one lathe: its parts as drawn, and what no drawing tells."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.gap.belt.numbers import CLASS as BELTS
from benchmarks.gap.numbers import Class, tables

TABLES = tables(__file__)
CLASS = Class(TABLES["numbers"], BELTS.spread)
"""With what no drawing tells."""

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
    metal: str


PARTS = {name: Part(*row) for name, row in TABLES["parts"].items()}
"""The class."""


@dataclass(frozen=True)
class Member:
    """What moves tool against work.

    Attributes
    ----------
    part : str
    low, high : float
        From where to where of the part [1].
    axis : str
        ``elongation`` or ``x``.
    sign : float
    length : float
        [mm]
    lumps : list of str
        Of the owner's file.
    """

    part: str
    low: float
    high: float
    axis: str
    sign: float
    length: float
    lumps: list[str]


MEMBERS = {name: Member(*row) for name, row in TABLES["members"].items()}
"""The class."""


@dataclass(frozen=True)
class Drawing:
    """What the drawing tells: parts, and what moves tool against work."""

    parts: dict[str, Part]
    members: dict[str, Member]


def draw_drawing(rng: np.random.Generator) -> Drawing:
    """Return the drawing of one lathe of the class."""

    def mass(value: float, digits: int) -> float:
        return round(CLASS.about(rng, value, "mass"), digits)

    parts = {
        name: replace(one, mass=mass(one.mass, 1), surface=mass(one.surface, 3))
        for name, one in PARTS.items()
    }
    return Drawing(
        parts, {name: replace(one, length=mass(one.length, 0)) for name, one in MEMBERS.items()}
    )
