"""The cases of the jig borer: no owner of its own, its coolant drawn with its hall."""

from __future__ import annotations

from benchmarks.gap import laws
from benchmarks.gap.case import CaseRun, Instruments, Shop, TruthCase
from benchmarks.gap.hidden import Hidden, effects_of
from benchmarks.gap.truth import effects
from benchmarks.gap.truth.drive import TESTS
from benchmarks.gap.truth.march import March
from benchmarks.gap.truth.spindle import CLASS, Spindle

COLUMNS = (
    *("time_s", "speed_rpm"),
    *(f"T{i}_degC" for i in range(1, 12)),
    *(f"S{i}_um" for i in range(1, 6)),
    "torque_Nm",
)


SHOP = Shop(
    machine=lambda case: Spindle(CLASS.draw(case.stream(0)), case.resolution),
    march=March,
    effects=effects_of(effects, laws),
    tests=TESTS,
    hall={"mean": (20.0, 24.0), "swing": (0.6, 2.0), "coolant": (20.5, 23.0)},
    columns=COLUMNS,
    outside={"T5_degC": 0, "T9_degC": 2},
    instruments=Instruments((0.02, 0.04), (0.12, 0.25), 0.02),
    past_hours=16.0,
    streams=(1, 2),
)


def simulate_case(case: TruthCase) -> tuple[list[CaseRun], list[Hidden]]:
    """Return the runs of a case and the effects hidden in them."""
    return SHOP.simulate(case)
