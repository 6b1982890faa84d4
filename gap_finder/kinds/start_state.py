"""Parts with a wrong starting temperature: without a sensor, or not at rest when a run begins.

The machine file says at which signal's temperature a part starts. If the part is still warm from
the run before, or has no sensor, this may be wrong, and a wrong start looks like a slow effect.
Here every part, and all parts with the same boundary as their start together, are tried at every
other signal. No simulation is needed: calibration already has the responses to starting
temperatures.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from gap_finder.kinds.base import SHARES_OF_WAY, CalibratedRun, ComputedChange
from gap_finder.linearise import START_K
from gap_finder.priors import FAR
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import column_of


@dataclass(frozen=True)
class StartState(ComputedChange):
    """Another starting temperature of some parts.

    Attributes
    ----------
    signal : str
        The thermometer or input at whose temperature they start.
    shares : tuple of float
        Shares tried, of the way there from the first boundary temperature [1].
    at_hall : bool
        Whether they start at the first boundary in the file: only then can the share be scaled.
    """

    title: ClassVar[str] = "Part that starts at another temperature than the machine file says"
    amplitude: ClassVar[str] = "share"

    signal: str
    shares: tuple[float, ...]
    at_hall: bool

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield every part, and all parts that start at the same boundary, at every signal."""
        machine = runs[0].machine
        firsts = [_first_values(run) for run in runs]
        begins = [_begins(run) for run in runs]
        hall = next(iter(machine.boundary_index))
        for place in _places(machine):
            at = [machine.node_index[name] for name in place]
            at_hall = all(machine.nodes[i].start == hall for i in at)
            # Starts that differ from the file's by less than the prior allows are not tried.
            for signal in (name for name in firsts[0] if all(name in first for first in firsts)):
                shares = tuple(
                    share
                    for share in (SHARES_OF_WAY if signal != hall else SHARES_OF_WAY[-1:])
                    if max(
                        float(np.abs(_target(first, hall, signal, share) - begin[at]).max())
                        for first, begin in zip(firsts, begins, strict=True)
                    )
                    >= FAR * START_K
                )
                if shares:
                    yield cls(place, signal, shares, at_hall)

    def points(self) -> list[dict[str, float]]:
        """Return the shares."""
        return [{self.amplitude: share} for share in self.shares]

    def scaled(self, numbers: Mapping[str, float], scale: float) -> dict[str, float]:
        """Return the share multiplied by *scale* if the file starts the parts at the hall."""
        share = numbers[self.amplitude] * (scale if self.at_hall else 1.0)
        return {self.amplitude: round(share, 3)}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with these parts starting there."""
        nodes = tuple(
            replace(node, start=self.signal, start_share=numbers[self.amplitude])
            if node.name in self.place
            else node
            for node in machine.nodes
        )
        return replace(machine, nodes=nodes)

    def read(self, machine: Machine) -> dict[str, float]:
        """Return the share."""
        return {self.amplitude: machine.nodes[machine.node_index[self.place[0]]].start_share}

    def details(self, machine: Machine) -> dict[str, Any]:
        """Return the signal and the share."""
        share = self.read(machine)[self.amplitude]
        number = {"value": share, "low": share, "high": share, "unit": "1"}
        return {"starts_at": self.signal, "parameters": {self.amplitude: number}}

    @classmethod
    def of_run(cls, changes: Sequence[Self], run: CalibratedRun) -> list[FloatArray]:
        """Return the responses, which follow from those that calibration already has."""
        machine = run.machine
        first, begin = _first_values(run), _begins(run)
        hall = next(iter(machine.boundary_index))
        by_start = run.sensitivities.starts
        answers = []
        for change in changes:
            at = [machine.node_index[name] for name in change.place]
            targets = [_target(first, hall, change.signal, share) for share in change.shares]
            columns = [by_start[:, at] @ (target - begin[at]) / START_K for target in targets]
            answers.append(np.array(columns))
        return answers


def _target(first: Mapping[str, float], hall: str, signal: str, share: float) -> float:
    return first[hall] + share * (first[signal] - first[hall])


def _begins(run: CalibratedRun) -> FloatArray:
    """Return the starting temperature of every part from the file [degC], shape (nodes,)."""
    return np.asarray(run.simulated.temperatures[0, 0])


def _places(machine: Machine) -> list[tuple[str, ...]]:
    """Return every part, and each group of parts that start at the same boundary temperature."""
    together = [
        tuple(node.name for node in machine.nodes if node.start == name)
        for name in machine.boundary_index
    ]
    return [(node.name,) for node in machine.nodes] + [p for p in together if len(p) > 1]


def _first_values(run: CalibratedRun) -> dict[str, float]:
    """Return the first value of every boundary temperature and thermometer of a run [degC]."""
    observed = run.observed
    firsts = {name: float(values[0]) for name, values in observed.drive.first.items()}
    for name, length in zip(observed.channels, observed.lengths.tolist(), strict=True):
        column = column_of(run.machine, name)
        if not length and column in observed.run.frame:
            read = observed.run.frame[column].dropna()
            if len(read):
                firsts[name] = float(read.iloc[0])
    return {name: firsts[name] for name in sorted(firsts)}
