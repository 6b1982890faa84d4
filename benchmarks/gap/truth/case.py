"""A case: one machine, four runs to calibrate on and one to judge by, something hidden or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.gap.truth.drive import FAMILIES, Drive, Held, make_drive, rest
from benchmarks.gap.truth.effects import make_effect
from benchmarks.gap.truth.effects.base import Hidden
from benchmarks.gap.truth.march import March
from benchmarks.gap.truth.parameters import draw
from benchmarks.gap.truth.spindle import POSE, Spindle

RUNS = ("run_1", "run_2", "run_3", "run_4", "holdout")
PAST_HOURS = 16.0
PERIODS = (20.0, 30.0, 60.0)
COLUMNS = (
    "time_s",
    "speed_rpm",
    *(f"T{i}_degC" for i in range(1, 12)),
    *(f"S{i}_um" for i in range(1, 6)),
    "torque_Nm",
)


@dataclass(frozen=True)
class TruthCase:
    """What makes a case; equal cases give equal runs.

    Attributes
    ----------
    seed : int
        Of machine, runs and disturbances.
    hidden : tuple of (name, size, channel)
        Effects, their size by name or in their own unit, and their sensor ("" to draw it).
    resolution : float
        Of the machine's cells.
    noise : float
        Times the usual noise of all sensors.
    mistake : str
        In the file of the machine's owner, where a truth has one; "" for none.
    careless : bool
        Whether what that owner guesses is off.
    """

    seed: int
    hidden: tuple[tuple[str, str | float, str], ...] = ()
    resolution: float = 1.0
    runs: tuple[str, ...] = RUNS
    noise: float = 1.0
    mistake: str = ""
    careless: bool = True


@dataclass(frozen=True)
class CaseRun:
    """One run as recorded, and what is true about it.

    Attributes
    ----------
    name : str
    frame : DataFrame
        What the file holds: noise and resolution included.
    exact : DataFrame
        The same without them, measuring effects included.
    drive : Drive
        Of the truth that simulated it.
    """

    name: str
    frame: pd.DataFrame
    exact: pd.DataFrame
    drive: Any = field(repr=False)


def simulate_case(case: TruthCase) -> tuple[list[CaseRun], list[Hidden]]:
    """Return the runs of a case and the effects hidden in them."""
    bench = Bench(case)
    numbers = [number for number, name in enumerate(RUNS) if name in case.runs]
    return [bench.run(RUNS[k], k, bench.families[k]) for k in numbers], bench.effects


def simulate_further(case: TruthCase, stretches: Held, seed: int = 0) -> CaseRun:
    """Return one more run of a case's machine, in its own hall.

    Parameters
    ----------
    case : TruthCase
    stretches : Held
        The ``speed`` [r/min]; if empty, a family of speeds is drawn.
    seed : int
        Of surroundings, disturbances and noise.
    """
    bench = Bench(case)
    number = len(RUNS) + seed
    rng = np.random.default_rng([case.seed, 300 + seed])
    family = str(rng.choice(FAMILIES))
    return bench.run("further_run", number, family, stretches.get("speed", ()))


class Bench:
    """One machine with its hall, its instruments and what is hidden in it."""

    def __init__(self, case: TruthCase) -> None:
        self.case = case
        # One stream for each matter, so that hiding an effect changes nothing else.
        machine, hall_rng, noise_rng = (np.random.default_rng([case.seed, k]) for k in range(3))
        spindle = Spindle(draw(machine), case.resolution)
        self.effects = [
            make_effect(name, size, np.random.default_rng([case.seed, 10 + k]), channel or None)
            for k, (name, size, channel) in enumerate(case.hidden)
        ]
        self._hall = {
            "mean": float(hall_rng.uniform(20.0, 24.0)),
            "swing": float(hall_rng.uniform(0.6, 2.0)),
            "coolant": float(hall_rng.uniform(20.5, 23.0)),
        }
        self._period = float(hall_rng.choice(PERIODS))
        self._meter = _Meter(noise_rng, case.noise)
        self.march = March(spindle, self.effects)
        self.families = _families(hall_rng)

    def run(
        self, name: str, number: int, family: str, stretches: Sequence[tuple[float, float]] = ()
    ) -> CaseRun:
        """Return a run of a family of speeds, or at given ones."""
        rng = np.random.default_rng([self.case.seed, 100 + number])
        drive = make_drive(family, rng, self._period, self._hall, before=PAST_HOURS)
        if stretches:
            drive = drive.at_speeds(stretches)
        exact = _record(self.march, drive, number)
        frame = self._meter.shown(exact, np.random.default_rng([self.case.seed, 200 + number]))
        return CaseRun(name, frame, exact, drive)


def start_of(march: March, drive: Drive) -> NDArray[np.float64]:
    """Return the temperatures of all cells at a run's first row, after a night at rest [degC]."""
    warm = np.full(len(march.spindle.capacity), float(drive.outside[0, 0]))
    return march.settle(rest(drive, PAST_HOURS), warm, 900.0)


def _families(rng: np.random.Generator) -> list[str]:
    """Return one family per run; torque occurs in at least two, one of them the first four."""
    loaded = ["random", "stop_and_go", "blocks"]
    plain = [name for name in FAMILIES if name not in loaded]
    rng.shuffle(loaded)
    rng.shuffle(plain)
    calibration = [loaded[0], loaded[1], plain[0], plain[1]]
    rng.shuffle(calibration)
    return [*calibration, loaded[2]]


def _record(march: March, drive: Drive, number: int) -> pd.DataFrame:
    spindle = march.spindle
    temperatures = march.run(drive, start_of(march, drive))
    rise = temperatures - temperatures[0]
    pose = rise @ spindle.pose_weights
    for effect in march.effects:
        effect.move(spindle, drive, temperatures, pose)
    assert pose.shape[1] == len(POSE)
    columns = {"time_s": drive.time_s, "speed_rpm": drive.speed, "torque_Nm": drive.torque}
    shown = spindle.readings(temperatures, pose)
    shown |= {"T5_degC": drive.at(0), "T9_degC": drive.at(2)}
    frame = pd.DataFrame(columns | shown)[list(COLUMNS)]
    for effect in march.effects:
        effect.record(number, drive, frame)
    return frame


class _Meter:
    """The case's instruments: noise, resolution, small constant errors of thermometers."""

    def __init__(self, rng: np.random.Generator, times: float) -> None:
        self._noise_t = times * rng.uniform(0.02, 0.04, 11)
        self._error_t = np.clip(0.02 * rng.standard_normal(11), -0.05, 0.05)
        self._noise_s = times * rng.uniform(0.12, 0.25, 5)

    def shown(self, exact: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return what the file records."""
        frame = exact.copy()
        for i in range(11):
            values = exact[f"T{i + 1}_degC"].to_numpy() + self._error_t[i]
            noisy = values + self._noise_t[i] * rng.standard_normal(len(values))
            frame[f"T{i + 1}_degC"] = np.round(noisy, 2)
        for i in range(5):
            values = exact[f"S{i + 1}_um"].to_numpy()
            noisy = values + self._noise_s[i] * rng.standard_normal(len(values))
            frame[f"S{i + 1}_um"] = np.round(noisy, 1)
        return frame
