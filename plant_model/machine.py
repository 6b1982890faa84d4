"""Description of a machine: nodes, items that act on them, inputs, sensors, rig, effects in force.

This module holds only data and imports only the standard library: the plant FMU contains a machine
as JSON.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property
from typing import Any, get_args, get_origin, get_type_hints

from plant_model.parameters import NUMBERS, Parameter, ParameterError

FAMILIES = ("links", "sources", "structure")
FIVE_POINT = {"near_x": "X", "near_y": "Y", "distal_x": "X", "distal_y": "Y", "axial": "Z"}
"""Axis along which each displacement sensor of a five-point rig measures."""


@dataclass(frozen=True)
class Input:
    """A quantity that drives the machine and is not computed.

    Attributes
    ----------
    name, unit : str
        The signal, for example ``ambient`` in ``degC``.
    column : str
        The run-file column that holds it.
    low, high : float
        The model's intended range [unit].
    default : float or None
        Its value if a run has no such column; None if a run must have it.
    """

    name: str
    unit: str
    column: str
    low: float
    high: float
    default: float | None = None

    @property
    def is_boundary(self) -> bool:
        """Whether it is a temperature, which nodes can exchange heat with."""
        return self.unit == "degC"

    @property
    def most(self) -> float:
        """The largest absolute value of its range [unit]."""
        return max(abs(self.low), abs(self.high))


REST = "rest"
"""Value of a node's ``start`` if it starts at its temperature in a machine long at rest."""


@dataclass(frozen=True)
class Node:
    """A lump of one temperature, and its start.

    It starts at the first value of the signal *start*, or at the share *start_share* of the way
    there from the first boundary temperature; with :data:`REST`, at its temperature in a machine
    long at rest (:mod:`plant_model.rest`).
    """

    name: str
    capacity: Parameter
    start: str
    start_share: float = 1.0

    @property
    def rests(self) -> bool:
        """Whether it starts at its temperature in a machine long at rest."""
        return self.start == REST

    def starts_at(self, first: Mapping[str, float], usual: float) -> float:
        """Return its start temperature [degC].

        Parameters
        ----------
        first : mapping of str to float
            First values of signals, by name [degC].
        usual : float
            The first boundary temperature, which replaces missing signals [degC].
        """
        value = first.get(self.start, usual)
        # A share of 1 must not round.
        return value if self.start_share == 1.0 else usual + self.start_share * (value - usual)


@dataclass(frozen=True)
class Item:
    """A link, a heat source or a part of the structure; the effect of its *kind* defines its law.

    Attributes
    ----------
    family : str
        ``links``, ``sources`` or ``structure``.
    name, kind : str
        Its name and its kind, for example ``convection``.
    refs : dict of str to tuple of str
        The nodes and inputs that it refers to, by role.
    parameters : dict of str to Parameter
        Its numbers, by name.
    """

    family: str
    name: str
    kind: str
    refs: dict[str, tuple[str, ...]]
    parameters: dict[str, Parameter]

    def parameter_name(self, parameter: str) -> str:
        """Return the full name of one of its parameters.

        Parameters
        ----------
        parameter : str
            Its name in *parameters*.
        """
        return f"{self.family}.{self.name}.{parameter}"


@dataclass(frozen=True)
class Sensor:
    """A thermometer: what it reads, with its noise (one standard deviation) and resolution."""

    name: str
    unit: str
    of: str
    noise: float
    resolution: float

    @property
    def column(self) -> str:
        """The run-file column of its readings."""
        return f"{self.name}_{self.unit}"


@dataclass(frozen=True)
class Axis:
    """How the control applies offsets: slew limit [um/s], saturation [um], resolution [um]."""

    slew_um_per_s: float = 10.0
    limit_um: float = 300.0
    resolution_um: float = 0.1

    @property
    def increment_um(self) -> float:
        """The resolution, or without one what is as fine as a double allows in practice [um]."""
        return self.resolution_um or 1e-9

    @property
    def farthest_um(self) -> float:
        """The largest offset: as many whole increments as the limit has room for [um]."""
        return math.floor(self.limit_um / self.increment_um + 1e-9) * self.increment_um


@dataclass(frozen=True)
class Machine:
    """A machine file, read and checked; tied parameters follow one of *numbers*."""

    name: str
    title: str
    description: str
    inputs: tuple[Input, ...]
    nodes: tuple[Node, ...]
    items: tuple[Item, ...]
    sensors: tuple[Sensor, ...]
    rig: dict[str, Any]
    axis: Axis
    effects: dict[str, dict[str, Parameter]]
    references: dict[str, str] = field(default_factory=dict)
    numbers: dict[str, Parameter] = field(default_factory=dict)

    @cached_property
    def node_index(self) -> dict[str, int]:
        """Position of every node."""
        return {node.name: i for i, node in enumerate(self.nodes)}

    @cached_property
    def boundary_index(self) -> dict[str, int]:
        """Position of each boundary temperature among the boundary temperatures."""
        names = [entry.name for entry in self.inputs if entry.is_boundary]
        return {name: i for i, name in enumerate(names)}

    @cached_property
    def probes(self) -> dict[str, str]:
        """Axis along which each displacement sensor measures, by sensor name."""
        if self.rig["kind"] == "direct":
            return {name: entry["axis"] for name, entry in self.rig["axes"].items()}
        return {self.rig[role]: axis for role, axis in FIVE_POINT.items()}

    @cached_property
    def signs(self) -> dict[str, int]:
        """Factor from drift along the axis to each displacement sensor's reading, by name."""
        if self.rig["kind"] == "direct":
            return {name: entry["sign"] for name, entry in self.rig["axes"].items()}
        given = (self.rig.get(f"{role}_sign", 1) for role in FIVE_POINT)
        # The axial sign is from reading to elongation, and elongation is growth towards -Z.
        return {
            name: -sign if axis == "Z" else sign
            for (name, axis), sign in zip(self.probes.items(), given, strict=True)
        }

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """Every parameter by its full name, in the file's order."""
        return dict(self._walk_parameters())

    def _walk_parameters(self) -> Iterator[tuple[str, Parameter]]:
        for name, number in self.numbers.items():
            yield f"{NUMBERS}{name}", number
        for node in self.nodes:
            yield f"nodes.{node.name}.capacity", node.capacity
        for item in self.items:
            for name, parameter in item.parameters.items():
                yield item.parameter_name(name), parameter
        for effect, parameters in self.effects.items():
            for name, parameter in parameters.items():
                yield f"effects.{effect}.{name}", parameter

    def of_kind(self, family: str, *kinds: str) -> list[Item]:
        """Return the items of a family that are of one of the kinds, in the file's order.

        Parameters
        ----------
        family : str
            One of `FAMILIES`.
        *kinds : str
            Any of them.
        """
        return [item for item in self.items if item.family == family and item.kind in kinds]

    def with_values(self, values: dict[str, float], *, beyond: bool = False) -> Machine:
        """Return the machine with some parameters moved to other values.

        Parameters
        ----------
        values : dict of str to float
            By full name, in the parameters' units. Followers of a named number move with it.
        beyond : bool
            Accept values outside the range: the range is then extended, and the source states the
            original one.

        Raises
        ------
        ParameterError
            For an unknown name or a value outside the parameter's range.
        """
        for name, value in values.items():
            parameter = self.parameters.get(name)
            if parameter is None:
                raise ParameterError(f"{name}: the machine has no parameter of this name")
            if parameter.tied:
                raise ParameterError(f"{name}: follows {parameter.tied}, so move that")
            if not (beyond or parameter.low <= value <= parameter.high):
                allowed = f"{parameter.low:g}..{parameter.high:g} {parameter.unit}"
                raise ParameterError(f"{name}: {value:g} is outside {allowed}")

        def moved(name: str, parameter: Parameter) -> Parameter:
            if parameter.tied in values:
                number = self.parameters[parameter.tied].moved(values[parameter.tied])
                return replace(parameter.following(number.value), source=number.source)
            return parameter.moved(values[name]) if name in values else parameter

        return replace(
            self,
            nodes=tuple(
                replace(node, capacity=moved(f"nodes.{node.name}.capacity", node.capacity))
                for node in self.nodes
            ),
            items=tuple(
                replace(
                    item,
                    parameters={
                        name: moved(item.parameter_name(name), parameter)
                        for name, parameter in item.parameters.items()
                    },
                )
                for item in self.items
            ),
            effects={
                effect: {
                    name: moved(f"effects.{effect}.{name}", parameter)
                    for name, parameter in parameters.items()
                }
                for effect, parameters in self.effects.items()
            },
            numbers={
                name: moved(f"{NUMBERS}{name}", number) for name, number in self.numbers.items()
            },
        )

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain dicts and lists, ready for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Machine:
        """Rebuild a machine from :meth:`to_dict`.

        Parameters
        ----------
        table : dict
            From `to_dict`, also after a round trip through JSON.

        Returns
        -------
        Machine
        """
        made: Machine = _made(cls, table)
        return made


_hints = cache(get_type_hints)


def _made(kind: Any, value: Any) -> Any:
    """Rebuild a value from `asdict`, by the types of the fields."""
    if kind is Any or type(value) not in (dict, list, tuple):
        return value
    inner = get_args(kind)
    if get_origin(kind) is tuple:
        return tuple(_made(inner[0], part) for part in value)
    if get_origin(kind) is dict:
        return {name: _made(inner[1], part) for name, part in value.items()}
    hints = _hints(kind)
    return kind(**{name: _made(hints[name], part) for name, part in value.items()})
