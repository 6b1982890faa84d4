"""A first page from a few answers: usual proportions around the front bearing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import jinja2

from plant_model.drawing.bearing_table import Bearing
from plant_model.drawing.class_values import CLASS_VALUES
from plant_model.drawing.columns import Columns

ROTOR, STATOR, HOUSING, NOSE = 1.8, 2.7, 3.4, 1.45
"""Diameters relative to the front bearing's bore, as in motor spindles of 40 to 120 mm bore [1]:
set on no named data."""
BELT_KW = 10.0
"""Motor power of the class value of a belt's loss [kW], given by its source: the geometric mean
of its 5 to 20."""

FREE = 15.0
"""Length of housing beyond a bearing [mm]: set on no data."""

USUAL_FEED = 20000.0
"""Highest feed of an axis, unless the run has a higher one [mm/min]: set on no data."""

ALL_SIDES = ("Y+", "Y-", "X+", "X-")
"""In the order in which several thermometers at one place take them."""

AXES = ("x", "y", "z")

BEARINGS = ("front", "rear")

PAGE = Path(__file__).with_name("new_page.txt")


@dataclass(frozen=True)
class Answers:
    """Answers about a machine.

    Attributes
    ----------
    name : str
        Of the machine.
    title : str
        A line that says which machine it is.
    bearing : Bearing
        Front bearing: designation, or its bore in mm.
    speed : float
        Highest speed [r/min].
    power : float
        Power of the motor [kW]; may be left out with a belt.
    coolant : str
        none, water, 'glycol 30 %', 'oil 10' (default: water; none with a belt).
    drive : {"built-in", "belt"}
        How the motor turns the spindle.
    rig : {"five_point", "direct"}
        Displacement sensors.
    lubrication : {"oil-air", "grease", "oil"}
        Of the bearings.
    """

    name: str
    title: str
    bearing: Bearing
    speed: float
    power: float
    coolant: str
    drive: Literal["built-in", "belt"] = "built-in"
    rig: Literal["five_point", "direct"] = "five_point"
    lubrication: Literal["oil-air", "grease", "oil"] = "grease"


@dataclass(frozen=True)
class _Row:
    """Place of a thermometer, empty if not known, and why it must be checked."""

    where: str
    unsure: str


class _Plan:
    """Positions of all parts along the axis [mm]; 0 is the mounting face."""

    def __init__(self, answers: Answers) -> None:
        bearing, belt = answers.bearing, answers.drive == "belt"
        bore, width = bearing.bore, bearing.width
        self.motor_end = 0 if belt else round(40.0 + 100.0 + 6.0 * answers.power)
        behind = 0.0 if belt else self.motor_end + 2.0 * FREE
        self.front = round(behind + width + FREE)
        self.housing_end = round(self.front + width + FREE)
        self.gauge = self.housing_end + round(0.8 * bore)
        # A belt-driven spindle sits inside its headstock, a motor spindle in front of it.
        self.rear = -round(3.5 * bore if belt else width + 2.0 * FREE)
        self.housing_start = round(self.rear - width - FREE)
        self.shaft_start = self.housing_start - (70 if belt else 15)

    def around_housing(self) -> dict[str, float]:
        """Return the places on the housing that thermometers' names refer to [mm]."""
        measures: dict[str, float] = {
            "front": self.front,
            "rear": self.rear,
            "housing": round((self.front + self.rear) / 2.0),
        }
        if self.motor_end:
            measures["motor"] = max(20.0, self.motor_end / 2.0)
        return measures


def _usual_columns(answers: Answers) -> Columns:
    """Return the columns for a page without a run."""
    motor = () if answers.drive == "belt" else ("motor",)
    return Columns(
        speed="speed_rpm",
        ambient="ambient_degC",
        coolant="coolant_inlet_degC",
        thermometers={name: name for name in ("front", "headstock", "column", *motor)},
        five_point=answers.rig == "five_point",
    )


def page_text(answers: Answers, columns: Columns | None, running: Mapping[str, float]) -> str:
    """Return a commented page.

    Parameters
    ----------
    answers : Answers
    columns : Columns, optional
        Columns of a run, whose thermometers and inputs the page then has.
    running : mapping of str to float
        Running temperature of each bearing of `BEARINGS` [degC].
    """
    environment = jinja2.Environment(
        trim_blocks=True, keep_trailing_newline=True, undefined=jinja2.StrictUndefined
    )
    environment.filters |= {"g": "{:g}".format, "g3": "{:.3g}".format}
    columns = columns or _usual_columns(answers)
    plan, bore = _Plan(answers), answers.bearing.bore
    carriers = _carrier_names(columns)
    belt = answers.drive == "belt"
    axes = columns.axes or {"disp_y": ("Y", 1), "disp_z": ("Z", 1)}
    page = environment.from_string(PAGE.read_text(encoding="utf-8"))
    return page.render(
        said=answers,
        plan=plan,
        running=running,
        bore=bore,
        hole=round(0.35 * bore),
        nose=NOSE * bore,
        rotor=ROTOR * bore,
        housing=_housing(plan, answers),
        thermometers=_rows(plan, columns),
        inputs=_inputs(answers, columns),
        # The class value in proportion to the motor's power.
        belt=CLASS_VALUES["belt_loss"].scaled(answers.power / BELT_KW),
        jackets=_jackets(plan, answers),
        carriers=carriers,
        air='air = "enclosure"\n' if "enclosure" in carriers else "",
        mass=round(4.5 * bore),
        holds=(plan.housing_start, 0) if belt else (0, plan.motor_end),
        five_point=columns.five_point,
        axes=", ".join(
            f'{name} = {{ axis = "{axis}", sign = {sign} }}' for name, (axis, sign) in axes.items()
        ),
    )


def unplaced(answers: Answers, columns: Columns) -> list[str]:
    """Return the thermometers of a run that are only remarks in its page, to be placed by hand.

    Parameters
    ----------
    answers : Answers
    columns : Columns
        Columns of the run.
    """
    return [name for name, row in _rows(_Plan(answers), columns).items() if not row.where]


def _rows(plan: _Plan, columns: Columns) -> dict[str, _Row]:
    """Return the place of each thermometer, no two at one place around the housing."""
    rows: dict[str, _Row] = {}
    places, sides = columns.thermometers, columns.sides
    around, carriers = plan.around_housing(), _carrier_names(columns)
    free = {place: list(ALL_SIDES) for place in around}
    # A thermometer without a side in its name comes first, then those next to it.
    first = {place: name for name, place in reversed(places.items()) if name not in sides}
    order = {name: 0 if first.get(places[name]) == name else 2 - (name in sides) for name in places}
    for name, place in sorted(places.items(), key=lambda entry: order[entry[0]]):
        if place in around and free[place]:
            side = sides.get(name, ALL_SIDES[0])
            unsure = place == "housing" or name in sides or side not in free[place]
            side = side if side in free[place] else free[place][0]
            free[place].remove(side)
            where = f'part = "housing", at = {around[place]:g}, side = "{side}"'
            rows[name] = _Row(where, "its name says little of the spot" if unsure else "")
        elif place in carriers:
            rows[name] = _Row(f'part = "{carriers[place]}"', "")
        else:
            rows[name] = _Row("", "")
    return {name: rows[name] for name in places}


def _carrier_names(columns: Columns) -> dict[str, str]:
    """Return the parts with one temperature each, by their names in thermometers' places."""
    parts = {"headstock": "headstock", "column": "column"}
    places = set(columns.thermometers.values())
    parts |= {name: name for name in ("column_top", "enclosure") if name in places}
    if "nut" in places and columns.feeds:
        parts["nut"] = f"{_feed(columns)[1]}_nut"
    return parts


def _feed(columns: Columns) -> tuple[str, str]:
    """Return the feed column that the page uses, and its axis: that of the nut, or else Z."""
    nut = next((name for name, place in columns.thermometers.items() if place == "nut"), "")
    axes = {
        re.split(r"_mm_min$", column)[0].lower().split("_")[-1]: column for column in columns.feeds
    }
    for axis in (*nut.lower().split("_"), "z"):
        if axis in axes and axis in AXES:
            return axes[axis], axis
    axis, column = next(iter(axes.items()))
    return column, axis if axis in AXES else "z"


def _inputs(answers: Answers, columns: Columns) -> list[tuple[str, str, str, float, float, str]]:
    """Return name, unit, column, range and remark of each input."""
    top = max(answers.speed, columns.highest_speed)
    rows = [
        ("speed", "rpm", columns.speed or "speed_rpm", 0.0, top, ""),
        ("ambient", "degC", columns.ambient, -20.0, 60.0, ""),
    ]
    if answers.coolant != "none":
        rows.append(
            ("coolant_inlet", "degC", columns.coolant or "coolant_inlet_degC", 0.0, 60.0, "")
        )
    if columns.torque:
        rows.append(("torque", "Nm", columns.torque, -1000.0, 1000.0, ", default = 0.0"))
    if columns.feeds:
        high = max(USUAL_FEED, columns.highest_feed)
        rows.append(("feed", "mm_min", _feed(columns)[0], 0.0, high, ", default = 0.0"))
    return rows


def _housing(plan: _Plan, answers: Answers) -> list[tuple[float, float, float, float]]:
    """Return start, end, outer and inner diameter of the housing's stretches [mm]."""
    bore, seat = answers.bearing.bore, answers.bearing.outside
    if answers.drive == "belt":
        outer = round(seat + 50.0)
        return [(plan.housing_start, 0, outer, seat), (0, plan.housing_end, outer, seat)]
    outer, stator = round(max(HOUSING * bore, seat + 40.0)), round(STATOR * bore)
    wide = max(outer, stator + 30)
    return [
        (plan.housing_start, 0, outer, seat),
        (0, plan.motor_end, wide, stator),
        (plan.motor_end, plan.housing_end, wide, seat),
    ]


def _jackets(plan: _Plan, answers: Answers) -> list[tuple[str, float, float, int]]:
    """Return name, start, end [mm] and flow [l/min] of the jackets."""
    if answers.coolant == "none":
        return []
    front = ("front", plan.front - answers.bearing.width - FREE, plan.housing_end, 3)
    return [front] if answers.drive == "belt" else [front, ("motor", 10, plan.motor_end - 10, 5)]
