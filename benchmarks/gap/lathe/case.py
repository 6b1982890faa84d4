"""A case: one lathe, four runs to calibrate on and one to judge by, and its owner's file."""

from __future__ import annotations

import numpy as np
import tomlkit

from benchmarks.gap.belt.case import Bench, Shop
from benchmarks.gap.belt.numbers import draw_hidden
from benchmarks.gap.enclosed import Hidden
from benchmarks.gap.lathe.effects import everything
from benchmarks.gap.lathe.machine import TOP_SPEED, Lathe
from benchmarks.gap.lathe.numbers import HIDDEN, draw_drawing
from benchmarks.gap.lathe.owner import MISTAKES, SENSORS, file_of
from benchmarks.gap.truth.case import CaseRun, TruthCase
from benchmarks.gap.truth.drive import Held

SHOP = Shop(everything, MISTAKES, (*SENSORS, "hall"), ("x", "z"), slower=TOP_SPEED / 8000.0)
"""What the lathe's cases have of their own."""


def _lathe(case: TruthCase) -> Lathe:
    drawing = draw_drawing(np.random.default_rng([case.seed, 0]))
    numbers = draw_hidden(np.random.default_rng([case.seed, 1]), HIDDEN)
    return Lathe(drawing, numbers, case.resolution)


def owners_file(case: TruthCase) -> str:
    """Return the file that the owner of a case's lathe writes."""
    drawing = draw_drawing(np.random.default_rng([case.seed, 0]))
    careless = np.random.default_rng([case.seed, 3]) if case.careless else None
    table = file_of(drawing, careless)
    edit = MISTAKES[case.mistake].edit if case.mistake else None
    if edit is not None:
        edit(table)
    return tomlkit.dumps(table)


def simulate_case(case: TruthCase) -> tuple[list[CaseRun], list[Hidden]]:
    """Return the runs of a case and the effects hidden in them."""
    return Bench(case, _lathe(case), SHOP).all_runs()


def simulate_further(case: TruthCase, stretches: Held, seed: int = 0) -> CaseRun:
    """Return one more run of a case's lathe; see `benchmarks.gap.belt.case.Bench.further`."""
    return Bench(case, _lathe(case), SHOP).further(stretches, seed)
