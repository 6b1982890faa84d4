"""A case: one machine, four runs to calibrate on and a held-out run, something hidden or not.

This is the test bench common to all simulators: it draws the machine's hall and instruments, drives
the machine, and records the run files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
import tomlkit

from benchmarks.gap.drive import Array, Drive, Tests
from benchmarks.gap.hidden import Hidden, make_from
from benchmarks.gap.march import Stepper

RUNS = ("run_1", "run_2", "run_3", "run_4", "holdout")
PERIODS = (20.0, 30.0, 60.0)

Span = tuple[float, float]


@dataclass(frozen=True)
class TruthCase:
    """Definition of a case; equal cases give equal runs.

    Attributes
    ----------
    seed : int
        Of machine, runs and disturbances.
    hidden : tuple of (name, size, channel)
        Effects, their size by name or in their own unit, and their sensor ("" to draw it).
    resolution : float
        Of the machine's cells.
    mistake : str
        In the owner's file, if the simulator has one; "" for none.
    careless : bool
        Whether the owner's guesses are off.
    """

    seed: int
    hidden: tuple[tuple[str, str | float, str], ...] = ()
    resolution: float = 1.0
    runs: tuple[str, ...] = RUNS
    mistake: str = ""
    careless: bool = True

    def stream(self, number: int) -> np.random.Generator:
        """Return a separate random stream, so that hiding an effect changes nothing else."""
        return np.random.default_rng([self.seed, number])


@dataclass(frozen=True)
class CaseRun:
    """One run as recorded, and its exact values.

    Attributes
    ----------
    name : str
    frame : DataFrame
        Content of the file, with noise and resolution.
    exact : DataFrame
        The same without noise and resolution, but with measuring effects.
    drive : Drive
    """

    name: str
    frame: pd.DataFrame
    exact: pd.DataFrame
    drive: Drive = field(repr=False)


@dataclass(frozen=True)
class Mistake:
    """A mistake in an owner's file, and what the gap finder should call it.

    Attributes
    ----------
    kind : str
    place : tuple of str
    edit : callable, optional
        Makes the mistake in the file.
    unsaid : type of Hidden, optional
        Alternatively, something in the machine that the file lacks.
    reads : tuple of (thermometer, part, share), optional
        Alternatively, a thermometer that partly reads another part.
    """

    kind: str
    place: tuple[str, ...]
    edit: Callable[[dict[str, Any]], None] | None = None
    unsaid: type[Hidden] | None = None
    reads: tuple[str, str, float] | None = None


@dataclass(frozen=True)
class Instruments:
    """How good the sensors of one class of machines are.

    Attributes
    ----------
    noise_K, noise_um : (float, float)
        From the best to the worst sensor.
    error_K : float
        Standard deviation of a thermometer's constant error, limited to two and a half times that.
    """

    noise_K: Span  # noqa: N815
    noise_um: Span
    error_K: float  # noqa: N815


@dataclass(frozen=True)
class Shop:
    """What is specific to the cases of one simulator.

    Attributes
    ----------
    machine : callable
        Returns the machine of a case.
    march : type of Stepper
    effects : mapping of str to type
        What can be hidden, by name.
    tests : Tests
    hall : mapping of str to (float, float)
        Random properties of each machine's hall, with their ranges.
    columns : tuple of str
        Of its run files.
    outside : mapping of str to int
        Columns with a boundary temperature, and the number of that boundary.
    instruments : Instruments
    past_hours : float
        Rest before every run [h].
    streams : (int, int)
        Of the hall and of the instruments.
    feed : str
        Column of the axis's feed, if an axis moves.
    mistakes : mapping of str to Mistake
        Of its owner.
    drawing, file_of : callable, optional
        The first returns the owner's drawing from a stream; the second the owner's file from that
        and a stream for guesses (None for exact values).
    """

    machine: Callable[[TruthCase], Any]
    march: type[Stepper[Any]]
    effects: Mapping[str, type[Hidden]]
    tests: Tests
    hall: Mapping[str, Span]
    columns: tuple[str, ...]
    outside: Mapping[str, int]
    instruments: Instruments
    past_hours: float
    streams: tuple[int, int] = (4, 5)
    feed: str = ""
    mistakes: Mapping[str, Mistake] = field(default_factory=dict)
    drawing: Callable[[np.random.Generator], Any] | None = None
    file_of: Callable[[Any, np.random.Generator | None], dict[str, Any]] | None = None

    def simulate(self, case: TruthCase) -> tuple[list[CaseRun], list[Hidden]]:
        """Return the runs of a case and the effects hidden in them."""
        bench = Bench(case, self)
        numbers = [number for number, name in enumerate(RUNS) if name in case.runs]
        return [bench.run(number) for number in numbers], bench.effects

    def owners_file(self, case: TruthCase) -> str:
        """Return the file that the owner of a case's machine writes."""
        assert self.drawing is not None
        assert self.file_of is not None
        table = self.file_of(
            self.drawing(case.stream(0)), case.stream(3) if case.careless else None
        )
        edit = self.mistakes[case.mistake].edit if case.mistake else None
        if edit is not None:
            edit(table)
        return tomlkit.dumps(table)


class Bench:
    """One machine with its hall, its instruments and its hidden effects."""

    def __init__(self, case: TruthCase, shop: Shop) -> None:
        self.case, self._shop = case, shop
        self.effects = [
            make_from(shop.effects, name, size, case.stream(10 + k), channel)
            for k, (name, size, channel) in enumerate(case.hidden)
        ]
        acting = [*self.effects]
        self._mistake = shop.mistakes[case.mistake] if case.mistake else None
        if self._mistake is not None and (unsaid := self._mistake.unsaid) is not None:
            acting.append(unsaid(unsaid.sizes[1], case.stream(9)))
        of_hall = case.stream(shop.streams[0])
        self._hall = {name: float(of_hall.uniform(*ends)) for name, ends in shop.hall.items()}
        self._period = float(of_hall.choice(PERIODS))
        self._families = shop.tests.plan(of_hall)
        self._meter = _Meter(shop, case.stream(shop.streams[1]))
        self.march = shop.march(shop.machine(case), acting)

    def run(self, number: int) -> CaseRun:
        """Return a run of the case."""
        case, shop = self.case, self._shop
        chance = case.stream(100 + number)
        family = self._families[number]
        drive = shop.tests.drive(family, chance, self._period, self._hall, shop.past_hours)
        exact = self._exact(drive, number)
        frame = self._meter.shown(exact, case.stream(200 + number))
        return CaseRun(RUNS[number], frame, exact, drive)

    def start_of(self, drive: Drive) -> Array:
        """Return all temperatures at a run's first row, after the rest before it [degC]."""
        warm = np.full(len(self.march.machine.capacity), float(drive.outside[0, 0]))
        return self.march.settle(drive.rest(self._shop.past_hours), warm, 900.0)

    def _exact(self, drive: Drive, number: int) -> pd.DataFrame:
        """Return the run as sensors without noise would record it."""
        march, machine, shop = self.march, self.march.machine, self._shop
        temperatures = march.run(drive, self.start_of(drive))
        pose = (temperatures - temperatures[0]) @ machine.pose_weights
        for effect in march.effects:
            effect.move(machine, drive, temperatures, pose)
        columns = {"time_s": drive.time_s, "speed_rpm": drive.speed, "torque_Nm": drive.torque}
        columns |= {shop.feed: drive.feed} | {name: drive.at(k) for name, k in shop.outside.items()}
        frame = pd.DataFrame(columns | machine.readings(temperatures, pose))[list(shop.columns)]
        if self._mistake is not None and self._mistake.reads is not None:
            sensor, part, share = self._mistake.reads
            other = temperatures[:, machine.parts[part]].mean(axis=1)
            frame[f"{sensor}_degC"] = (1.0 - share) * frame[f"{sensor}_degC"] + share * other
        for effect in march.effects:
            effect.record(number, machine, drive, frame)
        return frame


class _Meter:
    """A case's instruments: noise, resolution, small constant errors of thermometers."""

    def __init__(self, shop: Shop, chance: np.random.Generator) -> None:
        self._warm = [name for name in shop.columns if name.endswith("_degC")]
        self._moved = [name for name in shop.columns if name.endswith("_um")]
        how, count = shop.instruments, len(self._warm)
        noise = chance.uniform(*how.noise_K, count)
        most = 2.5 * how.error_K
        errors = np.clip(how.error_K * chance.standard_normal(count), -most, most)
        self._error = dict(zip(self._warm, errors, strict=True))
        moved = chance.uniform(*how.noise_um, len(self._moved))
        self._noise = dict(zip([*self._warm, *self._moved], [*noise, *moved], strict=True))

    def shown(self, exact: pd.DataFrame, chance: np.random.Generator) -> pd.DataFrame:
        """Return the run as recorded in the file."""
        frame = exact.copy()
        for name, noise in self._noise.items():
            values = exact[name].to_numpy() + self._error.get(name, 0.0)
            noisy = values + noise * chance.standard_normal(len(values))
            frame[name] = np.round(noisy, 2 if name in self._error else 1)
        return frame
