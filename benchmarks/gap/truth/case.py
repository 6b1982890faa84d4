"""The cases of the jig borer: no owner of its own, its coolant drawn with its hall."""

from __future__ import annotations

import numpy as np

from benchmarks.gap import laws
from benchmarks.gap.case import CaseRun, Instruments, Shop, TruthCase
from benchmarks.gap.hidden import Hidden, effects_of
from benchmarks.gap.truth import effects
from benchmarks.gap.truth.drive import FAMILIES, make_drive
from benchmarks.gap.truth.march import March
from benchmarks.gap.truth.spindle import CLASS, Spindle

COLUMNS = (
    *("time_s", "speed_rpm"),
    *(f"T{i}_degC" for i in range(1, 12)),
    *(f"S{i}_um" for i in range(1, 6)),
    "torque_Nm",
)


def _families(rng: np.random.Generator) -> list[str]:
    """Return one family per run; torque occurs in at least two, one of them the first four."""
    loaded = ["random", "stop_and_go", "blocks"]
    plain = [name for name in FAMILIES if name not in loaded]
    rng.shuffle(loaded)
    rng.shuffle(plain)
    calibration = [loaded[0], loaded[1], plain[0], plain[1]]
    rng.shuffle(calibration)
    return [*calibration, loaded[2]]


SHOP = Shop(
    machine=lambda case: Spindle(CLASS.draw(case.stream(0)), case.resolution),
    march=March,
    effects=effects_of(effects, laws),
    make_drive=make_drive,
    families=_families,
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
