"""A thermometer that partly or wholly reads another part than the machine file says.

It is modelled as a small tip between the two parts, with almost no mass and conductance. The ratio
of its two contacts determines which share of each part it reads.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from gap_finder.design import PLACE_SHARE
from gap_finder.kinds.base import (
    CalibratedRun,
    ComputedChange,
    conductance_of,
    fixed,
    joinable,
    joined,
)
from plant_model.effects.base import TIMES_USUAL
from plant_model.machine import Machine, Node
from plant_model.parameters import FloatArray

TIP_SHARES = (2.0 * PLACE_SHARE, 1.0 - 2.0 * PLACE_SHARE)
"""Usual shares, which are tried [1]: a thermometer near an edge, or one whose part is mistaken.
Given by what is not yet misplaced."""

CONTACT_W_PER_K, TIP_J_PER_K, TIP_M2 = 0.01, 0.03, 1e-4
"""The tip's contact with its own part, its heat capacity and its surface [W/K, J/K, m2]: it follows
within seconds, carries less heat between the parts than any visible path, and is hardly affected by
film laws. Set on no data."""


@dataclass(frozen=True)
class SensorPlace(ComputedChange):
    """A misplaced thermometer; the place is the thermometer and the other part."""

    title: ClassVar[str] = "Thermometer that reads partly another part"
    amplitude: ClassVar[str] = "share"
    on_channel: ClassVar[bool] = True

    of: str
    boundary: bool

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield every thermometer on a part with every other part and boundary temperature."""
        machine, channels = runs[0].machine, runs[0].observed.channels
        others = joinable(machine)
        for sensor in machine.sensors:
            if sensor.name in channels and sensor.of in others and sensor.of in machine.node_index:
                for other in (name for name in others if name != sensor.of):
                    yield cls((sensor.name, other), sensor.of, other in machine.boundary_index)

    @property
    def made(self) -> str:
        """Name of the tip."""
        return f"{self.place[0]}_tip"

    def points(self) -> list[dict[str, float]]:
        """Return a small and a large share: the response is proportional to them."""
        return [{self.amplitude: share} for share in TIP_SHARES]

    def parameters(self) -> dict[str, str]:
        """Return the tip's contact with the other part."""
        return {self.amplitude: conductance_of((self.made, self.place[1]), boundary=self.boundary)}

    def centre(self) -> dict[str, float]:
        """Return the middle of the usual shares, by their odds."""
        odds = float(np.sqrt(np.prod([_odds(share) for share in TIP_SHARES])))
        return {self.amplitude: odds / (1.0 + odds)}

    def scaled(self, numbers: Mapping[str, float], scale: float) -> dict[str, float]:
        """Return the share multiplied by *scale*, at most the largest usual one."""
        return {self.amplitude: min(numbers[self.amplitude] * scale, TIP_SHARES[-1])}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with the thermometer on a tip between the two parts."""
        name, other = self.place
        nodes = (*machine.nodes, Node(self.made, fixed(TIP_J_PER_K, "J/K"), name))
        sensors = tuple(
            replace(sensor, of=self.made) if sensor.name == name else sensor
            for sensor in machine.sensors
        )
        grown = replace(machine, nodes=nodes, sensors=sensors)
        grown = joined(grown, (self.made, self.of), fixed(CONTACT_W_PER_K, "W/K"))
        contact = {self.amplitude: self._contact * _odds(numbers[self.amplitude])}
        touching = self.free(contact, self.amplitude, "W/K")
        return joined(grown, (self.made, other), touching, TIP_M2)

    @property
    def _contact(self) -> float:
        """Contact with the other part for equal shares [W/K]; with a boundary, film [W/(m2 K)]."""
        return CONTACT_W_PER_K / TIP_M2 if self.boundary else CONTACT_W_PER_K

    def possible(self, number: str) -> tuple[float, float]:
        """Return the range of the tip's contact with the other part."""
        low, high = (self._contact * _odds(share) for share in self.usual(number))
        return low / TIMES_USUAL, high * TIMES_USUAL

    def read(self, machine: Machine) -> dict[str, float]:
        """Return the share of the other part that it reads."""
        g = machine.parameters[self.parameters()[self.amplitude]].value
        return {self.amplitude: self._share(g)}

    def _share(self, contact: float) -> float:
        return contact / (contact + self._contact)

    def shown(self, number: dict[str, Any]) -> dict[str, Any]:
        """Return the share instead of the tip's contact."""
        return {end: self._share(number[end]) for end in ("value", "low", "high")} | {"unit": "1"}

    @classmethod
    def of_run(cls, changes: Sequence[Self], run: CalibratedRun) -> list[FloatArray]:
        """Return the responses without simulating the tip: means of known temperatures."""
        index, observed, shown = run.machine.node_index, run.observed, run.simulated
        warm = shown.temperatures[0, 1:]
        answers = []
        for change in changes:
            sensor, other = change.place
            column = observed.channels.index(sensor)
            there = warm[:, index[other]] if other in index else shown.inputs[other][1:]
            out = np.zeros((len(TIP_SHARES), len(observed.time_s), len(observed.channels)))
            out[..., column] = np.outer(TIP_SHARES, there - warm[:, index[change.of]])
            answers.append(observed.response(out))
        return answers


def _odds(share: float) -> float:
    return share / (1.0 - share)
