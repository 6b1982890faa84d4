"""A shaft that another bearing locates than the machine file says, or one at another place.

Shaft, housing and its rings then count from that place, so that the nose grows by more or less and
even the other way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from gap_finder.kinds.base import SHARES_OF_WAY, CalibratedRun, Change
from gap_finder.linearise import simulate_runs
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

WAYS = {"to_nose": 1.0, "from_nose": -1.0}
"""Directions from where the file places it, by their sign along the axis."""


@dataclass(frozen=True)
class LocatingBearing(Change):
    """A locating bearing further along the axis, in one direction."""

    title: ClassVar[str] = "Bearing at another place that locates the shaft"
    amplitude: ClassVar[str] = "moved"

    item: str
    at: float
    farthest: float

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield both directions in which shaft and housing continue.

        None if calibration moves the bearing already.
        """
        machine = runs[0].machine
        shaft, housing = (_ends(machine, kind) for kind in ("shaft", "housing"))
        for item in machine.of_kind("structure", "located"):
            at = item.parameters["at"]
            room = {
                "to_nose": min(shaft[1], housing[1]) - at.value,
                "from_nose": at.value - max(shaft[0], housing[0]),
            }
            for way, most in room.items():
                if most > 0.0 and not at.calibrate:
                    yield cls((way,), item.name, at.value, most)

    def points(self) -> list[dict[str, float]]:
        """Return half of the way to the end of what carries the shaft, and all of it."""
        return [{self.amplitude: share * self.farthest} for share in SHARES_OF_WAY]

    def parameters(self) -> dict[str, str]:
        """Return the bearing's place."""
        return {"at": f"structure.{self.item}.at"}

    def centre(self) -> dict[str, float]:
        """Return the middle of the usual distances."""
        return {self.amplitude: float(np.sqrt(np.prod(self.usual(self.amplitude))))}

    def possible(self, number: str) -> tuple[float, float]:
        """Return the range of the bearing's place [mm]."""
        end = self._place(self.farthest)
        return min(self.at, end), max(self.at, end)

    def read(self, machine: Machine) -> dict[str, float]:
        """Return how far it has moved in its direction [mm]."""
        at = machine.parameters[self.parameters()["at"]].value
        return {self.amplitude: max(WAYS[self.place[0]] * (at - self.at), 0.0)}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with the bearing there."""
        at = self.free({"at": self._place(numbers[self.amplitude])}, "at", "mm")
        items = tuple(
            replace(item, parameters={**item.parameters, "at": at})
            if (item.kind, item.name) == ("located", self.item)
            else item
            for item in machine.items
        )
        return replace(machine, items=items)

    def _place(self, moved: float) -> float:
        return self.at + WAYS[self.place[0]] * moved

    @classmethod
    def answers(
        cls, changes: Sequence[Self], runs: Sequence[CalibratedRun]
    ) -> list[list[FloatArray]]:
        """Return the responses; temperatures do not change, and are stepped once."""
        observed = [run.observed for run in runs]
        answers: list[list[FloatArray]] = [[] for _ in runs]
        for change in changes:
            tried = [change._place(point[change.amplitude]) for point in change.points()]
            places = {change.parameters()["at"]: np.array(tried)}
            simulated = simulate_runs(runs[0].machine, observed, places)
            for run, moved, of_run in zip(runs, simulated, answers, strict=True):
                of_run.append(run.response(moved))
        return answers


def _ends(machine: Machine, kind: str) -> tuple[float, float]:
    """Return where all segments of a kind begin and end [mm]; they begin at infinity if none."""
    items = [item.parameters for item in machine.of_kind("structure", kind)]
    starts, ends = ([numbers[end].value for numbers in items] for end in ("start", "end"))
    return min(starts, default=np.inf), max(ends, default=-np.inf)
