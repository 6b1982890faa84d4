"""The cases of the belt-driven spindle, with its owner's page."""

from __future__ import annotations

from benchmarks.gap import enclosed, laws
from benchmarks.gap.belt import effects
from benchmarks.gap.belt.drive import tests_up_to
from benchmarks.gap.belt.machine import TOP_SPEED, Machine
from benchmarks.gap.belt.march import March
from benchmarks.gap.belt.numbers import CLASS, draw_drawing
from benchmarks.gap.belt.owner import MISTAKES, page_of
from benchmarks.gap.case import Instruments, Shop, TruthCase
from benchmarks.gap.hidden import effects_of

THERMOMETERS = (
    *("front", "front_below", "rear", "headstock", "column_top", "column", "nut", "inside"),
    "hall",
)


def _machine(case: TruthCase) -> Machine:
    return Machine(draw_drawing(case.stream(0)), CLASS.draw(case.stream(1)), case.resolution)


SHOP = Shop(
    machine=_machine,
    effects=effects_of(effects, enclosed, laws),
    tests=tests_up_to(TOP_SPEED),
    columns=(
        *("time_s", "speed_rpm", "feed_z_mm_min", "torque_Nm"),
        *(f"{name}_degC" for name in THERMOMETERS),
        *(f"disp_{axis}_um" for axis in "xyz"),
    ),
    feed="feed_z_mm_min",
    mistakes=MISTAKES,
    drawing=draw_drawing,
    file_of=page_of,
    march=March,
    hall={"mean": (19.0, 25.0), "swing": (0.5, 2.5)},
    outside={"hall_degC": 0},
    instruments=Instruments((0.03, 0.06), (0.2, 0.35), 0.04),
    past_hours=20.0,
)
