"""Checks of a machine before any run: what it does at full speed, and what looks wrong."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.csgraph import breadth_first_order

from measurement.iso230 import RUNNING_S
from measurement.resampling import FINEST_K
from plant_model.drawing.class_values import CLASS_VALUES
from plant_model.drawing.known import CLASS
from plant_model.idle import still_axes, unused_inputs
from plant_model.machine import Item, Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Parameter, Values
from plant_model.simulate import Simulation, simulate
from plant_model.warm_up import warm_up

CELL = re.compile(r"^(shaft|housing)_\d+(_(xp|yp|xm|ym|a[\d_]+))?$")

HOT, WARM_BEARING = 120.0, 90.0
"""Highest plausible temperatures of a spindle part and of a bearing [degC]: set on no data."""

SLOWEST_H = 30.0
"""Longest plausible time constant of a machine tool's part [h]: set on no data."""

MOST_DRIFT, LEAST_DRIFT = 500.0, 1.0
"""Plausible range of the nose's drift at full speed [um]: set on no data."""

TURNING = ("inner", "rotor")

USUAL = {
    ("convection", "coefficient"): (2.0, 200.0),
    ("bearing", "f0"): (0.1, 12.0),
    ("bearing", "f1"): (0.0001, 0.005),
    ("bearing", "viscosity"): (3.0, 200.0),
    ("bearing", "preload"): (20.0, 10000.0),
    ("coolant_flow", "flow"): (0.2, 60.0),
    ("coolant_flow", "heat_capacity"): (1400.0, 4300.0),
    ("coolant_wall", "conductance"): (0.01, 2000.0),
    ("contact", "conductance"): (0.001, 3000.0),
    ("conduction", "conductance"): (0.001, 5000.0),
    ("motor", "loss"): (0.5, 500.0),
    ("feed_axis", "loss"): (0.5, 300.0),
}
"""Usual range of an item's number, in its unit; engineering judgement."""


@dataclass(frozen=True)
class Part:
    """Nodes that belong together, and what they do at full speed.

    Attributes
    ----------
    name : str
    nodes : int
    capacity : float
        [J/K].
    conductance : float
        To everything else [W/K].
    hours : float
        Time constant, capacity over conductance [h].
    warm : float
        Temperature of the warmest node at the end of running [degC].
    heat : float
        Generated in it at full speed [W].
    seen : str
        ``read`` by a thermometer, ``beside`` such a part, or ``unseen``.
    """

    name: str
    nodes: int
    capacity: float
    conductance: float
    hours: float
    warm: float
    heat: float
    seen: str


@dataclass(frozen=True)
class MachineFacts:
    """Results of the checks.

    Attributes
    ----------
    parts : tuple of Part
    links : dict of (str, str) to float
        Conductance between parts, and from parts to boundary temperatures [W/K].
    modes : tuple of (hours, part)
        The longest time constants of the machine at full speed, and where each is strongest.
    sources : dict of str to float
        Heat at full speed [W].
    given_off : dict of str to float
        Heat given to each boundary, and to coolant from jacket to jacket, at the end of running
        [W].
    stored : float
        Heat that still warms the parts then [W].
    readings : dict of str to (float, str)
        Every sensor at the end of running, with its unit.
    drift : tuple of float
        Of the nose then: X, Y, Z [um].
    wrong : tuple of str
        A sentence for each thing that looks wrong.
    shown : Simulation
    at : int
        Row of the simulation at the end of running.
    """

    parts: tuple[Part, ...]
    links: dict[tuple[str, str], float]
    modes: tuple[tuple[float, str], ...]
    sources: dict[str, float]
    given_off: dict[str, float]
    stored: float
    readings: dict[str, tuple[float, str]]
    drift: tuple[float, float, float]
    wrong: tuple[str, ...]
    shown: Simulation
    at: int


def part_of(node: str) -> str:
    """Return the part that a node belongs to: a cell of the shaft belongs to the shaft.

    Parameters
    ----------
    node : str
        A node's name; a node that is not a cell is its own part.
    """
    cell = CELL.match(node)
    return cell[1] if cell else node


def _network_of(machine: Machine) -> Network:
    values = Values(machine.parameters)
    return Network(machine, values, effects_in_force(machine, values))


class _Look:
    """A machine at the end of the warm-up."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        inputs = self.warm_up = warm_up(machine)
        self.shown = simulate(machine, inputs, step_s=60.0)
        self.at = int((inputs["time_s"] <= RUNNING_S).sum()) - 1
        self.warm: FloatArray = self.shown.temperatures[0, self.at]
        self.names = [node.name for node in machine.nodes]
        self.inputs = {
            name: values[self.at : self.at + 1] for name, values in self.shown.inputs.items()
        }
        self.network = _network_of(machine)
        self.matrix, self.boundary = (part[0] for part in self.network.conductances(self.inputs))
        # Coolant in series brings heat, and takes none back.
        self.carried = 0.0
        for entry in self.network.one_way:
            g = float(entry.conductance[0, 0])
            self.matrix[entry.node, entry.other] -= g
            self.carried += g * float(self.warm[entry.node] - self.warm[entry.other])
        self.heat = self.heat_in(self.network)
        # Without sources, heat that depends on temperature is exchanged and not generated.
        others = tuple(item for item in machine.items if item.family != "sources")
        self.made = self.heat - self.dependent_in(_network_of(replace(machine, items=others)))
        groups: dict[str, list[int]] = defaultdict(list)
        for i, name in enumerate(self.names):
            groups[part_of(name)].append(i)
        self.groups = dict(groups)
        # In a fixed order, so that sums are reproducible.
        self.read = [
            name for name in self.groups if name in {part_of(s.of) for s in machine.sensors}
        ]

    def heat_in(self, network: Network) -> FloatArray:
        """Return the heat of sources and effects in a network's nodes now [W], (nodes,)."""
        return np.asarray(network.heat(self.inputs)[0, 0] + self.dependent_in(network))

    def dependent_in(self, network: Network) -> FloatArray:
        """Return the part of that heat that depends on temperature [W], (nodes,)."""
        now = slice(self.at, self.at + 1)
        warm, states = self.shown.temperatures[:, now], self.shown.states[:, now]
        outside = np.stack([self.inputs[name] for name in network.machine.boundary_index], axis=-1)
        heat = network.dependent(self.inputs, outside, warm, states)[0]
        for entry in network.one_way:
            heat[..., entry.node] -= entry.conductance * warm[..., entry.other]
        return np.asarray(heat[0, 0])

    @property
    def capacity(self) -> FloatArray:
        """[J/K], (nodes,)."""
        return np.asarray(self.network.capacity[0])

    def of_bearing(self, item: Item) -> float:
        """Return the temperature of a bearing's inner ring [degC]."""
        return float(self.warm[self.machine.node_index[item.refs["inner"][0]]])


def bearing_temperatures(machine: Machine) -> dict[str, float]:
    """Return each bearing's inner ring temperature at the end of running at full speed [degC].

    Parameters
    ----------
    machine : Machine
    """
    look = _Look(machine)
    return {item.name: look.of_bearing(item) for item in machine.of_kind("sources", "bearing")}


def check_sheet(machine: Machine) -> MachineFacts:
    """Return what a machine does at full speed and what looks wrong in it.

    Parameters
    ----------
    machine : Machine
        From a page or in lumps.
    """
    look = _Look(machine)
    parts = tuple(_part(look, name, which) for name, which in look.groups.items())
    boundary = np.array([look.inputs[name][0] for name in machine.boundary_index])
    flows = look.boundary * (look.warm[:, None] - boundary)
    given = dict(zip(machine.boundary_index, flows.sum(axis=0).tolist(), strict=True))
    if carried := round(look.carried, 6):
        given["coolant in series"] = carried
    before, after = look.shown.temperatures[0, look.at - 1 : look.at + 1]
    seconds = float(look.shown.time_s[look.at] - look.shown.time_s[look.at - 1])
    stored = float(np.sum(look.capacity * (after - before)) / seconds)
    # Rounded, so that terms that cancel show as zero and not as minus zero.
    x, y, z = (round(float(v), 6) + 0.0 for v in look.shown.drift(0.0)[0, look.at])
    thermometers = {sensor.name for sensor in machine.sensors}
    readings = {
        name: (float(values[0, look.at]), "degC" if name in thermometers else "um")
        for name, values in look.shown.readings.items()
    }
    return MachineFacts(
        parts,
        _paths(look),
        _modes(look),
        _sources(look),
        given,
        stored,
        readings,
        (x, y, z),
        tuple(_wrong(look, parts, (x, y, z))),
        look.shown,
        look.at,
    )


def _part(look: _Look, name: str, which: list[int]) -> Part:
    inside = look.matrix[np.ix_(which, which)].sum()
    capacity = float(look.capacity[which].sum())
    conductance = float(inside)
    beside = [node for part in look.read for node in look.groups[part]]
    seen = "beside" if look.matrix[np.ix_(which, beside)].any() else "unseen"
    seen = "read" if name in look.read else seen
    hours = capacity / conductance / 3600.0 if conductance > 1e-9 else np.inf
    return Part(
        name,
        len(which),
        capacity,
        conductance,
        float(hours),
        float(look.warm[which].max()),
        float(look.made[which].sum()),
        seen,
    )


def _paths(look: _Look) -> dict[tuple[str, str], float]:
    """Return the conductance between parts, and from parts to boundary temperatures [W/K]."""
    names = [part_of(name) for name in look.names]
    conductances: dict[tuple[str, str], float] = defaultdict(float)
    for i, name in enumerate(names):
        for j in range(i):
            g = -float(min(look.matrix[i, j], look.matrix[j, i]))
            if names[j] != name and g != 0.0:
                pair = (name, names[j]) if name < names[j] else (names[j], name)
                conductances[pair] += g
        for k, outside in enumerate(look.machine.boundary_index):
            if look.boundary[i, k] != 0.0:
                conductances[name, outside] += float(look.boundary[i, k])
    return dict(conductances)


def _modes(look: _Look) -> tuple[tuple[float, str], ...]:
    """Return the longest time constants of the linear part and where they are strongest."""
    root = np.sqrt(look.capacity)
    rates, shapes = np.linalg.eig(look.matrix / np.outer(root, root))
    order = np.argsort(rates.real)[:4]
    slowest = []
    for k in order:
        where = part_of(look.names[int(np.argmax(np.abs(shapes[:, k].real)))])
        rate = float(rates[k].real)
        slowest.append((1.0 / rate / 3600.0 if rate > 1e-12 else float("inf"), where))
    return tuple(slowest)


def _sources(look: _Look) -> dict[str, float]:
    """Return the heat at full speed of each source, and of other effects [W]."""
    machine = look.machine
    heats = {}
    for item in machine.items:
        if item.family != "sources":
            continue
        without = replace(machine, items=tuple(o for o in machine.items if o is not item))
        heats[item.name] = float(look.heat.sum() - look.heat_in(_network_of(without)).sum())
    left = round(float(look.heat.sum()) - sum(heats.values()), 6)
    return heats | ({"other effects": left} if left else {})


def _wrong(look: _Look, parts: tuple[Part, ...], drift: tuple[float, float, float]) -> list[str]:
    """Return a sentence for each thing that looks wrong."""
    return [
        *_lost(look),
        *_slow_or_hot(look, parts),
        *_bearings(look),
        *_numbers(look.machine),
        *_unseen(look, parts),
        *_far(drift),
        *unused_inputs(look.machine),
        *still_axes(look.machine, look.shown, look.warm_up),
    ]


def _lost(look: _Look) -> list[str]:
    """Return a sentence for each part that exchanges no heat, or cannot give it off."""
    machine = look.machine
    links = [item for item in machine.items if item.family == "links"]
    touched = {name for item in links for names in item.refs.values() for name in names}
    lines = [
        f"{name} exchanges heat with nothing: a link is missing."
        for name in look.names
        if name not in touched
    ]
    # All boundaries share one index after the nodes.
    outside, index = len(look.names), machine.node_index
    pairs = [[index.get(name, outside) for name in item.refs["between"]] for item in links]
    joined = np.zeros((outside + 1, outside + 1))
    joined[tuple(np.array(pairs, dtype=int).reshape(-1, 2).T)] = 1.0
    reached = breadth_first_order(joined, outside, directed=False, return_predecessors=False)
    away = {look.names[i] for i in set(range(outside)) - set(reached.tolist())}
    lost = {part_of(name) for name in away & touched}
    lines += [f"Heat in {name} never reaches air or coolant." for name in sorted(lost)]
    return lines


def _slow_or_hot(look: _Look, parts: tuple[Part, ...]) -> list[str]:
    lines = []
    hot = sorted((part for part in parts if part.warm > HOT), key=lambda part: -part.warm)
    if hot:
        which = ", ".join(f"{part.name} reaches {part.warm:.0f}" for part in hot[:3])
        more = " (others are hot, too)" if len(hot) > 3 else ""
        lines.append(
            f"{which} degC at full speed{more}: a joint, a surface or cooling may be missing, or a"
            " heat source is too strong."
        )
    for part in parts:
        if SLOWEST_H < part.hours < np.inf:
            lines.append(
                f"{part.name} takes {part.hours:.0f} h to follow its surroundings: its mass may be"
                " ten times too large, or a joint or surface is missing."
            )
        cold = look.shown.temperatures[0, 0, look.groups[part.name]].max()
        if part.heat > 1.0 and part.warm < cold + FINEST_K:
            lines.append(f"{part.name} takes up {part.heat:.0f} W and hardly warms.")
    return lines


def _bearings(look: _Look) -> list[str]:
    lines = []
    for item in look.machine.of_kind("sources", "bearing"):
        warm = look.of_bearing(item)
        holds = item.parameters["viscosity_at"]
        if warm > WARM_BEARING:
            lines.append(
                f"The bearing {item.name} runs at {warm:.0f} degC at full speed: if it does not,"
                " give its f0, lubrication (oil-air makes less friction than grease) and grade, or"
                " a jacket that cools it; or the highest speed is more than it ever runs."
            )
        # A temperature given by the owner holds for the machine at work, not at full speed.
        usual = CLASS_VALUES["running_temperature"]
        if holds.source.startswith(CLASS) and not usual.low <= warm <= usual.high:
            lines.append(
                f"The bearing {item.name} runs at {warm:.0f} degC at full speed, but its viscosity"
                f" is the class's, for {holds.value:.0f} degC: give the running_temperature that"
                " it has most of the time."
            )
    return lines


def _numbers(machine: Machine) -> list[str]:
    """Return a sentence for each number far outside the usual range, without repeats."""
    texts: dict[tuple[str, str], list[str]] = defaultdict(list)
    for item in machine.items:
        for name, parameter in item.parameters.items():
            usual = USUAL.get((item.kind, name))
            if usual and not usual[0] <= parameter.value <= usual[1]:
                texts[item.kind, name].append(_said(item, name, parameter))
    return [
        f"{', '.join(items[:3])}{' and more' if len(items) > 3 else ''}: the {name} of a {kind}"
        f" is usually {USUAL[kind, name][0]:g} to {USUAL[kind, name][1]:g}."
        for (kind, name), items in texts.items()
    ]


def _said(item: Item, name: str, parameter: Parameter) -> str:
    return f"{item.parameter_name(name)} = {parameter.value:.3g} {parameter.unit}"


def _unseen(look: _Look, parts: tuple[Part, ...]) -> list[str]:
    """Return heated parts without a thermometer, except rotating parts, which cannot have one."""
    sources = [item for item in look.machine.items if item.family == "sources"]
    turning = {name for item in sources for role in TURNING for name in item.refs.get(role, ())}
    names = [
        part.name
        for part in parts
        if part.seen == "unseen" and part.heat > 1.0 and part.name not in turning
    ]
    if not names:
        return []
    return [
        f"No thermometer is on or beside {', '.join(names)}, where heat is generated: runs say"
        " little about the numbers there."
    ]


def _far(drift: tuple[float, float, float]) -> list[str]:
    most = max(abs(part) for part in drift)
    if most > MOST_DRIFT:
        return [f"The nose drifts by {most:.0f} um at full speed, more than spindles do."]
    if most < LEAST_DRIFT:
        return [f"The nose drifts by {most:.2g} um at full speed: is the structure there?"]
    return []
