"""The cases of the lathe, with its owner's file in lumps."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.gap import enclosed, laws
from benchmarks.gap.belt import effects as of_belts
from benchmarks.gap.belt.case import SHOP as BELTS
from benchmarks.gap.belt.drive import tests_up_to
from benchmarks.gap.case import TruthCase
from benchmarks.gap.hidden import effects_of
from benchmarks.gap.lathe import effects
from benchmarks.gap.lathe.machine import TOP_SPEED, Lathe
from benchmarks.gap.lathe.numbers import CLASS, TABLES, draw_drawing
from benchmarks.gap.lathe.owner import MISTAKES, file_of


def _lathe(case: TruthCase) -> Lathe:
    return Lathe(draw_drawing(case.stream(0)), CLASS.draw(case.stream(1)), case.resolution)


SHOP = replace(
    BELTS,
    machine=_lathe,
    effects=effects_of(effects, of_belts, enclosed, laws),
    tests=tests_up_to(TOP_SPEED),
    columns=(
        *("time_s", "speed_rpm", "feed_mm_min"),
        *(f"{name}_degC" for name in (*TABLES["thermometers"], "hall")),
        *(f"disp_{axis}_um" for axis in "xz"),
    ),
    feed="feed_mm_min",
    mistakes=MISTAKES,
    drawing=draw_drawing,
    file_of=file_of,
)
