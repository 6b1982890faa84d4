"""A case: one machine, four runs to calibrate on and one to judge by, and its owner's page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import tomlkit

from benchmarks.gap.belt.drive import FAMILIES, MOVING, Drive, make_drive, rest
from benchmarks.gap.belt.effects import everything
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.belt.march import March
from benchmarks.gap.belt.numbers import draw_drawing, draw_hidden
from benchmarks.gap.belt.owner import MISTAKES, Mistake, page_of
from benchmarks.gap.enclosed import Hidden
from benchmarks.gap.truth.case import RUNS, CaseRun, TruthCase
from benchmarks.gap.truth.drive import Held
from benchmarks.gap.truth.effects import make_from

PAST_HOURS = 20.0
PERIODS = (20.0, 30.0, 60.0)
TEMPERATURES = (
    *("front", "front_below", "rear", "headstock", "column_top", "column", "nut", "inside"),
    "hall",
)


@dataclass(frozen=True)
class Shop:
    """What the cases of one machine have of their own.

    Attributes
    ----------
    effects : callable
        Returns what can be hidden, by name.
    mistakes : mapping of str to Mistake
        Of its owner.
    temperatures : tuple of str
        Thermometers, the hall's included.
    axes : tuple of str
        In which displacement is measured.
    feed : str
        Column of the axis's feed.
    slower : float
        Its speeds are this share of those of the belt-driven spindle.
    torque : bool
        Whether the runs have it.
    """

    effects: Callable[[], Mapping[str, type[Hidden]]]
    mistakes: Mapping[str, Any]
    temperatures: tuple[str, ...]
    axes: tuple[str, ...]
    feed: str = "feed_mm_min"
    slower: float = 1.0
    torque: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of its run files."""
        return (
            *("time_s", "speed_rpm", self.feed),
            *(("torque_Nm",) if self.torque else ()),
            *(f"{name}_degC" for name in self.temperatures),
            *(f"disp_{axis}_um" for axis in self.axes),
        )


SHOP = Shop(everything, MISTAKES, TEMPERATURES, ("x", "y", "z"), feed="feed_z_mm_min", torque=True)
COLUMNS = SHOP.columns


def _machine(case: TruthCase) -> Machine:
    drawing = draw_drawing(np.random.default_rng([case.seed, 0]))
    return Machine(drawing, draw_hidden(np.random.default_rng([case.seed, 1])), case.resolution)


def owners_page(case: TruthCase) -> str:
    """Return the page that the owner of a case's machine writes."""
    drawing = draw_drawing(np.random.default_rng([case.seed, 0]))
    careless = np.random.default_rng([case.seed, 3]) if case.careless else None
    page: dict[str, Any] = page_of(drawing, careless)
    mistake = _mistake(case)
    if mistake is not None and mistake.edit is not None:
        mistake.edit(page)
    return tomlkit.dumps(page)


def _mistake(case: TruthCase) -> Mistake | None:
    return MISTAKES[case.mistake] if case.mistake else None


def simulate_case(case: TruthCase) -> tuple[list[CaseRun], list[Hidden]]:
    """Return the runs of a case and the effects hidden in them."""
    return Bench(case, _machine(case), SHOP).all_runs()


def simulate_further(case: TruthCase, stretches: Held, seed: int = 0) -> CaseRun:
    """Return one more run of a case's machine; see `Bench.further`."""
    return Bench(case, _machine(case), SHOP).further(stretches, seed)


class Bench:
    """One machine with its hall, its instruments and what is hidden in it."""

    def __init__(self, case: TruthCase, machine: Any, shop: Shop) -> None:
        self.case, self._shop = case, shop
        # One stream for each matter, so that hiding an effect changes nothing else.
        hall_rng, noise_rng = (np.random.default_rng([case.seed, k]) for k in (4, 5))
        self._mistake = mistake = shop.mistakes[case.mistake] if case.mistake else None
        own = [np.random.default_rng([case.seed, 10 + k]) for k in range(len(case.hidden))]
        self.effects = [
            make_from(shop.effects(), name, size, rng, channel)
            for (name, size, channel), rng in zip(case.hidden, own, strict=True)
        ]
        acting = [*self.effects]
        if mistake is not None and mistake.unsaid is not None:
            more = np.random.default_rng([case.seed, 9])
            acting.append(mistake.unsaid(mistake.unsaid.sizes[1], more))
        self._hall = {
            "mean": float(hall_rng.uniform(19.0, 25.0)),
            "swing": float(hall_rng.uniform(0.5, 2.5)),
        }
        self._period = float(hall_rng.choice(PERIODS))
        self._meter = _Meter(shop, noise_rng, case.noise)
        self._march, self._families = March(machine, acting), _families(hall_rng)

    def all_runs(self) -> tuple[list[CaseRun], list[Hidden]]:
        """Return the runs of the case and the effects hidden in them."""
        numbers = [number for number, name in enumerate(RUNS) if name in self.case.runs]
        return [self.run(RUNS[k], k, self._families[k]) for k in numbers], self.effects

    def run(
        self,
        name: str,
        number: int,
        family: str,
        stretches: Held | None = None,
    ) -> CaseRun:
        """Return a run of a family of speeds, or at given ones."""
        rng = np.random.default_rng([self.case.seed, 100 + number])
        drive = make_drive(
            family, rng, self._period, self._hall, before=PAST_HOURS, slower=self._shop.slower
        )
        if stretches:
            drive = drive.asked_for(stretches)
        exact = _record(self._march, drive, number, self._mistake, self._shop)
        frame = self._meter.shown(exact, np.random.default_rng([self.case.seed, 200 + number]))
        return CaseRun(name, frame, exact, drive)

    def further(self, stretches: Held, seed: int) -> CaseRun:
        """Return one more run, in the machine's own hall.

        Parameters
        ----------
        stretches : Held
            Speed [r/min] and feed [mm/min]; if empty, a family of tests is drawn.
        seed : int
            Of surroundings, disturbances and noise.
        """
        rng = np.random.default_rng([self.case.seed, 300 + seed])
        family = str(rng.choice(list(FAMILIES)))
        return self.run("further_run", len(RUNS) + seed, family, stretches)


def _families(rng: np.random.Generator) -> list[str]:
    """Return one family for each run; the axis moves in two of the first four."""
    moving = list(MOVING)
    still = [name for name in FAMILIES if name not in moving]
    rng.shuffle(moving)
    rng.shuffle(still)
    known = [*moving[:2], *still[:2]]
    rng.shuffle(known)
    return [*known, moving[2]]


def _record(
    march: March, drive: Drive, number: int, mistake: Mistake | None, shop: Shop
) -> pd.DataFrame:
    machine = march.machine
    warm = np.full(len(machine.capacity), float(drive.outside[0, 0]))
    start = march.settle(rest(drive, PAST_HOURS), warm, 900.0)
    temperatures = march.run(drive, start)
    pose = (temperatures - temperatures[0]) @ machine.pose_weights
    for effect in march.effects:
        effect.move(machine, drive, temperatures, pose)
    columns = {"time_s": drive.time_s, "speed_rpm": drive.speed, shop.feed: drive.feed}
    shown = machine.readings(temperatures, pose)
    frame = pd.DataFrame(columns | {"torque_Nm": drive.torque, "hall_degC": drive.at()} | shown)
    frame = frame[list(shop.columns)]
    if mistake is not None and mistake.reads is not None:
        sensor, part, share = mistake.reads
        other = temperatures[:, machine.parts[part]].mean(axis=1)
        frame[f"{sensor}_degC"] = (1.0 - share) * frame[f"{sensor}_degC"] + share * other
    for effect in march.effects:
        effect.record(number, machine, drive, frame)
    return frame


class _Meter:
    """The case's instruments: noise, resolution, small constant errors of thermometers."""

    def __init__(self, shop: Shop, rng: np.random.Generator, times: float) -> None:
        count = len(shop.temperatures)
        self._shop = shop
        self._noise_t = times * rng.uniform(0.03, 0.06, count)
        self._error_t = np.clip(0.04 * rng.standard_normal(count), -0.1, 0.1)
        self._noise_s = times * rng.uniform(0.2, 0.35, len(shop.axes))

    def shown(self, exact: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return what the file records."""
        frame = exact.copy()
        for i, name in enumerate(self._shop.temperatures):
            values = exact[f"{name}_degC"].to_numpy() + self._error_t[i]
            noisy = values + self._noise_t[i] * rng.standard_normal(len(values))
            frame[f"{name}_degC"] = np.round(noisy, 2)
        for i, axis in enumerate(self._shop.axes):
            values = exact[f"disp_{axis}_um"].to_numpy()
            noisy = values + self._noise_s[i] * rng.standard_normal(len(values))
            frame[f"disp_{axis}_um"] = np.round(noisy, 1)
        return frame
