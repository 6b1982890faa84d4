"""The page that this machine's owner writes, and the mistakes that are in it on purpose.

The owner reads lengths off the drawing, guesses masses and surfaces, leaves out what no drawing
tells, and knows nothing of what is hidden.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.gap.belt.numbers import YAW, Drawing, Stretch
from benchmarks.gap.case import Mistake
from benchmarks.gap.enclosed import BoltedMass, StirredNut
from benchmarks.gap.hidden import variant
from benchmarks.gap.laws import PartSource
from benchmarks.gap.owner import guesser, told

Page = dict[str, Any]


def page_of(drawing: Drawing, careless: np.random.Generator | None = None) -> Page:
    """Return the page of a machine, its guesses exact or drawn by *careless*."""

    about, alike = guesser(careless), told(__file__)
    d = drawing

    def carrier(name: str, **more: Any) -> Page:
        body = d.bodies[name]
        return {"name": name, "mass": about(body.mass), "surface": about(body.surface), **more}

    def span(one: Stretch) -> Page:
        return {"from": one.start, "to": one.end, "outer": one.outer, "inner": one.inner}

    bend = {"against": "column_top", "pitch": 1.0, "yaw": YAW}
    bend |= {"width": d.bend_width, "length": d.bend_length, "lever": d.bend_lever}
    return {
        **alike["head"],
        "shaft": {"gauge_line": d.gauge_line, "stretches": [span(s) for s in d.shaft]},
        "housing": {
            "material": "cast_iron",
            "air": "enclosure",
            "stretches": [span(s) for s in d.housing],
        },
        "bearings": alike["bearings"],
        "motor": {
            "drive": "belt",
            "from": d.pulley.start,
            "to": d.pulley.end,
            "pulley_outer": d.pulley.outer,
            "into": "headstock",
        },
        "carriers": [
            carrier(
                "headstock",
                holds={"from": d.clamp[0], "to": d.clamp[1]},
                on="column_top",
                air="enclosure",
                grows={"y": d.grows_y, "z": d.grows_z},
                bends=[bend],
            ),
            carrier("column_top", on="column"),
            carrier("column"),
            carrier(
                "z_nut", material="steel", on="headstock", air="enclosure", feed={"input": "feed_z"}
            ),
        ],
        "enclosure": {"volume": about(d.volume), "wall": about(d.walls)},
        "tool": {"length": d.tool_length, "diameter": d.tool_diameter},
        "rig": alike["rig"],
    }


def _carrier(page: Page, name: str) -> Page:
    found: Page = next(one for one in page["carriers"] if one["name"] == name)
    return found


def _without(name: str, key: str) -> Callable[[Page], None]:
    def edit(page: Page) -> None:
        del _carrier(page, name)[key]

    return edit


def _no_growth(axis: str) -> Callable[[Page], None]:
    def edit(page: Page) -> None:
        del _carrier(page, "headstock")["grows"][axis]

    return edit


def _no_surface(page: Page) -> None:
    _carrier(page, "column")["surface"] = 0.0


def _one_column(page: Page) -> None:
    """Draw the column as one part, which both of its thermometers are on."""
    top, column, head = (_carrier(page, name) for name in ("column_top", "column", "headstock"))
    for key in ("mass", "surface"):
        column[key] = float(f"{column[key] + top[key]:.3g}")
    page["carriers"].remove(top)
    head["on"] = head["bends"][0]["against"] = "column"
    for entry in page["thermometers"]:
        if entry["part"] == "column_top":
            entry["part"] = "column"


CABINET = variant(PartSource, "cabinet", sizes=(60.0, 150.0, 300.0), part="column")
"""It stands on the column and warms it, day and night."""

STATOR = variant(BoltedMass, "stator", part="headstock", conductance=25.0)
"""It hangs on the headstock."""

MISTAKES = {
    "no_guide": Mistake("heat_path", ("headstock", "column_top"), _without("headstock", "on")),
    "no_bolts": Mistake("heat_path", ("column_top", "column"), _without("column_top", "on")),
    "no_air": Mistake("heat_path", ("column", "ambient"), _no_surface),
    "no_feed": Mistake("heat_source", ("z_nut", "feed_z"), _without("z_nut", "feed")),
    "cabinet": Mistake("heat_source", ("column",), unsaid=CABINET),
    "one_column": Mistake("coarse_part", ("column",), _one_column),
    "bolted_mass": Mistake("hidden_mass", ("headstock",), unsaid=STATOR),
    "stirred_nut": Mistake(
        "conductance_with_motion", ("z_nut", "enclosure_air", "feed_z"), unsaid=StirredNut
    ),
    "bad_contact": Mistake(
        "sensor_place", ("headstock", "enclosure_air"), reads=("headstock", "air", 0.4)
    ),
    "on_the_clamp": Mistake(
        "sensor_place", ("column_top", "headstock"), reads=("column_top", "headstock", 0.4)
    ),
    "no_growth_y": Mistake("moves_axis", ("headstock", "Y"), _no_growth("y")),
    "no_growth_z": Mistake("moves_axis", ("headstock", "Z"), _no_growth("z")),
}
"""By name."""
