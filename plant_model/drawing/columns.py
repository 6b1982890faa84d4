"""What a run's columns say about a machine: inputs, thermometers and the rig."""

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
"""Words for coolant that comes back, and so is no inlet."""

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
"""What a part of a column's name says of where its thermometer sits."""

OF_A_FEED = {*"xyzabcuvw", "axis", "achse", "feed", "vorschub", "servo"}
"""Words for an axis: a motor whose name has one does not turn the spindle."""

TOP = {"top", "upper", "oben"}
"""Words for the upper part of a column that has a thermometer below, too."""

SIDES = {
    **dict.fromkeys(("above", "oben"), "Y+"),
    **dict.fromkeys(("below", "unten"), "Y-"),
    **dict.fromkeys(("right", "rechts"), "X+"),
    **dict.fromkeys(("left", "links"), "X-"),
}
"""What a part of a column's name says of the side; which axis that is, is to be checked."""


@dataclass(frozen=True, kw_only=True)
class Columns:
    """The columns of a run by what they are.

    Attributes
    ----------
    speed, ambient, coolant, torque : str
        Columns; empty where the run has none.
    feeds : tuple of str
        Feed columns.
    thermometers : dict of str to str
        Name and where it sits: one of `PARTS`' values, or ``column_top`` beside ``column``; empty
        where the name does not say.
    sides : dict of str to str
        Name and side, where the name says one.
    not_names : tuple of str
        Columns of thermometers that a page cannot name: `NAME` is what it can.
    five_point : bool
        Whether the run has ``S1_um`` to ``S5_um``.
    axes : dict of str to (str, int)
        Else: displacement, its axis and sign.
    highest_speed : float
        [r/min].
    highest_feed : float
        Of all feed columns [mm/min].
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
    """Return what a run's columns are, by their endings and names.

    Parameters
    ----------
    run : Run
    ambient : str, optional
        The run's column of the hall's air, where its name does not say so.
    inlet : str, optional
        The run's column of the coolant's inlet, where its name does not say so.

    Raises
    ------
    BadInput
        For a column that is not there, or when no column can be the hall's air.
    """
    source = run.path or run.name
    warm = run.temperatures
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
    not_names = tuple(column for column in others if not re.match(NAME, split_column(column)[0]))
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
    """Return what names say of the axes; where they say nothing, a guess that is to be checked."""
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
    place = next((PARTS[word] for word in words if word in PARTS), "")
    return "" if place == "motor" and OF_A_FEED & set(words) else place


def _in_two(places: dict[str, str]) -> dict[str, str]:
    """Return the places with a column in two parts, where one thermometer of several is on top."""
    on_it = {name for name, place in places.items() if place == "column"}
    top = {name for name in on_it if TOP & set(_words(name))}
    return places | dict.fromkeys(top if top < on_it else (), "column_top")
