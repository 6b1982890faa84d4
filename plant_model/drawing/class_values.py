"""Class values of numbers that a page leaves out: value, range, source.

They are engineering judgement unless a source is named. If a page leaves one of these numbers out,
the machine gets it with this range, and its source states that it is a class value.
"""

from __future__ import annotations

from dataclasses import replace

from plant_model.drawing.form import Quantity
from plant_model.drawing.known import BY_DATA_SHEET, CLASS, Known


def _usual(value: float, low: float, high: float, unit: str, source: str) -> Known:
    return Known(value, low, high, unit, CLASS + source)


CLASS_VALUES = {
    "seat_joint": _usual(
        5000.0, 2000.0, 12000.0, "W/(m2 K)", "ground seats with a tight or sliding fit, steel"
    ),
    "balls": _usual(
        12.0,
        6.0,
        24.0,
        "W/K",
        "through the rolling elements of one bearing of 70 mm mean diameter at speed",
    ),
    "preload": _usual(
        350.0, 120.0, 900.0, "N", "light to medium preload of one bearing of 70 mm mean diameter"
    ),
    "inner_share": _usual(0.5, 0.4, 0.6, "1", "friction heat, half to each ring: Harris, ch. 10"),
    "running_temperature": _usual(45.0, 30.0, 65.0, "degC", "lubricant at running temperature"),
    "motor_joint": _usual(
        2500.0, 1000.0, 6000.0, "W/(m2 K)", "shrunk laminations on shaft and in sleeve"
    ),
    "rotor_share": _usual(
        0.3, 0.15, 0.45, "1", "a third of the loss in the rotor, as in asynchronous motors"
    ),
    "idle_share": _usual(
        0.4, 0.2, 0.7, "1", "share of the rated loss that an idling motor has at rated speed"
    ),
    "belt_loss": _usual(12.0, 4.0, 30.0, "W/(1000 r/min)", "belt and pulley of a 5 to 20 kW drive"),
    "unevenness": _usual(
        0.3, 0.02, 0.95, "1", "how much better the inlet side of a jacket cools than its mean"
    ),
    "headstock_joint": _usual(
        40.0, 15.0, 100.0, "W/K", "a clamped or flanged spindle housing in its headstock"
    ),
    "carrier_joint": _usual(10.0, 3.0, 40.0, "W/K", "a slide or a screwed joint between castings"),
    "tool_joint": _usual(0.8, 0.3, 4.0, "W/K", "taper and shank, k A / L of the shank in series"),
    "emissivity": _usual(0.8, 0.5, 0.95, "1", "painted or oily metal"),
    "enclosure_film": _usual(6.0, 3.0, 12.0, "W/(m2 K)", "sheet metal, air on both sides"),
    "feed_loss": _usual(25.0, 8.0, 80.0, "W/(m/min)", "ball screw, nut and bearings of an axis"),
    "fit_gap": _usual(
        1.0, 0.5, 2.0, "mm", "radial clearance where the page draws none between shaft and housing"
    ),
}
"""By name."""

F0 = {
    # Handbooks give 1.7 (mist) to 3.3 (bath) for angular contact bearings (Harris and Kotzalas,
    # Essential Concepts of Bearing Technology, 5th ed., ch. 10). Spindle bearings hold far less
    # lubricant and run cooler: the values here are a third of that, and the ranges extend to it.
    ("ball", "oil-air"): (0.5, 0.2, 1.7),
    ("ball", "grease"): (0.7, 0.3, 2.0),
    ("ball", "oil"): (1.5, 0.7, 3.3),
    ("roller", "oil-air"): (0.8, 0.3, 2.0),
    ("roller", "grease"): (1.0, 0.4, 2.5),
    ("roller", "oil"): (2.0, 0.8, 4.0),
}
"""Palmgren's f0 by kind and lubrication: value, low, high [1]."""

F1 = {"ball": (0.001, 0.0004, 0.0015), "roller": (0.0003, 0.0002, 0.0005)}
"""Palmgren's f1 by kind: value, low, high [1]."""


def f0_of(kind: str, lubrication: str) -> Known:
    """Return Palmgren's f0 of a kind of bearing and a lubrication."""
    return _usual(*F0[kind, lubrication], "1", f"f0 of a {kind} bearing with {lubrication}")


def f1_of(kind: str) -> Known:
    """Return Palmgren's f1 of a kind of bearing."""
    return _usual(*F1[kind], "1", f"f1 of a {kind} bearing")


def stated(
    given: Quantity | None, usual: Known, share: float = BY_DATA_SHEET, *, free: bool = True
) -> Known:
    """Return a number of the page, by default within *share* of its value, or else *usual*.

    Calibration may move it if the page says so; if the page says nothing, if it is *free*.
    """
    if given is None:
        return replace(usual, free=free)
    return given.known(usual.unit, share, free=free)
