"""Base classes of all changes of a machine's description: place, numbers, how to apply them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from gap_finder.added_paths import AddedPath, path_answers
from gap_finder.design import RunSensitivities
from gap_finder.keys import key_of
from gap_finder.linearise import modelled, simulate_runs
from gap_finder.observations import Observations
from plant_model.effects import catalogue
from plant_model.effects.base import TIMES_USUAL
from plant_model.integrate import IntegrationError
from plant_model.machine import FAMILIES, Input, Item, Machine
from plant_model.parameters import FloatArray, Parameter
from plant_model.simulate import Simulation

SOURCE = "found by the gap finder"

SIZES_W_PER_K = (3.0, 30.0)
"""Usual conductances of a path [W/K]: small for a thin section or a surface in still air, large for
a joint or stirred air. Set on no data."""

SHARES_OF_WAY = (0.5, 1.0)
"""Shares tried, of the way from what the file says to the farthest that is usual [1]. Set on no
data."""


@dataclass(frozen=True)
class CalibratedRun:
    """A run, simulated with the calibrated machine, and its derivatives about it.

    Attributes
    ----------
    machine : Machine
    observed : Observations
    simulated : Simulation
    sensitivities : RunSensitivities
    """

    machine: Machine
    observed: Observations
    simulated: Simulation
    sensitivities: RunSensitivities

    @cached_property
    def _shown(self) -> FloatArray:
        return modelled(self.simulated, self.observed)

    def response(self, changed: Simulation) -> FloatArray:
        """Return how another simulation of the run differs from it, weighted, (sets, N) [1]."""
        return self.observed.response(modelled(changed, self.observed) - self._shown)


@dataclass(frozen=True)
class Change(ABC):
    """A change of the description at a place.

    Attributes
    ----------
    name, title : str
        Its kind, which is the file's name, and the title in reports.
    amplitude : str
        The number that the response grows with: at 0 nothing is changed.
    at_once : int
        Number of changes simulated in one machine, each with all others off; 1 if a change cannot
        be switched off by its number.
    only_heats : bool
        Whether it adds heat and changes no path, so that its response is proportional to its
        amplitude where the machine is linear: it is then simulated to first order.
    on_channel : bool
        Whether it acts on one measured channel, the first of its place.
    place : tuple of str
        The parts, inputs, sensors or axes.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    amplitude: ClassVar[str]
    at_once: ClassVar[int] = 40
    only_heats: ClassVar[bool] = False
    on_channel: ClassVar[bool] = False

    place: tuple[str, ...]

    def __init_subclass__(cls) -> None:
        """Name a kind after its file."""
        cls.name = cls.__module__.rpartition(".")[2]

    @property
    def key(self) -> str:
        """Its key among all candidates."""
        return key_of(self.name, self.place)

    @property
    def made(self) -> str:
        """Name of the part or item that it adds; empty if it only changes what is there."""
        return ""

    @classmethod
    @abstractmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield all changes of this kind that a machine may lack, even if it has what they add.

        Parameters
        ----------
        runs : sequence of CalibratedRun
            All of the same machine.
        """

    @abstractmethod
    def points(self) -> list[dict[str, float]]:
        """Return the numbers at which it is tried."""

    def simulated(self) -> tuple[list[dict[str, float]], FloatArray]:
        """Return the points to simulate, and the shares of their responses in each of `points`.

        Fewer are enough where responses are proportional to a number.

        Returns
        -------
        points : list of dict of str to float
        shares : array, shape (points, simulated points)
        """
        points = self.points()
        return points, np.eye(len(points))

    @abstractmethod
    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this change, its numbers free to be calibrated.

        Parameters
        ----------
        machine : Machine
        numbers : mapping of str to float
            One of `points`, or the result of `read`.
        """

    def usual(self, number: str) -> tuple[float, float]:
        """Return the smallest and the largest of a number's `points`: its usual range."""
        tried = [point[number] for point in self.points()]
        return min(tried), max(tried)

    def possible(self, number: str) -> tuple[float, float]:
        """Return the range of a number's prior, which is wide because nothing is known about it."""
        low, high = self.usual(number)
        return low / TIMES_USUAL, high * TIMES_USUAL

    def centre(self) -> dict[str, float]:
        """Return the centre of the prior of each calibrated number, wherever the search starts."""
        return {name: float(np.sqrt(np.prod(self.usual(name)))) for name in self.parameters()}

    def parameters(self) -> dict[str, str]:
        """Return the full names of its numbers in the changed machine; empty if it has none."""
        return {}

    def scaled(self, numbers: Mapping[str, float], scale: float) -> dict[str, float]:
        """Return its numbers for a response multiplied by *scale*.

        Parameters
        ----------
        numbers : mapping of str to float
        scale : float
            Of either sign [1].
        """
        return {**numbers, self.amplitude: numbers[self.amplitude] * scale}

    def read(self, machine: Machine) -> dict[str, float]:
        """Return its numbers in a machine that has it.

        Parameters
        ----------
        machine : Machine
            One returned by `put_into`.

        Returns
        -------
        dict of str to float
            By the change's own names, each in its parameter's unit.
        """
        parameters = self.parameters().items()
        return {number: machine.parameters[name].value for number, name in parameters}

    def free(self, numbers: Mapping[str, float], number: str, unit: str) -> Parameter:
        """Return one of its numbers for calibration to move, its range including the value."""
        value, (low, high) = numbers[number], self.possible(number)
        return Parameter(value, unit, min(low, value), max(high, value), SOURCE, calibrate=True)

    def shown(self, number: dict[str, Any]) -> dict[str, Any]:
        """Return a calibrated number as its report shows it.

        Parameters
        ----------
        number : dict of str to Any
            ``value``, ``low``, ``high`` and ``unit`` of one of its parameters.
        """
        return number

    def details(self, machine: Machine) -> dict[str, Any]:
        """Return further entries for its report.

        Parameters
        ----------
        machine : Machine
            With the change, calibrated.
        """
        return {}

    @classmethod
    def answers(
        cls, changes: Sequence[Self], runs: Sequence[CalibratedRun]
    ) -> list[list[FloatArray]]:
        """Return the weighted responses of runs to changes of this kind.

        Parameters
        ----------
        changes : sequence of Change
        runs : sequence of CalibratedRun
            All of the same machine.

        Returns
        -------
        list of list of array, each (points, N)
            Of each run to each change: model with it minus model without, times the weights [1]. N
            is instants times channels.
        """
        answers: list[list[FloatArray]] = [[] for _ in runs]
        for start in range(0, len(changes), cls.at_once):
            together = cls._simulated(changes[start : start + cls.at_once], runs)
            for of_run, more in zip(answers, together, strict=True):
                of_run += more
        return answers

    @classmethod
    def _simulated(
        cls, changes: Sequence[Self], runs: Sequence[CalibratedRun]
    ) -> list[list[FloatArray]]:
        grown = runs[0].machine
        points, shares = zip(*(change.simulated() for change in changes), strict=True)
        for change, tried in zip(changes, points, strict=True):
            grown = change.put_into(grown, tried[0])
        off = int(cls.only_heats)  # the first set then has none, and all are stepped about it
        ends = off + np.cumsum([len(tried) for tried in points])
        sets: dict[str, FloatArray] = {}
        for change, tried, end in zip(changes, points, ends, strict=True):
            for number, name in change.parameters().items():
                column = np.full(ends[-1], 0.0 if number == cls.amplitude else tried[0][number])
                column[end - len(tried) : end] = [point[number] for point in tried]
                sets[name] = column
        try:
            observed = [run.observed for run in runs]
            simulated = simulate_runs(grown, observed, sets, near=cls.only_heats)
        except IntegrationError:
            # One that cannot be stepped responds nowhere; the rest is simulated without it.
            half = len(changes) // 2
            if not half:
                return [[np.zeros((len(shares[0]), run.observed.weights.size))] for run in runs]
            parts = [cls._simulated(some, runs) for some in (changes[:half], changes[half:])]
            return [first + rest for first, rest in zip(*parts, strict=True)]
        by_run = [
            np.split(run.response(with_them), [off, *ends[:-1]])[1:]
            for run, with_them in zip(runs, simulated, strict=True)
        ]
        return [
            [share @ answer for share, answer in zip(shares, by_change, strict=True)]
            for by_change in by_run
        ]


class ComputedChange(Change):
    """A change whose responses follow from the calibrated run, without simulating it."""

    @classmethod
    @abstractmethod
    def of_run(cls, changes: Sequence[Self], run: CalibratedRun) -> list[FloatArray]:
        """Return a run's weighted response to each change, (points, N)."""

    @classmethod
    def answers(
        cls, changes: Sequence[Self], runs: Sequence[CalibratedRun]
    ) -> list[list[FloatArray]]:
        """Return the responses, computed run by run."""
        return [cls.of_run(changes, run) for run in runs]


class PathChange(ComputedChange):
    """A change that adds one heat path; thousands of them are computed together."""

    amplitude: ClassVar[str] = "conductance"

    def points(self) -> list[dict[str, float]]:
        """Return a small and a large conductance."""
        return [{self.amplitude: size} for size in SIZES_W_PER_K]

    @abstractmethod
    def path(self) -> AddedPath:
        """Return the path, at all sizes of `points`."""

    def sizes(self) -> tuple[float, ...]:
        """Return the conductances of `points` [W/K]."""
        return tuple(point[self.amplitude] for point in self.points())

    @classmethod
    def of_run(cls, changes: Sequence[Self], run: CalibratedRun) -> list[FloatArray]:
        """Return the responses to all paths, computed together."""
        return path_answers(run.machine, run.observed, [change.path() for change in changes])


def with_item(machine: Machine, item: Item, effect: str) -> Machine:
    """Return the machine with one more item and the effect that defines its law."""
    effects = machine.effects
    if effect not in effects:
        effects = effects | {effect: dict(catalogue()[effect].parameters)}
    of_family = {family: [i for i in machine.items if i.family == family] for family in FAMILIES}
    of_family[item.family].append(item)
    items = tuple(grown for family in FAMILIES for grown in of_family[family])
    return replace(machine, items=items, effects=effects)


def fixed(value: float, unit: str) -> Parameter:
    """Return a fixed number."""
    return Parameter(value, unit, value, value, SOURCE)


def joined(
    machine: Machine, pair: tuple[str, str], conductance: Parameter, area_m2: float = 1.0
) -> Machine:
    """Return the machine with a heat path; one to a boundary temperature is a film.

    *conductance* is then the film's coefficient [W/(m2 K)] on an area, which film laws act on.
    """
    if pair[1] in machine.boundary_index:
        film = replace(conductance, unit="W/(m2 K)")
        given, kind = {"area": fixed(area_m2, "m2"), "coefficient": film}, "convection"
        law = "surface_convection"
    else:
        given, kind, law = {"conductance": conductance}, "conduction", "conduction"
    return with_item(machine, Item("links", "-".join(pair), kind, {"between": pair}, given), law)


def conductance_of(pair: tuple[str, str], *, boundary: bool) -> str:
    """Return the full name of the parameter of a path made by `joined`."""
    return f"links.{'-'.join(pair)}.{'coefficient' if boundary else 'conductance'}"


def joinable(machine: Machine) -> list[str]:
    """Return what a new part can be joined to: parts and boundary temperatures."""
    parts = [node.name for node in machine.nodes] if "conduction" in machine.effects else []
    if "surface_convection" in machine.effects:
        parts += list(machine.boundary_index)
    return parts


def recorded(runs: Sequence[CalibratedRun]) -> list[Input]:
    """Return the machine's inputs that any run has a column of, without boundary temperatures."""
    columns = set().union(*(run.observed.run.frame.columns for run in runs))
    inputs = runs[0].machine.inputs
    return [entry for entry in inputs if not entry.is_boundary and entry.column in columns]


def taken_names(machine: Machine) -> set[str]:
    """Return the names of the machine's parts, items and signals."""
    taken = {node.name for node in machine.nodes} | {item.name for item in machine.items}
    taken |= {sensor.name for sensor in machine.sensors}
    return taken | {entry.name for entry in machine.inputs}
