"""A small page that tests change, and the refusal of a bad one."""

import tomllib
from typing import Any

from plant_model.drawing.expand import expanded
from plant_model.machine import Machine
from plant_model.machine_file import SHIPPED, machine_from_table
from tests import refusing
from tests.mangling import mangled

PAGE = """
format = 1
kind = "drawing"
name = "small"
title = "Small spindle"
thermometers = [
  { name = "T1", part = "housing", at = 150, side = "X+" },
  { name = "T2", part = "head" },
]

[cells]
longest = 200
sectors = 4

[inputs]
speed = { unit = "rpm", column = "speed_rpm", low = 0.0, high = 10000.0 }
ambient = { unit = "degC", column = "hall_degC", low = -20.0, high = 60.0 }
coolant_inlet = { unit = "degC", column = "inlet_degC", low = 0.0, high = 60.0 }

[shaft]
gauge_line = 260
stretches = [{ from = 0, to = 260, outer = 60, inner = 20 }]

[housing]
stretches = [{ from = 0, to = 200, outer = 180, inner = 100 }]

[[bearings]]
name = "front"
at = 150
designation = "7012"
count = 2
locates = true
preload = 300

[[bearings]]
name = "rear"
at = 20
designation = "7012"
preload = 200

[motor]
from = 50
to = 100
rotor_outer = 90
loss = 20

[[jackets]]
name = "one"
from = 60
to = 180
flow = 4
inlet_side = "X+"
unevenness = 0.4

[[carriers]]
name = "head"
mass = 200
surface = 0.8
holds = { from = 0, to = 60 }
on = "column"
grows = { y = 200 }
bends = [{ against = "column", width = 300, length = 200, lever = 250, pitch = 1 }]

[[carriers]]
name = "column"
mass = 700
surface = 2.5

[tool]
length = 100
diameter = 40

[rig]
kind = "direct"
axes = { disp_x = { axis = "X" }, disp_y = { axis = "Y" }, disp_z = { axis = "Z" } }
"""


def small_page() -> dict[str, Any]:
    """Return the small page as a table of its own."""
    return tomllib.loads(PAGE)


def shipped_page(name: str) -> dict[str, Any]:
    """Return a shipped page as a table."""
    return tomllib.loads((SHIPPED / f"{name}.toml").read_text(encoding="utf-8"))


def changed(page: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Return a page with one value put in or, where it is ``None``, taken out."""
    return mangled(page, key, ... if value is None else value)


def without_one_sidedness() -> dict[str, Any]:
    """Return the small page with a jacket that cools all sides alike."""
    page = small_page()
    del page["jackets"][0]["inlet_side"], page["jackets"][0]["unevenness"]
    return page


def machine_of(page: dict[str, Any], **cells: Any) -> Machine:
    """Return a page's machine."""
    return machine_from_table(expanded(page, "page.toml", **cells), "page.toml")


def refusal(page: dict[str, Any]) -> str:
    """Return the one line with which a page is refused, without the file's name."""
    text = refusing.refusal(machine_of, page)
    assert text.startswith("page.toml: ")
    return text.removeprefix("page.toml: ")
