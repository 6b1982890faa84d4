"""A first page from a handful of answers: usual proportions around the front bearing."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from plant_model.drawing.bearing_table import Bearing
from plant_model.drawing.class_values import CLASS_VALUES
from plant_model.drawing.columns import Columns

# Diameters relative to the front bearing's bore, as in motor spindles of 40 to 120 mm bore.
ROTOR, STATOR, HOUSING, NOSE = 1.8, 2.7, 3.4, 1.45
BELT_KW = 10.0
"""Motor power for which the class has its loss of a belt [kW]: the middle of its 5 to 20."""

FREE = 15.0
"""Housing beyond a bearing [mm]."""

USUAL_FEED = 20000.0
"""Highest feed of an axis, unless the run has a higher one [mm/min]."""

ALL_SIDES = ("Y+", "Y-", "X+", "X-")
"""In the order in which thermometers of one place take them."""

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Answers:
    """What must be said of a machine.

    Attributes
    ----------
    name, title : str
    bearing : Bearing
        Of the front set.
    speed : float
        Highest [r/min].
    power : float
        Of the motor [kW]; 0 where a belt's is not said.
    drive : {"built-in", "belt"}
    coolant : str
        ``none``, or a coolant's name.
    rig : {"five_point", "direct"}
    lubrication : {"oil-air", "grease", "oil"}
    """

    name: str
    title: str
    bearing: Bearing
    speed: float
    power: float
    drive: Literal["built-in", "belt"]
    coolant: str
    rig: Literal["five_point", "direct"]
    lubrication: Literal["oil-air", "grease", "oil"]


@dataclass(frozen=True)
class _Row:
    """Where a thermometer sits, empty if that is not known, and why that is to be checked."""

    where: str
    unsure: str


class _Plan:
    """Where everything goes along the axis [mm]; 0 is the mounting face."""

    def __init__(self, answers: Answers) -> None:
        bearing = answers.bearing
        bore, width = bearing.bore, bearing.width
        self.motor_end = round(40.0 + 100.0 + 6.0 * answers.power) if self._has(answers) else 0
        behind = 0.0 if answers.drive == "belt" else self.motor_end + 2.0 * FREE
        self.front = round(behind + width + FREE)
        self.housing_end = round(self.front + width + FREE)
        self.gauge = self.housing_end + round(0.8 * bore)
        # A belt-driven spindle stands in its headstock, a motor spindle hangs in front of it.
        self.rear = -round(3.5 * bore if answers.drive == "belt" else width + 2.0 * FREE)
        self.housing_start = round(self.rear - width - FREE)
        self.shaft_start = self.housing_start - (70 if answers.drive == "belt" else 15)

    def around_housing(self, answers: Answers) -> dict[str, float]:
        """Return the places on the housing that names of thermometers tell [mm]."""
        found: dict[str, float] = {
            "front": self.front,
            "rear": self.rear,
            "housing": round((self.front + self.rear) / 2.0),
        }
        if self._has(answers):
            found["motor"] = max(20.0, self.motor_end / 2.0)
        return found

    @staticmethod
    def _has(answers: Answers) -> bool:
        return answers.drive == "built-in"


def page_text(answers: Answers, columns: Columns | None) -> str:
    """Return a commented page.

    Parameters
    ----------
    answers : Answers
    columns : Columns, optional
        Of a run, whose thermometers and inputs the page then has.
    """
    plan = _Plan(answers)
    parts = [
        _head(answers),
        _thermometers(plan, answers, columns),
        _inputs(answers, columns),
        _spindle(plan, answers, columns),
        _bearings(plan, answers),
        _motor(plan, answers),
        _jackets(plan, answers),
        _carriers(plan, answers, columns),
        _enclosure(columns),
        _rig(answers, columns),
    ]
    return "\n".join(part for part in parts if part)


def _head(answers: Answers) -> str:
    return f"""\
# {answers.title}
#
# Lengths in mm along the axis, from the mounting face towards the nose; masses in kg, flows in
# l/min. Lines with CHECK are of usual proportions, not of your drawing: put yours in. Any number
# may be a table {{ value = 24, low = 15, high = 40, source = "plate" }}; docs/drawing.md says which
# may be left out.
# See it to scale: spindle-drift show-machine FILE

format = 1
kind = "drawing"
name = "{answers.name}"
title = "{answers.title}"
"""


def unplaced(answers: Answers, columns: Columns) -> list[str]:
    """Return the thermometers of a run that its page has only as remarks, to be placed by hand.

    Parameters
    ----------
    answers : Answers
    columns : Columns
        Of the run.
    """
    return [name for name, row in _rows(_Plan(answers), answers, columns).items() if not row.where]


def _rows(plan: _Plan, answers: Answers, columns: Columns | None) -> dict[str, _Row]:
    """Return where each thermometer sits, no two around the housing on one spot."""
    found: dict[str, _Row] = {}
    if columns is None:
        motor = () if answers.drive == "belt" else ("motor",)
        places = {name: name for name in ("front", "headstock", "column", *motor)}
    else:
        places = columns.thermometers
    sides = columns.sides if columns else {}
    around = plan.around_housing(answers)
    carriers = _carrier_names(columns)
    free = {place: list(ALL_SIDES) for place in around}
    # One whose name says no side comes first, those that sit beside it next.
    first = {place: name for name, place in reversed(places.items()) if name not in sides}
    order = {name: 0 if first.get(places[name]) == name else 2 - (name in sides) for name in places}
    for name, place in sorted(places.items(), key=lambda entry: order[entry[0]]):
        if place in around and free[place]:
            side = sides.get(name, ALL_SIDES[0])
            unsure = place == "housing" or name in sides or side not in free[place]
            side = side if side in free[place] else free[place][0]
            free[place].remove(side)
            where = f'part = "housing", at = {around[place]:g}, side = "{side}"'
            found[name] = _Row(where, "its name says little of the spot" if unsure else "")
        elif place in carriers:
            found[name] = _Row(f'part = "{carriers[place]}"', "")
        else:
            found[name] = _Row("", "")
    return {name: found[name] for name in places}


def _carrier_names(columns: Columns | None) -> dict[str, str]:
    """Return the parts that are one temperature each, by what thermometers' places call them."""
    found = {"headstock": "headstock", "column": "column"}
    places = set(columns.thermometers.values()) if columns else set()
    if "column_top" in places:
        found["column_top"] = "column_top"
    if "enclosure" in places:
        found["enclosure"] = "enclosure"
    if columns and "nut" in places and columns.feeds:
        found["nut"] = f"{_feed(columns)[1]}_nut"
    return found


def _feed(columns: Columns) -> tuple[str, str]:
    """Return the feed column that the page takes, and its axis: that of the nut, or else Z."""
    nut = next((name for name, place in columns.thermometers.items() if place == "nut"), "")
    axes = {
        re.split(r"_mm_min$", column)[0].lower().split("_")[-1]: column for column in columns.feeds
    }
    for axis in (*nut.lower().split("_"), "z"):
        if axis in axes and axis in AXES:
            return axes[axis], axis
    axis, column = next(iter(axes.items()))
    return column, axis if axis in AXES else "z"


def _thermometers(plan: _Plan, answers: Answers, columns: Columns | None) -> str:
    lines = ["# CHECK: where each thermometer sits; sides are X+, X-, Y+, Y- or degrees from X+."]
    lines.append("thermometers = [")
    for name, row in _rows(plan, answers, columns).items():
        unsure = f"  # CHECK: {row.unsure}" if row.unsure else ""
        lines.append(f'  {{ name = "{name}", {row.where} }},{unsure}')
        if not row.where:
            where = f'part = "housing", at = {plan.front:g}, side = "Y+"'
            lines[-1] = f'  # {{ name = "{name}", {where} }},  # CHECK: place it, then uncomment it'
    return "\n".join([*lines, "]", ""])


def _inputs(answers: Answers, columns: Columns | None) -> str:
    has = columns
    top = max(answers.speed, has.highest_speed if has else 0.0)
    rows = [
        ("speed", "rpm", (has and has.speed) or "speed_rpm", 0.0, top, ""),
        ("ambient", "degC", (has and has.ambient) or "ambient_degC", -20.0, 60.0, ""),
    ]
    if answers.coolant != "none":
        column = (has and has.coolant) or "coolant_inlet_degC"
        rows.append(("coolant_inlet", "degC", column, 0.0, 60.0, ""))
    if has and has.torque:
        rows.append(("torque", "Nm", has.torque, -1000.0, 1000.0, ", default = 0.0"))
    if has and has.feeds:
        high = max(USUAL_FEED, has.highest_feed)
        rows.append(("feed", "mm_min", _feed(has)[0], 0.0, high, ", default = 0.0"))
    lines = ["# What drives the model, and the columns of your runs that hold it.", "[inputs]"]
    lines += [
        f'{name} = {{ unit = "{unit}", column = "{column}", low = {low}, high = {high}{more} }}'
        for name, unit, column, low, high, more in rows
    ]
    return "\n".join([*lines, ""])


def _spindle(plan: _Plan, answers: Answers, columns: Columns | None) -> str:
    bearing = answers.bearing
    bore, seat = bearing.bore, bearing.outside
    outer = round(max(HOUSING * bore, seat + 40.0))
    if answers.drive == "belt":
        outer = round(seat + 50.0)
    rows = [(plan.housing_start, 0, outer, seat)]
    if answers.drive == "built-in":
        rows.append(
            (0, plan.motor_end, max(outer, round(STATOR * bore) + 30), round(STATOR * bore))
        )
    start = rows[-1][1]
    rows.append((start, plan.housing_end, rows[-1][2], seat))
    housing = "\n".join(
        f"  {{ from = {a:g}, to = {b:g}, outer = {large:g}, inner = {small:g} }},"
        for a, b, large, small in rows
    )
    hole = round(0.35 * bore)
    return f"""\
# CHECK: sections of shaft and housing, from the rear to the nose. Materials: steel where not said.
[shaft]
gauge_line = {plan.gauge:g}
stretches = [
  {{ from = {plan.shaft_start:g}, to = {plan.housing_end:g}, outer = {bore:g}, inner = {hole:g} }},
  {{ from = {plan.housing_end:g}, to = {plan.gauge:g}, outer = {NOSE * bore:g}, inner = {hole:g} }},
]

[housing]
{_air(columns)}stretches = [
{housing}
]
"""


def _bearings(plan: _Plan, answers: Answers) -> str:
    sets = []
    guess = "running_temperature = 60  # CHECK: degC where it mostly runs\n"
    warm = guess if answers.coolant == "none" else ""
    for name, at, more in (("front", plan.front, "locates = true\n"), ("rear", plan.rear, "")):
        sets.append(f"""\
[[bearings]]
name = "{name}"
at = {at:g}  # CHECK: middle of the set
designation = "{answers.bearing.designation}"
count = 2
{more}lubrication = "{answers.lubrication}"  # or oil-air, grease, oil
grade = 32  # ISO VG of the oil, or of the grease's base oil
{warm}""")
    sets[0] = "# CHECK: preload = N where you know it.\n" + sets[0]
    return "\n".join(sets)


def _motor(plan: _Plan, answers: Answers) -> str:
    bore = answers.bearing.bore
    if answers.drive == "belt":
        return f"""\
# CHECK: the pulley; the belt's other share warms what it is in.
[motor]
drive = "belt"
from = {plan.shaft_start + 5:g}
to = {plan.housing_start - 5:g}
pulley_outer = {2.0 * bore:g}
into = "headstock"
{_belt_loss(answers.power)}"""
    return f"""\
# CHECK: rotor and stator; plate of the motor, or loss = W per 1000 r/min from its data sheet.
[motor]
from = 20
to = {plan.motor_end - 20:g}
rotor_outer = {ROTOR * bore:g}
power = {answers.power:g}
efficiency = 0.9
rated_speed = {answers.speed:g}
"""


def _belt_loss(power: float) -> str:
    """Return the belt's loss by the motor's power; without one the page leaves it to its class."""
    if not power:
        return ""
    usual = CLASS_VALUES["belt_loss"].scaled(power / BELT_KW)
    return (
        f"# CHECK: W/(1000 r/min), the class's in proportion to {power:g} kW.\n"
        f"loss = {{ value = {usual.value:.3g}, low = {usual.low:.3g}, high = {usual.high:.3g} }}\n"
    )


def _jackets(plan: _Plan, answers: Answers) -> str:
    if answers.coolant == "none":
        return ""
    spans: list[tuple[str, float, float, float]] = [
        ("front", plan.front - answers.bearing.width - FREE, plan.housing_end, 3.0)
    ]
    if answers.drive == "built-in":
        spans.append(("motor", 10.0, plan.motor_end - 10.0, 5.0))
    found = [
        f"""\
[[jackets]]
name = "{name}"
from = {start:g}
to = {end:g}
fluid = "{answers.coolant}"
flow = {flow:g}  # CHECK: l/min
inlet_side = "X+"  # CHECK: where the coolant comes in; that side is cooled better
"""
        for name, start, end, flow in spans
    ]
    return (
        "# CHECK: jackets, in parallel; one in series says after = its forerunner.\n"
        + "\n".join(found)
    )


def _air(columns: Columns | None) -> str:
    return 'air = "enclosure"\n' if "enclosure" in _carrier_names(columns) else ""


def _carriers(plan: _Plan, answers: Answers, columns: Columns | None) -> str:
    mass = round(4.5 * answers.bearing.bore)
    holds = (plan.housing_start, 0) if answers.drive == "belt" else (0, plan.motor_end)
    names, air = _carrier_names(columns), _air(columns)
    below = "column_top" if "column_top" in names else "column"
    parts = [
        f"""\
# CHECK: what carries the spindle. grows: lengths that move the nose when the part warms, in x, y
# and z (towards the table); bends: tilt by the difference to another part. These lengths are
# guesses, so calibration may move them far and turn them round: put in yours.
[[carriers]]
name = "headstock"
mass = {mass}
surface = 1.2  # m2 in the air
holds = {{ from = {holds[0]:g}, to = {holds[1]:g} }}  # side = "Y-" in it if from one side only
on = "{below}"
{air}
[carriers.grows]
x = {{ value = 1, low = -300, high = 300 }}
y = {{ value = 300, low = -900, high = 900 }}
z = {{ value = 80, low = -250, high = 250 }}
"""
    ]
    if below == "column":
        parts.append(_carrier("column", 3 * mass, 3.0))
    else:
        parts.append(_carrier("column_top", mass, 1.0, 'on = "column"\n'))
        parts.append(_carrier("column", 2 * mass, 2.0))
    if "nut" in names:
        more = f'material = "steel"\non = "headstock"  # CHECK\n{air}feed = {{ input = "feed" }}\n'
        parts.append(_carrier(names["nut"], 15, 0.12, more))
    return "\n".join(parts)


def _carrier(name: str, mass: float, surface: float, more: str = "") -> str:
    return f"""\
[[carriers]]
name = "{name}"
mass = {mass:g}
surface = {surface}
{more}"""


def _enclosure(columns: Columns | None) -> str:
    if "enclosure" not in _carrier_names(columns):
        return ""
    return """\
# CHECK: the closed space in which the spindle works; what stands in it says air = "enclosure".
[enclosure]
volume = 2.5  # CHECK: m3 of air
wall = 11  # CHECK: m2 of its own walls, towards the hall
"""


def _rig(answers: Answers, columns: Columns | None) -> str:
    if columns.five_point if columns else answers.rig == "five_point":
        return """\
# CHECK: two pairs of sensors on a test bar and one at its end; positions in mm from the gauge line.
[tool]
length = 150
diameter = 40

[rig]
kind = "five_point"
near_x = "S1"
near_y = "S2"
distal_x = "S3"
distal_y = "S4"
axial = "S5"
spacing_mm = 100.0
near_to_gauge_mm = 30.0
axial_sign = -1
test_bar_mm = 150.0
noise_um = 0.2
"""
    axes = (columns.axes if columns else {}) or {"disp_y": ("Y", 1), "disp_z": ("Z", 1)}
    listed = ", ".join(
        f'{name} = {{ axis = "{axis}", sign = {sign} }}' for name, (axis, sign) in axes.items()
    )
    return f"""\
# CHECK: which displacement is drift in which direction.
[rig]
kind = "direct"
axes = {{ {listed} }}
noise_um = 0.3
"""
