"""The page that this machine's owner writes, and the mistakes that are in it on purpose.

The owner reads lengths off the drawing, guesses masses and surfaces, leaves out what no drawing
tells, and knows nothing of what is hidden.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.gap.belt.drive import TOP_FEED
from benchmarks.gap.belt.machine import TOP_SPEED
from benchmarks.gap.belt.numbers import FRONT_AT, REAR_AT, YAW, Drawing, Stretch
from benchmarks.gap.case import Mistake
from benchmarks.gap.enclosed import BoltedMass, StirredNut
from benchmarks.gap.hidden import variant
from benchmarks.gap.laws import PartSource

Page = dict[str, Any]

CELLS = {"longest": 60.0, "sectors": 4}
"""How finely the owner has the spindle cut: half as fine as the usual, and asked in a fifth of the
time; an exact page leaves as little with it."""

GUESSED = (0.08, 0.15)
"""How far off a guessed mass or surface is: standard deviation of the logarithm, and the most."""


def page_of(drawing: Drawing, careless: np.random.Generator | None = None) -> Page:
    """Return the page of a machine, its guesses exact or drawn by *careless*."""

    def about(value: float) -> float:
        if careless is None:
            return value
        deviation, most = GUESSED
        off = float(np.clip(deviation * careless.standard_normal(), -most, most))
        return float(f"{value * np.exp(off):.3g}")

    d = drawing

    def carrier(name: str, **more: Any) -> Page:
        body = d.bodies[name]
        return {"name": name, "mass": about(body.mass), "surface": about(body.surface), **more}

    def span(one: Stretch) -> Page:
        return {"from": one.start, "to": one.end, "outer": one.outer, "inner": one.inner}

    inputs = {
        "speed": ("rpm", "speed_rpm", 0.0, TOP_SPEED, None),
        "feed_z": ("mm_min", "feed_z_mm_min", 0.0, TOP_FEED, 0.0),
        "torque": ("Nm", "torque_Nm", 0.0, 60.0, 0.0),
        "ambient": ("degC", "hall_degC", -20.0, 60.0, None),
    }
    grease = {"lubrication": "grease", "grade": 22.0, "running_temperature": 55.0}
    bend = {"against": "column_top", "pitch": 1.0, "yaw": YAW}
    bend |= {"width": d.bend_width, "length": d.bend_length, "lever": d.bend_lever}
    return {
        "format": 1,
        "kind": "drawing",
        "name": "owners_machine",
        "title": "Milling spindle with belt drive, as its owner draws it",
        "cells": CELLS,
        "thermometers": [
            {"name": "front", "part": "housing", "at": FRONT_AT, "side": "Y+"},
            {"name": "front_below", "part": "housing", "at": FRONT_AT, "side": "Y-"},
            {"name": "rear", "part": "housing", "at": REAR_AT, "side": "Y+"},
            {"name": "headstock", "part": "headstock"},
            {"name": "column_top", "part": "column_top"},
            {"name": "column", "part": "column"},
            {"name": "nut", "part": "z_nut"},
            {"name": "inside", "part": "enclosure"},
        ],
        "inputs": {
            name: {"unit": unit, "column": column, "low": low, "high": high}
            | ({} if default is None else {"default": default})
            for name, (unit, column, low, high, default) in inputs.items()
        },
        "shaft": {"gauge_line": d.gauge_line, "stretches": [span(s) for s in d.shaft]},
        "housing": {
            "material": "cast_iron",
            "air": "enclosure",
            "stretches": [span(s) for s in d.housing],
        },
        "bearings": [
            {"name": "front", "at": FRONT_AT, "designation": "7012", "count": 2, "locates": True}
            | grease,
            {"name": "rear", "at": REAR_AT, "designation": "NN3011"} | grease,
        ],
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
        "rig": {
            "kind": "direct",
            "axes": {f"disp_{a}": {"axis": a.upper(), "sign": 1} for a in "xyz"},
            "noise_um": 0.3,
            "resolution_um": 0.1,
        },
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
