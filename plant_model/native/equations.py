"""A machine's equations as expressions, from the network, effects and sensors that Python runs.

Symbols are in rows: ``p`` tunable parameters, ``u`` the machine's inputs, ``T`` temperatures,
``x`` the effects' own states, ``s`` temperatures at the start, ``w`` time since the start and
length of the tool.
"""

from __future__ import annotations

import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plant_model.effects import Effect, catalogue
from plant_model.machine import Machine
from plant_model.native.trace import Expr, Graph, Traced, UntraceableError, tracing
from plant_model.network import Network, effects_in_force
from plant_model.parameters import Values
from plant_model.plugins import plugged_modules
from plant_model.sensors import readings
from plant_model.structure import drift_at, pose

Place = tuple[int, int]
Cells = list[Any]
"""Numbers and expressions."""


class NoFormulaError(ValueError):
    """A machine that cannot be written in C; the message is one line that names the effect."""


class SymbolicValues(Values):
    """The values of a machine's parameters, with the tunable ones as symbols."""

    def __init__(self, machine: Machine, tunable: Sequence[str], graph: Graph) -> None:
        super().__init__(machine.parameters)
        self._nominal = {name: entry.value for name, entry in machine.parameters.items()}
        self._symbols = {
            name: Traced(graph, np.array([[graph.symbol("p", place)]], dtype=object))
            for place, name in enumerate(tunable)
        }
        self._symbols |= {
            name: self._symbols[entry.tied] * entry.factor
            for name, entry in machine.parameters.items()
            if entry.tied in self._symbols
        }

    def __getitem__(self, name: str) -> Any:
        """Return one parameter, shape (1, 1)."""
        return self._symbols.get(name, self._columns[name])

    def is_off(self, name: str, off: float) -> bool:
        """Return whether the parameter is always exactly *off*."""
        return name not in self._symbols and self._nominal[name] == off


@dataclass(frozen=True)
class Acting:
    """An effect in force, and the parameter that may switch it off.

    Attributes
    ----------
    key : str
    amplitude : int or None
        Place among the tunable parameters; None if it is never off.
    off : float
        The amplitude's value that switches the effect off.
    dependent : bool
        Whether it makes the network non-linear while it is on.
    states : range
        Positions of its own states.
    """

    key: str
    amplitude: int | None
    off: float
    dependent: bool
    states: range


@dataclass(frozen=True)
class Equations:
    """All equations of a plant, as lists of numbers and expressions.

    Attributes
    ----------
    capacity : nodes
    matrix : dict of (int, int) to cell
        L, by a pair of nodes, the first not above the second.
    boundary : dict of (int, int) to cell
        B, by node and boundary.
    force : nodes
        Heat that does not depend on temperature, including that from outside; for this the
        conductances of `boundary` are the symbols of a row ``outside``.
    dependent, rates : nodes; own states
        Heat that depends on temperature; rates of own states.
    slopes : nodes, then own states
        Total rate of each.
    node_scales : nodes
        Error that counts as much as 1 K in error control.
    decay, time_constants, scales : own states
    target, settled, first : own states
    outputs : sensors, then drift in X, Y, Z
    input_count, parameter_count : int
    levels : inputs, by place, that conductances depend on
    one_way : bool
        Whether heat flows one way between nodes.
    lagging, settling : own states of either kind, by place
    acting : effects in force
    """

    capacity: Cells
    matrix: dict[tuple[int, int], Any]
    boundary: dict[tuple[int, int], Any]
    force: Cells
    dependent: Cells
    rates: Cells
    slopes: Cells
    node_scales: Cells
    decay: Cells
    time_constants: Cells
    scales: Cells
    target: Cells
    settled: Cells
    first: Cells
    outputs: Cells
    input_count: int
    parameter_count: int
    levels: list[int]
    one_way: bool
    lagging: list[int]
    settling: list[int]
    acting: list[Acting]


def equations_of(machine: Machine, tunable: Sequence[str]) -> Equations:
    """Return a machine's equations.

    Parameters
    ----------
    machine : Machine
    tunable : sequence of str
        Full names of the parameters that become symbols; all others have the machine's values.

    Raises
    ------
    NoFormulaError
        For an effect with a computation that has no formula.
    """
    graph = Graph()
    catalogue()  # Modules imported later would run plain numpy.
    plugins = plugged_modules()
    with tracing(graph, "plant_model", lambda name: name.startswith("plant_model.native"), plugins):
        values = SymbolicValues(machine, tunable, graph)
        try:
            effects = effects_in_force(machine, values)
            return _Tracer(machine, values, effects, graph, tunable).equations()
        except Exception as error:
            effect = _where(error)
            if effect is None and not isinstance(error, UntraceableError):
                raise
            what = f"effect {effect.key}" if effect else f"machine {machine.name}"
            why = str(error) or type(error).__name__
            raise NoFormulaError(f"{what}: no form in C: {why}") from error


def _where(error: Exception) -> Effect | None:
    """Return the effect whose hook raised an error, if one did."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    owners = [frame.f_locals.get("self") for frame in frames]
    return next((entry for entry in reversed(owners) if isinstance(entry, Effect)), None)


class _Tracer:
    def __init__(
        self,
        machine: Machine,
        values: SymbolicValues,
        effects: list[Effect],
        graph: Graph,
        tunable: Sequence[str],
    ) -> None:
        self.machine, self.effects, self.graph, self.tunable = machine, effects, graph, tunable
        self.network: Any = Network(machine, values, effects)
        self.nodes, self.states = self.network.node_count, self.network.state_count
        self.names = [entry.name for entry in machine.inputs]
        self.inputs: dict[str, Any] = {
            name: Traced(graph, np.array([graph.symbol("u", place)], dtype=object))
            for place, name in enumerate(self.names)
        }
        self.temperatures: Any = graph.symbols("T", (1, 1, self.nodes))
        self.own: Any = graph.symbols("x", (1, 1, self.states))

    def equations(self) -> Equations:
        network, slices = self.network, self.network.state_slices()
        outside = [self.inputs[name] for name in self.machine.boundary_index]
        boundary: Any = np.stack(outside, axis=-1)
        dependent, rates = network.dependent(self.inputs, boundary, self.temperatures, self.own)
        target, constants = self._lags(slices)
        at_end, states = self.temperatures[:, 0], self.own[:, 0]
        matrix, to_boundary = self._conductances()
        heat = _flat(network.heat(self.inputs))
        flows = zip(heat, _flat(dependent), strict=True)
        slopes = self._slopes([self._do("add", *pair) for pair in flows], matrix, to_boundary)
        return Equations(
            capacity=_flat(network.capacity),
            matrix=matrix,
            boundary=to_boundary,
            force=self._force(_flat(network.heat(self.inputs)), to_boundary),
            dependent=_flat(dependent),
            rates=_flat(rates),
            slopes=slopes + _flat(rates),
            node_scales=_flat(network.error_scale)[: self.nodes],
            decay=_flat(network.state_decay()),
            time_constants=constants,
            scales=_flat(network.error_scale)[self.nodes :],
            target=target,
            settled=_flat(network.settled(self.inputs, at_end, states)),
            first=_flat(network.start_states(at_end, self.inputs)),
            outputs=self._outputs(slices),
            input_count=len(self.names),
            parameter_count=len(self.tunable),
            levels=[self.names.index(name) for name in network.conductance_inputs],
            one_way=bool(network.one_way),
            lagging=self._of_kind(slices, "lags"),
            settling=self._of_kind(slices, "settles"),
            acting=[self._acting(effect, slices) for effect in self.effects],
        )

    def _conductances(self) -> tuple[dict[tuple[int, int], Any], dict[tuple[int, int], Any]]:
        given = dict.fromkeys(self.names, self.graph.constant([0.0]))
        given |= {name: self.inputs[name] for name in self.network.conductance_inputs}
        matrix, boundary = (part.cells[0] for part in self.network.conductances(given))
        nodes = range(self.nodes)
        entries = {(i, j): matrix[i, j] for i in nodes for j in nodes if j >= i}
        return (
            {place: g for place, g in entries.items() if place[0] == place[1] or not _is_nought(g)},
            {(i, j): g for (i, j), g in np.ndenumerate(boundary) if not _is_nought(g)},
        )

    def _do(self, op: str, *args: Any) -> Any:
        return self.graph.apply(op, *args)

    def _slopes(
        self, heat: Cells, matrix: Mapping[Place, Any], boundary: Mapping[Place, Any]
    ) -> Cells:
        """Return the rates of temperatures by a heat, the network and its surroundings."""
        temperatures = _flat(self.temperatures)
        outside = [self.inputs[name].cells[0] for name in self.machine.boundary_index]
        flows = [(i, self._do("multiply", g, outside[j])) for (i, j), g in boundary.items()]
        for (i, j), g in matrix.items():
            loss = self._do("negative", g)
            flows += [(i, self._do("multiply", loss, temperatures[j]))]
            flows += [(j, self._do("multiply", loss, temperatures[i]))] if i != j else []
        for node, flow in flows:
            heat[node] = self._do("add", heat[node], flow)
        capacities = _flat(self.network.capacity)
        return [self._do("divide", *pair) for pair in zip(heat, capacities, strict=True)]

    def _force(self, heat: Cells, boundary: Mapping[Place, Any]) -> Cells:
        outside = [self.inputs[name].cells[0] for name in self.machine.boundary_index]
        for place, (i, j) in enumerate(boundary):
            flow = self._do("multiply", self.graph.symbol("outside", place), outside[j])
            heat[i] = self._do("add", heat[i], flow)
        return heat

    def _lags(self, slices: dict[str, slice]) -> tuple[Cells, Cells]:
        target, constants = [0.0] * self.states, [float("inf")] * self.states
        for effect in self.effects:
            if effect.lags:
                part = slices[effect.key]
                target[part] = _flat(effect.target(self.inputs, self.temperatures))
                constants[part] = _flat(effect.time_constants())
        return target, constants

    def _outputs(self, slices: dict[str, slice]) -> Cells:
        start: Any = self.graph.symbols("s", (1, 1, self.nodes))
        instant: Any = self.graph.symbols("w", (2, 1))
        time, length = instant
        at = pose(self.effects, slices, self.inputs, self.temperatures - start, self.own)
        shown = readings(
            self.machine,
            self.effects,
            slices,
            self.inputs,
            time,
            self.temperatures,
            self.own,
            at,
        )
        drift = drift_at(at, length)
        return [cell for part in (*shown.values(), drift) for cell in _flat(part)]

    def _of_kind(self, slices: dict[str, slice], kind: str) -> list[int]:
        wanted = [slices[effect.key] for effect in self.effects if getattr(effect, kind)]
        return [place for part in wanted for place in range(part.start, part.stop)]

    def _acting(self, effect: Effect, slices: dict[str, slice]) -> Acting:
        name = f"effects.{effect.key}.{effect.amplitude}"
        place = self.tunable.index(name) if name in self.tunable else None
        follows = effect.lags or effect.settles or not effect.states
        part = slices.get(effect.key, slice(0, 0))
        return Acting(
            effect.key,
            place,
            effect.off,
            effect.temperature_dependent or not follows,
            range(part.start, part.stop),
        )


def _flat(part: Any) -> Cells:
    return list(part.cells.flat) if isinstance(part, Traced) else np.asarray(part).ravel().tolist()


def _is_nought(cell: Any) -> bool:
    return not isinstance(cell, Expr) and float(cell) == 0.0


__all__ = ["Equations", "NoFormulaError", "equations_of"]
