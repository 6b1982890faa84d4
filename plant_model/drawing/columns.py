"""Inputs, thermometers and rig of a machine from the columns of a run."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from measurement.errors import BadInput
from measurement.rig import DirectRig, default_rig
from measurement.runs import Run
from measurement.units import split_column
from plant_model.machine_forms import NAME

FIVE = tuple(f"S{k}_um" for k in range(1, 6))

AIR = (
    *("ambient", "amb", "hall", "room", "air", "environment", "env"),
    *("umgebung", "halle", "hallenluft", "raum", "luft"),
)
INLET = (
    *("inlet", "supply", "coolant", "cooling", "water", "chiller"),
    *("vorlauf", "kuehlmittel", "kuehlwasser"),
)

BACK = {"return", "outlet", "out", "ruecklauf", "auslauf"}
"""Words for returning coolant, which is not an inlet."""

PARTS = {
    "front": "front",
    "nose": "front",
    "rear": "rear",
    "back": "rear",
    "motor": "motor",
    "stator": "motor",
    "headstock": "headstock",
    "head": "headstock",
    "column": "column",
    "stand": "column",
    "vorn": "front",
    "vorne": "front",
    "hinten": "rear",
    "spindelkasten": "headstock",
    "spindelstock": "headstock",
    "staender": "column",
    "housing": "housing",
    "gehaeuse": "housing",
    "nut": "nut",
    "mutter": "nut",
    "enclosure": "enclosure",
    "inside": "enclosure",
    "cabin": "enclosure",
    "innenraum": "enclosure",
    "kabine": "enclosure",
}
"""Place of a thermometer by a word of its column's name."""

OF_A_FEED = {*"xyzabcuvw", "axis", "achse", "feed", "vorschub", "servo"}
"""Words for an axis: a motor with one of them in its name does not drive the spindle."""

TOP = {"top", "upper", "oben"}
"""Words for the upper part of a column that also has a thermometer below."""

SIDES = {
    **dict.fromkeys(("above", "oben"), "Y+"),
    **dict.fromkeys(("below", "unten"), "Y-"),
    **dict.fromkeys(("right", "rechts"), "X+"),
    **dict.fromkeys(("left", "links"), "X-"),
}
"""Side of a thermometer by a word of its column's name; the user must check the axis."""


@dataclass(frozen=True, kw_only=True)
class Columns:
    """The columns of a run by their role.

    Attributes
    ----------
    speed, ambient, coolant, torque : str
        Columns; empty if the run has none.
    feeds : tuple of str
        Feed columns.
    thermometers : dict of str to str
        Place by name: one of the values of `PARTS`, or ``column_top`` next to ``column``; empty
        if the name does not give it.
    sides : dict of str to str
        Side by name, if the name gives one.
    not_names : tuple of str
        Columns of thermometers whose names a page cannot use, because they do not match `NAME`.
    five_point : bool
        Whether the run has ``S1_um`` to ``S5_um``.
    axes : dict of str to (str, int)
        Otherwise: axis and sign by displacement.
    highest_speed : float
        [r/min].
    highest_feed : float
        Highest feed in all feed columns [mm/min].
    """

    speed: str
    ambient: str
    coolant: str
    torque: str = ""
    feeds: tuple[str, ...] = ()
    thermometers: dict[str, str]
    sides: dict[str, str] = field(default_factory=dict)
    not_names: tuple[str, ...] = ()
    five_point: bool
    axes: dict[str, tuple[str, int]] = field(default_factory=dict)
    highest_speed: float = 0.0
    highest_feed: float = 0.0


def columns_of(run: Run, ambient: str | None = None, inlet: str | None = None) -> Columns:
    """Return the roles of a run's columns, by their endings and names.

    Parameters
    ----------
    run : Run
    ambient : str, optional
        The run's column of the hall's air, if its name does not show it.
    inlet : str, optional
        The run's column of the coolant inlet, if its name does not show it.

    Raises
    ------
    BadInput
        For a missing column, or if no column can be the hall's air.
    """
    source = run.path or run.name
    warm = run.temperatures
    if not warm:
        raise BadInput(source, "", "has no temperature column (_degC): the hall's air is needed")
    for option, given in (("--ambient", ambient), ("--inlet", inlet)):
        if given is not None and given not in warm:
            raise BadInput(option, "", f"{given} is not one of {', '.join(warm)}")
    around = [name for name in warm if _place(name) != "enclosure"]
    air = ambient or _named(around, AIR)
    if not air:
        raise BadInput(
            source, "", f"which column is the hall's air? Say --ambient, one of {', '.join(warm)}"
        )
    inlet = inlet or _named(
        [name for name in around if name != air and not BACK & set(_words(name))], INLET
    )
    speeds, torques = run.of_unit("rpm"), run.of_unit("Nm")
    others = [column for column in warm if column not in {air, inlet}]
    not_names = tuple(
        column for column in others if not re.fullmatch(NAME, split_column(column)[0])
    )
    names = (split_column(column)[0] for column in others if column not in not_names)
    places = {name: _place(name) for name in names}
    five = all(column in run.frame.columns for column in FIVE)
    axes = {} if five or not run.displacements else _axes(run)
    feeds = run.of_unit("mm_min")
    return Columns(
        speed=speeds[0] if speeds else "",
        ambient=air,
        coolant=inlet,
        torque=torques[0] if torques else "",
        feeds=tuple(feeds),
        thermometers=_in_two(places),
        sides={name: SIDES[word] for name in places for word in _words(name) if word in SIDES},
        not_names=not_names,
        five_point=five,
        axes=axes,
        highest_speed=_highest(run, speeds[:1]),
        highest_feed=_highest(run, feeds),
    )


def _highest(run: Run, columns: list[str]) -> float:
    return max((float(run.frame[column].abs().max()) for column in columns), default=0.0)


def _axes(run: Run) -> dict[str, tuple[str, int]]:
    """Return the axes from the names of displacements, or else a guess for the user to check."""
    try:
        rig = default_rig(run)
    except BadInput:
        names = (split_column(column)[0] for column in run.displacements)
        return {name: (axis, 1) for name, axis in zip(names, "ZXY", strict=False)}
    assert isinstance(rig, DirectRig)
    return {name: (entry.axis, entry.sign) for name, entry in rig.axes.items()}


def _words(name: str) -> list[str]:
    return [word for word in re.split(r"[_\d\W]+", name.lower()) if word]


def _named(columns: list[str], words: tuple[str, ...]) -> str:
    return next((column for column in columns if set(_words(column)) & set(words)), "")


def _place(name: str) -> str:
    words = _words(name)
    places = [PARTS[word] for word in words if word in PARTS]
    place = min(places, key="housing".__eq__, default="")  # which any other word says better
    return "" if place == "motor" and OF_A_FEED & set(words) else place


def _in_two(places: dict[str, str]) -> dict[str, str]:
    """Return the places, with the column split in two if one of its thermometers is on top."""
    on_it = {name for name, place in places.items() if place == "column"}
    top = {name for name in on_it if TOP & set(_words(name))}
    return places | dict.fromkeys(top if top < on_it else (), "column_top")
