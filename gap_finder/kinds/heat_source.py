"""Heat sources missing in the machine file: in a part, constant or driven by an input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import ClassVar, Self

from gap_finder.kinds.base import CalibratedRun, Change, fixed, free, with_item
from plant_model.machine import Item, Machine

SIZES_W = (20.0, 200.0)
"""Usual powers, which are tried: the response is proportional to them [W]. Set on no data."""


@dataclass(frozen=True)
class HeatSource(Change):
    """A heat source in a part."""

    name: ClassVar[str] = "heat_source"
    title: ClassVar[str] = "Heat source that the machine file does not have"
    amplitude: ClassVar[str] = "power"
    in_proportion: ClassVar[bool] = True

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield a source for every part, constant or driven by each recorded input.

        An input that already heats the part is left out.
        """
        machine = runs[0].machine
        columns = set().union(*(run.observed.run.frame.columns for run in runs))
        driving = [e.name for e in machine.inputs if not e.is_boundary and e.column in columns]
        sources = [item for item in machine.items if item.family == "sources"]
        names = {item.name for item in sources}
        # If an input already heats a part, its law is wrong, but no source is missing.
        there = {
            (part, driver)
            for item in sources
            for driver in item.refs.get("driven_by", ())
            for part in chain.from_iterable(item.refs.values())
        }
        for node in machine.nodes:
            for driver in ("", *driving):
                change = cls((node.name, driver) if driver else (node.name,))
                if change._name not in names and (node.name, driver) not in there:
                    yield change

    @property
    def _name(self) -> str:
        return "heat_in_" + "_by_".join(self.place)

    def points(self) -> list[dict[str, float]]:
        """Return a small and a large power."""
        return [{self.amplitude: size} for size in SIZES_W]

    def parameters(self) -> dict[str, str]:
        """Return the power, at the top of the input's range if one drives it."""
        return {self.amplitude: f"sources.{self._name}.power"}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this source, proportional to its input if it has one."""
        given = {"power": free(numbers[self.amplitude], "W", self.possible(self.amplitude))}
        refs: dict[str, tuple[str, ...]] = {"node": self.place[:1]}
        kind = "steady_heat"
        if len(self.place) > 1:
            given["exponent"] = fixed(1.0, "1")
            refs["driven_by"], kind = self.place[1:], "driven_heat"
        return with_item(machine, Item("sources", self._name, kind, refs, given), "plain_heat")
