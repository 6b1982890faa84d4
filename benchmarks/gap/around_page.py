"""The cases of the page `jig_borer`: the fine simulator adapted to it, and its owner's page."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from math import log, pi
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.gap.truth.case import SHOP as JIG_BORERS
from benchmarks.gap.truth.spindle import CLASS, Spindle
from plant_model.machine_file import machine_path

PAGE = "jig_borer"
STEEL, IRON, K = 7850.0 * 470.0, 7400.0 * 450.0, 45.0


def ring(outer_mm: float, inner_mm: float) -> float:
    """Return a section [m2]."""
    return pi / 4.0 * (outer_mm**2 - inner_mm**2) * 1e-6


def joint(film: float, seat_mm: float, length_mm: float, face_mm: float, other_mm: float) -> float:
    """Return a joint on a cylinder in series with a third of the wall behind it [W/K]."""
    area = pi * seat_mm * length_mm * 1e-6
    mean = face_mm + (other_mm - face_mm) / 3.0
    return 1.0 / (1.0 / (film * area) + abs(log(mean / face_mm)) / (2e-3 * pi * K * length_mm))


def drawn() -> dict[str, float]:
    """Return the fine simulator's numbers for the machine of the page, calculated by hand.

    Masses, sections and surfaces come from the drawing; joints, films and friction from the
    handbook values that a page starts from. The fine simulator varies its machines around them, but
    keeps its own cells, laws, and sleeves that spread a bearing's heat over 120 mm of housing.
    """
    bearing = 0.68 * 7850.0 * ring(90.0, 55.0) * 0.018 * 470.0
    rear, motor, front = ring(160.0, 90.0), ring(190.0, 150.0), ring(190.0, 90.0)
    lengths = (0.16, 0.18, 0.14)
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")) | {
        "c_shaft_rear": STEEL * ring(55.0, 20.0) * 0.14,
        "c_shaft_middle": STEEL * ring(55.0, 20.0) * 0.2,
        "c_shaft_front": STEEL * (ring(55.0, 20.0) * 0.14 + ring(80.0, 20.0) * 0.06),
        "c_rotor": IRON * ring(98.6, 55.0) * 0.14,
        "c_stator": IRON * ring(150.0, 100.0) * 0.14,
        "c_inner": 0.45 * bearing,
        "c_balls": 0.1 * bearing,
        "c_outer": 0.45 * bearing,
        "c_housing_rear": STEEL * rear * lengths[0],
        "c_housing_motor": STEEL * motor * lengths[1],
        "c_housing_front": STEEL * front * lengths[2],
        "c_bar": STEEL * ring(55.0, 0.0) * 0.15,
        "ka_shaft": K * ring(55.0, 20.0),
        "ka_bar": K * ring(55.0, 0.0),
        # The fine simulator has one number for all three sections: their mean along the axis.
        "ka_housing": K * float(np.average([rear, motor, front], weights=lengths)),
        "kt_housing": K
        * float(np.average([0.035 / 0.0625, 0.02 / 0.085, 0.05 / 0.07], weights=lengths)),
        # Seats of 5 kW/(m2 K), shrunk laminations of 2.5, each with a third of the wall; balls.
        "j_inner": joint(5000.0, 55.0, 18.0, 55.0, 20.0),
        "j_outer_front": joint(5000.0, 90.0, 18.0, 90.0, 190.0),
        "j_outer_rear": joint(5000.0, 90.0, 18.0, 90.0, 160.0),
        "j_race_front": 12.0 * 72.5 / 70.0,
        "j_race_rear": 12.0 * 72.5 / 70.0,
        "j_rotor": joint(2500.0, 55.0, 140.0, 55.0, 20.0),
        "j_stator": joint(2500.0, 150.0, 140.0, 150.0, 190.0),
    }


def page_table() -> dict[str, Any]:
    """Return the page, with thermometers where the fine simulator has them."""
    page = tomllib.loads(machine_path(PAGE).read_text(encoding="utf-8"))
    places = {"T6": 245.0, "T7": 245.0, "T8": 95.0, "T11": 95.0}
    for entry in page["thermometers"]:
        if entry["name"] in places:
            entry["at"] = places[entry["name"]]
        if entry["name"] == "T1":
            entry["part"] = "rear.outer"
            del entry["at"]
    return page


SHOP = replace(
    JIG_BORERS,
    machine=lambda case: Spindle(
        CLASS.draw(case.stream(0), CLASS.nominal() | drawn()), case.resolution
    ),
    drawing=lambda _: page_table(),  # The same for all machines, which vary around it.
    file_of=lambda page, _: page,
)
