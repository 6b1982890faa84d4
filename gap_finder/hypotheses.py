"""The one list of what may be missing: every effect and every change of the description.

A kind is a law of the catalogue or a kind of change; it has one candidate for each driver, channel
or place. "Nothing" has half of the prior probability; the kinds share the rest evenly, so do the
bodies at which a kind may act, and so do the cells of a body: a finer mesh makes no other place
less likely. Every further addition again costs its own share.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from gap_finder.candidates import Candidate, candidates, missing_effects
from gap_finder.design import RunSensitivities
from gap_finder.directions import NEGLIGIBLE_SQUARES
from gap_finder.keys import bodies_of, has_its_drivers, law_of
from gap_finder.kinds import CalibratedRun, Change, kinds
from gap_finder.kinds.base import taken_names
from gap_finder.linearise import simulate_runs
from gap_finder.observations import Observations
from gap_finder.priors import heavy_tail
from gap_finder.score import Fit
from plant_model.anatomy import bodies
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.simulate import Simulation


class Addition(Protocol):
    """Something that a hypothesis adds to the machine, with the numbers at which it is tried."""

    @property
    def key(self) -> str:
        """Its name; the kind comes before the colon."""

    @property
    def answers(self) -> tuple[FloatArray, ...]:
        """Weighted response of every run, each (N,)."""

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with it, its numbers as tried."""

    def base(self, machine: Machine) -> Machine:
        """Return the machine with it, its numbers at the centre of the prior."""

    def marked(self, position: int, observed: Observations) -> Observations:
        """Return a run's observations with what is specific to this run."""

    def scaled(self, scale: float) -> Addition:
        """Return it with its response multiplied by *scale*."""

    def read(self, machine: Machine) -> Addition:
        """Return it with the numbers of a machine."""

    def size_cost(self) -> float:
        """Return -2 log of the density of its numbers relative to the most usual ones."""


@dataclass(frozen=True)
class AddedChange:
    """A change of the description; see `Addition`."""

    change: Change
    numbers: Mapping[str, float]
    answers: tuple[FloatArray, ...]

    @property
    def key(self) -> str:
        """Kind, and place after a colon."""
        return self.change.key

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with the change."""
        return self.change.put_into(machine, self.numbers)

    def base(self, machine: Machine) -> Machine:
        """Return the machine with the change, its numbers at the middle of their usual ranges."""
        return self.change.put_into(machine, {**self.numbers, **self.change.centre()})

    def marked(self, position: int, observed: Observations) -> Observations:
        """Return the observations unchanged."""
        return observed

    def scaled(self, scale: float) -> AddedChange:
        """Return it with its response multiplied by *scale*."""
        return replace(self, numbers=self.change.scaled(self.numbers, scale))

    def read(self, machine: Machine) -> AddedChange:
        """Return it with the numbers of a machine."""
        return replace(self, numbers=self.change.read(machine))

    def size_cost(self) -> float:
        """Return the cost of a size that is unusual for its kind."""
        low, high = self.change.usual(self.change.amplitude)
        value = self.numbers[self.change.amplitude]
        return heavy_tail(value, low, high, log=True) if low < high else 0.0


@dataclass(frozen=True)
class Listed:
    """All additions that are tried on a machine, and the prior cost of each.

    Attributes
    ----------
    tried : sequence of Addition
        Each candidate at several sizes.
    costs : dict of str to float
        -2 log of the prior probability of every candidate, by key.
    body : mapping of str to str
        The body of each part that is a cell of one.
    silent : tuple of str
        Effects that change nothing in these runs: nothing drives them, or nothing shows them.
    """

    tried: Sequence[Addition]
    costs: dict[str, float]
    body: Mapping[str, str] = field(default_factory=dict)
    silent: tuple[str, ...] = ()

    def without(self, keys: Collection[str]) -> Listed:
        """Return the list without what is already added, and without its law on other drivers."""
        taken = {law_of(key) for key in keys}
        rest = [addition for addition in self.tried if law_of(addition.key) not in taken]
        costs = prior_costs({addition.key for addition in rest}, self.body)
        return Listed(rest, costs, self.body)


def prior_costs(keys: Collection[str], body: Mapping[str, str]) -> dict[str, float]:
    """Return -2 log of the prior probability of every candidate; "nothing" has 0.

    Parameters
    ----------
    keys : collection of str
        All candidates.
    body : mapping of str to str
        The body of each part that is a cell of one.
    """
    at = {key: bodies_of(key, body) for key in keys}
    cells = Counter(at.values())
    of_kind = Counter(kind for kind, *_ in cells)
    return {
        key: 2.0 * float(np.log(len(of_kind) * of_kind[where[0]] * cells[where]))
        for key, where in at.items()
    }


def all_additions(
    pool: Executor,
    about: Fit,
    sensitivities: Sequence[RunSensitivities],
    without: Sequence[str] = (),
    described: bool = True,
) -> Listed:
    """Return everything that may be added to a calibrated machine, with its response.

    Parameters
    ----------
    pool : Executor
    about : Fit
    sensitivities : sequence of RunSensitivities
        About its machine.
    without : sequence of str
        Effects to ignore.
    described : bool
        Whether the description may also be changed.
    """
    machine, observed = about.machine, about.observed
    plain = simulate_runs(machine, observed)
    runs = [
        CalibratedRun(machine, run, simulated, part)
        for run, simulated, part in zip(observed, plain, sensitivities, strict=True)
    ]
    taken = taken_names(machine)
    changes = [
        [one for one in kind.all_of(runs) if one.made not in taken and _is_sound(machine, one)]
        for kind in kinds().values()
        if described
    ]
    of_changes = [pool.submit(_of_changes, of_kind, runs) for of_kind in changes if of_kind]
    effects = [effect.name for effect in missing_effects(machine, without)]
    of_effects = [pool.submit(_of_effect, machine, observed, plain, name) for name in effects]
    tried: list[Addition] = [addition for job in of_effects for addition in job.result()]
    tried += [addition for job in of_changes for addition in job.result()]
    shown = [addition for addition in tried if _squares(addition.answers) > NEGLIGIBLE_SQUARES]
    keys, body = {addition.key for addition in shown}, bodies(machine)
    names = {name_of(key) for key in keys}
    silent = tuple(name for name in effects if name not in names)
    return Listed(shown, prior_costs(keys, body), body, silent)


def _squares(answers: Sequence[FloatArray]) -> float:
    return sum(float(answer @ answer) for answer in answers)


def _is_sound(machine: Machine, change: Change) -> bool:
    """Whether effects in force keep their drivers: a split part may no longer touch another."""
    driven = any(":" in key for key in machine.effects)
    return not driven or has_its_drivers(change.put_into(machine, change.points()[0]))


def _of_effect(
    machine: Machine, observed: Sequence[Observations], plain: Sequence[Simulation], name: str
) -> list[Candidate]:
    return list(candidates(machine, observed, plain, catalogue()[name]))


def _of_changes(changes: Sequence[Change], runs: Sequence[CalibratedRun]) -> list[AddedChange]:
    answers = zip(*type(changes[0]).answers(changes, runs), strict=True)
    return [
        AddedChange(change, numbers, tuple(answer[i] for answer in of_runs))
        for change, of_runs in zip(changes, answers, strict=True)
        for i, numbers in enumerate(change.points())
    ]
