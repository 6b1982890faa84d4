"""The one list of what may be missing: every effect and every change of the description.

A kind is a law of the catalogue or a kind of change; it has as many candidates as there are
drivers, channels or places for it. "Nothing" has half of the prior probability, the kinds share the
rest evenly, and so do the candidates of a kind. A second addition pays its own share again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from gap_finder.candidates import (
    Candidate,
    candidates,
    given_values,
    missing_effects,
    with_effect,
)
from gap_finder.design import RunSensitivities
from gap_finder.directions import NEGLIGIBLE_SQUARES
from gap_finder.keys import has_its_drivers, law_of, laws_of
from gap_finder.kinds import CalibratedRun, Change, kinds
from gap_finder.observations import Observations
from gap_finder.score import Fit
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.parameters import FloatArray


class Addition(Protocol):
    """What a hypothesis adds to the machine, with the numbers that it is tried at."""

    @property
    def key(self) -> str:
        """What it is called; its kind before the colon."""

    @property
    def answers(self) -> tuple[FloatArray, ...]:
        """What it changes in every run, weighted, each (N,)."""

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with it, its numbers as tried."""

    def base(self, machine: Machine) -> Machine:
        """Return the machine with it, its numbers at the prior's centre."""

    def marked(self, position: int, observed: Observations) -> Observations:
        """Return a run's observations with what this says of that run alone."""

    def scaled(self, scale: float) -> Addition:
        """Return it with an answer so many times as large."""

    def read(self, machine: Machine) -> Addition:
        """Return it with the numbers that a machine has."""

    def size_cost(self) -> float:
        """Return -2 log of how usual its numbers are, against the most usual."""


def heavy_tail(value: float, low: float, high: float, *, log: bool) -> float:
    """Return -2 log of a Cauchy density against its middle.

    Parameters
    ----------
    value, low, high : float
        The usual range is one scale parameter to either side: its ends cost 1.4, five times
        as far 6.5, and nothing is impossible.
    log : bool
        Whether it is the logarithm that is distributed so.
    """
    if log:
        value, low, high = (float(np.log(max(x, 1e-12))) for x in (value, low, high))
    distance = (value - (low + high) / 2.0) / max((high - low) / 2.0, 1e-12)
    return float(2.0 * np.log1p(distance**2))


@dataclass(frozen=True)
class AddedEffect:
    """An effect of the catalogue; see `Addition`."""

    candidate: Candidate

    @property
    def key(self) -> str:
        """Name, and driver or channel behind a colon."""
        return self.candidate.key

    @property
    def answers(self) -> tuple[FloatArray, ...]:
        """What it changes in every run."""
        return self.candidate.answers

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with the effect in force."""
        return with_effect(machine, self.key, self.candidate.values)

    def base(self, machine: Machine) -> Machine:
        """Return the machine with the effect at its nominal size."""
        return with_effect(machine, self.key, given_values(self.key, self.candidate.values))

    def marked(self, position: int, observed: Observations) -> Observations:
        """Return a run's observations with what the effect has of its own there."""
        return self.candidate.marked(position, observed)

    def scaled(self, scale: float) -> AddedEffect:
        """Return it so many times as large."""
        values = self.candidate.scaled(scale)
        return AddedEffect(replace(self.candidate, values=values))

    def read(self, machine: Machine) -> AddedEffect:
        """Return it as a machine has it."""
        values = {name: p.value for name, p in machine.effects[self.key].items()}
        return AddedEffect(replace(self.candidate, values=values))

    @property
    def is_ordinary(self) -> bool:
        """Whether it is so small that any machine has as much."""
        effect = catalogue()[name_of(self.key)]
        return abs(self.candidate.values[effect.amplitude] - effect.off) < effect.least

    def size_cost(self) -> float:
        """Return what its amplitude and the numbers of its law cost beyond their usual ranges."""
        effect = catalogue()[name_of(self.key)]
        total = 0.0
        for name in (effect.amplitude, *effect.law):
            usual = effect.parameters[name]
            if name in self.candidate.values:
                log = name != effect.amplitude and usual.low > 0.0
                total += heavy_tail(self.candidate.values[name], usual.low, usual.high, log=log)
        return total


@dataclass(frozen=True)
class AddedChange:
    """A change of the description; see `Addition`."""

    change: Change
    numbers: Mapping[str, float]
    answers: tuple[FloatArray, ...]

    @property
    def key(self) -> str:
        """Kind, and place behind a colon."""
        return self.change.key

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with the change."""
        return self.change.put_into(machine, self.numbers)

    def base(self, machine: Machine) -> Machine:
        """Return the machine with the change, its numbers at the middle of their usual ranges."""
        return self.change.put_into(machine, {**self.numbers, **self.change.centre()})

    def marked(self, position: int, observed: Observations) -> Observations:
        """Return the observations as they are."""
        return observed

    def scaled(self, scale: float) -> AddedChange:
        """Return it so many times as large."""
        return replace(self, numbers=self.change.scaled(self.numbers, scale))

    def read(self, machine: Machine) -> AddedChange:
        """Return it as a machine has it."""
        return replace(self, numbers=self.change.read(machine))

    def size_cost(self) -> float:
        """Return what its size costs beyond what is usual of its kind."""
        low, high = self.change.usual(self.change.amplitude)
        value = self.numbers[self.change.amplitude]
        return heavy_tail(value, low, high, log=True) if low < high else 0.0


@dataclass(frozen=True)
class Listed:
    """All additions that are tried to a machine, and what each costs by its prior.

    Attributes
    ----------
    tried : sequence of Addition
        Each candidate at several sizes.
    costs : dict of str to float
        -2 log of the prior probability of every candidate, by key.
    """

    tried: Sequence[Addition]
    costs: dict[str, float]

    def without(self, keys: Collection[str]) -> Listed:
        """Return the same without what is added already, and without its law on other drivers."""
        taken = set(laws_of(keys))
        rest = [addition for addition in self.tried if law_of(addition.key) not in taken]
        return Listed(rest, prior_costs({addition.key for addition in rest}))


def prior_costs(keys: Collection[str]) -> dict[str, float]:
    """Return -2 log of the prior probability of every candidate, "nothing" being 0.

    Parameters
    ----------
    keys : collection of str
        All candidates.
    """
    of_kind = Counter(name_of(key) for key in keys)
    return {key: 2.0 * float(np.log(len(of_kind) * of_kind[name_of(key)])) for key in keys}


def all_additions(
    pool: Executor,
    about: Fit,
    sensitivities: Sequence[RunSensitivities],
    without: Sequence[str] = (),
    described: bool = True,
) -> Listed:
    """Return all that may be added to a calibrated machine, and what it would change.

    Parameters
    ----------
    pool : Executor
    about : Fit
    sensitivities : sequence of RunSensitivities
        About its machine.
    without : sequence of str
        Effects that are not to be considered.
    described : bool
        Whether the description may be changed, too.
    """
    machine, observed = about.machine, about.observed
    effects = [effect.name for effect in missing_effects(machine, without)]
    jobs = [pool.submit(_of_effect, machine, observed, name) for name in effects]
    runs = [
        CalibratedRun(machine, run, part) for run, part in zip(observed, sensitivities, strict=True)
    ]
    changes = {
        name: [change for change in kind.all_of(runs) if _is_sound(machine, change)]
        for name, kind in kinds().items()
        if described
    }
    by_run = [job.result() for job in [pool.submit(_of_changes, run, changes) for run in runs]]
    tried: list[Addition] = [AddedEffect(candidate) for job in jobs for candidate in job.result()]
    for name, of_kind in changes.items():
        for i, change in enumerate(of_kind):
            for j, numbers in enumerate(change.points()):
                answers = tuple(run[name][i][j] for run in by_run)
                tried.append(AddedChange(change, numbers, answers))
    shown = [addition for addition in tried if _squares(addition.answers) > NEGLIGIBLE_SQUARES]
    return Listed(shown, prior_costs({addition.key for addition in shown}))


def _squares(answers: Sequence[FloatArray]) -> float:
    return sum(float(answer @ answer) for answer in answers)


def _is_sound(machine: Machine, change: Change) -> bool:
    """Whether effects in force keep their drivers: a part in two may no longer touch another."""
    driven = any(":" in key for key in machine.effects)
    return not driven or has_its_drivers(change.put_into(machine, change.points()[0]))


def _of_effect(machine: Machine, observed: Sequence[Observations], name: str) -> list[Candidate]:
    return list(candidates(machine, observed, catalogue()[name]))


def _of_changes(
    run: CalibratedRun, changes: dict[str, list[Change]]
) -> dict[str, list[FloatArray]]:
    return {name: kinds()[name].answers(of_kind, run) for name, of_kind in changes.items()}
