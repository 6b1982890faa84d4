"""The plant as an FMU."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from typing import Any

from fmu_packaging.slave import DriftSlave, FmuError
from fmu_packaging.variables import LONGEST_TOOL_MM, START_DEGC, USUAL_TOOL_MM, Variable
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import Input, Machine
from plant_model.noise import LARGEST_SEED
from plant_model.parameters import Parameter, ParameterError
from plant_model.stepper import AXES, OFFSETS, PlantStepper

MACHINE_FILE = "machine.json"
"""The machine, in the FMU's resources."""


class PlantSlave(DriftSlave):
    """Takes speed, boundary temperatures, tool length and offsets; gives readings, drift, error."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._names = [self.variables[ref].name for ref in self.inputs]
        self._is_offset = [name in OFFSETS for name in self._names]

    def declare(self) -> Sequence[Variable]:
        """Return the variables that the machine needs."""
        self._machine = Machine.from_dict(json.loads(self.resource(MACHINE_FILE)))
        self._numbers = {
            variable_name(name): name
            for name, parameter in self._machine.parameters.items()
            if parameter.calibrate
        }
        return variables(self._machine)

    def prepare(self) -> None:
        """Build the machine from the parameters in force.

        Raises
        ------
        FmuError
            For a parameter outside its range.
        """
        self._stepper = self._made()
        self._outputs = [self.refs[name] for name in self._stepper.outputs()]

    def begin(self) -> None:
        """Start each node at its boundary input, or its sensor's rise above the first boundary.

        Raises
        ------
        FmuError
            For an input outside its range.
        """
        self._look()
        inputs = dict(zip(self._names, self.inputs.values(), strict=True))
        first = inputs[next(iter(self._machine.boundary_index))]
        readings = {
            name: first + float(self.parameters[rise_name(name)])
            for name in start_sensors(self._machine)
        }
        self._stepper.reset(inputs, readings)
        self._publish()

    def _made(self) -> PlantStepper:
        """Return the machine with the parameters in force."""
        self._made_of = dict(self.parameters)
        moved = {
            name: float(self.parameters[variable])
            for variable, name in self._numbers.items()
            if self.parameters[variable] != self._machine.parameters[name].value
        }
        try:
            seed = int(self.parameters["noise_seed"])
            return PlantStepper(self._machine, moved or None, seed or None)
        except ParameterError as error:
            raise FmuError(str(error)) from None

    def _retune(self) -> None:
        """Continue with the parameters that have been set since the last step."""
        for name, value in self.parameters.items():
            refusal = self.variables[self.refs[name]].refusal(value)
            if refusal:
                raise FmuError(refusal)
        state = self._stepper.state()
        self._stepper = self._made()
        self._stepper.restore(state)

    def advance(self, time_s: float, step_s: float) -> None:
        """Step the machine with inputs held."""
        self._look()
        if self.parameters != self._made_of:
            self._retune()
        inputs = dict(zip(self._names, self.inputs.values(), strict=True))
        self._stepper.step(step_s, inputs)
        self._publish()

    def _look(self) -> None:
        """Refuse an input that is not finite or outside its range.

        Offsets beyond the limit are accepted: the control limits them.
        """
        for (ref, value), offset in zip(self.inputs.items(), self._is_offset, strict=True):
            refusal = self.variables[ref].refusal(value)
            if refusal and not (offset and math.isfinite(value)):
                raise FmuError(refusal)

    def _publish(self) -> None:
        self.outputs.update(zip(self._outputs, self._stepper.outputs().values(), strict=True))

    def hidden(self) -> dict[str, Any]:
        """Return the state: temperatures, axes, noise generator."""
        return self._stepper.state()

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from `hidden`."""
        self._stepper.restore(state)


def variable_name(parameter: str) -> str:
    """Return a machine parameter's name in an FMU.

    Parameters
    ----------
    parameter : str

    >>> variable_name("links.rotor-stator.conductance")
    "links.'rotor-stator'.conductance"
    """
    parts = parameter.split(".")
    return ".".join(part if re.fullmatch(r"[A-Za-z_]\w*", part) else f"'{part}'" for part in parts)


def start_sensors(machine: Machine) -> list[str]:
    """Return the sensors whose first readings nodes start at, in the nodes' order.

    Parameters
    ----------
    machine : Machine
    """
    starts = dict.fromkeys(node.start for node in machine.nodes if not node.rests)
    return [name for name in starts if name not in machine.boundary_index]


def rise_name(sensor: str) -> str:
    """Return the parameter that says how far above the first boundary a sensor's nodes start.

    Parameters
    ----------
    sensor : str
    """
    return f"start_rise.{sensor}"


def variables(machine: Machine) -> list[Variable]:
    """Return the FMU's variables for a machine: inputs, readings, drift and error, parameters."""
    limit = machine.axis.limit_um
    declared = [_input(entry) for entry in machine.inputs]
    declared.append(
        Variable(
            "tool_length",
            "real",
            "input",
            "From the gauge line to the tool tip",
            unit="mm",
            low=0.0,
            high=LONGEST_TOOL_MM,
            nominal=USUAL_TOOL_MM,
            start=USUAL_TOOL_MM,
        )
    )
    declared += [
        Variable(
            f"d{axis}",
            "real",
            "input",
            f"Offset received for the {axis} axis; the control moves to it within its limits",
            unit="um",
            low=-limit,
            high=limit,
            nominal=10.0,
        )
        for axis in AXES
    ]
    at_start = PlantStepper(machine).outputs()
    temperatures = {sensor.name: sensor for sensor in machine.sensors if sensor.unit == "degC"}
    for name in at_start:
        if name in temperatures:
            text = f"Reading of the thermometer {name} on {temperatures[name].of}"
            declared.append(_reading(name, text, "degC"))
        elif name.partition("_")[0] in TEXTS:
            kind, _, axis = name.partition("_")
            declared.append(_reading(name, TEXTS[kind].format(axis=axis), "um"))
        else:
            text = (
                f"Reading of the displacement sensor {name}: the spindle's drift, without offsets"
            )
            declared.append(_reading(name, text, "um"))
    declared.append(
        Variable(
            "noise_seed",
            "integer",
            "parameter",
            "Seed of the sensors' noise; the same seed gives the same noise; 0: no noise",
            low=0,
            high=LARGEST_SEED,
        )
    )
    boundary = next(iter(machine.boundary_index))
    free = tunable(machine)
    declared += [
        Variable(
            rise_name(sensor),
            "real",
            "parameter",
            f"Initial rise above {boundary} of the nodes that start at the reading of {sensor}",
            unit="K",
            low=-200.0,
            high=200.0,
            nominal=1.0,
        )
        for sensor in start_sensors(machine)
    ]
    declared += [
        _parameter(variable_name(name), name, parameter, tunable=name in free)
        for name, parameter in machine.parameters.items()
        if parameter.calibrate
    ]
    return declared


TEXTS = {
    "drift": "Drift of the tool tip in {axis}, without offsets",
    "offset": "Offset in force on the {axis} axis",
    "error": "Remaining error at the tool tip in {axis}: drift plus offset in force",
}


def _input(entry: Input) -> Variable:
    usual = START_DEGC if entry.is_boundary else 0.0
    start = usual if entry.default is None else entry.default
    return Variable(
        entry.name,
        "real",
        "input",
        f"{entry.name.replace('_', ' ').capitalize()}; {entry.column} in run files",
        unit=entry.unit,
        low=entry.low,
        high=entry.high,
        nominal=entry.most / 2 or 1.0,
        start=min(max(start, entry.low), entry.high),
    )


def _reading(name: str, text: str, unit: str) -> Variable:
    low, high = (-60.0, 400.0) if unit == "degC" else (-1e5, 1e5)
    return Variable(
        name,
        "real",
        "output",
        text,
        unit=unit,
        low=low,
        high=high,
        nominal=20.0 if unit == "degC" else 10.0,
        # The control starts at zero whatever it receives; other outputs may depend on any input.
        depends_at_start=() if name.startswith("offset_") else None,
    )


TUNABLE_FAMILIES = ("links", "sources", "effects")
FAMILIES = {
    "numbers": "{words}, a number of the machine's page",
    "nodes": "{words} of the lump {item}",
    "links": "{words} of the heat path {item}",
    "sources": "{words} of the heat source {item}",
    "structure": "{words} of the part {item} of the structure",
    "effects": "{words} of the effect {item}",
}


def tunable(machine: Machine) -> set[str]:
    """Return the parameters that may change during a run because they wear, age or are set.

    These are heat paths, heat sources and effects. Capacities, lengths and expansions are fixed,
    and so are the parameters of effects with own states, because own states cannot come and go.

    Parameters
    ----------
    machine : Machine
    """
    moves, stays = set[str](), set[str]()
    for name, parameter in machine.parameters.items():
        family, key, *_ = name.split(".")
        if family == "numbers":
            continue  # it moves the parameters tied to it
        own_states = family == "effects" and catalogue()[name_of(key)].states
        group = moves if family in TUNABLE_FAMILIES and not own_states else stays
        group.add(parameter.tied or name)
    return moves - stays


def _parameter(variable: str, name: str, parameter: Parameter, *, tunable: bool) -> Variable:
    family, *item, number = name.split(".")
    words = number.replace("_", " ").capitalize()
    return Variable(
        variable,
        "real",
        "parameter",
        FAMILIES[family].format(words=words, item=".".join(item)),
        variability="tunable" if tunable else "fixed",
        unit=parameter.unit,
        low=parameter.low,
        high=parameter.high,
        nominal=abs(parameter.value) or None,
        start=parameter.value,
    )
