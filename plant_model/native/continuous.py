"""States of a machine and their derivatives as FMU variables, for model exchange."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from fmu_packaging.variables import Variable
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.fmi_slave import variable_name, variables
from plant_model.machine import Machine
from plant_model.native.derive import backward, forward
from plant_model.native.equations import Equations
from plant_model.native.trace import Expr
from plant_model.parameters import ROOM_DEGC
from plant_model.stepper import AXES

TIME, TOOL_LENGTH = "time", "tool_length"


def is_continuous(equations: Equations) -> bool:
    """Return whether a solver can integrate all states, because none jumps at the end of a step."""
    return not equations.settling


def nominals(equations: Equations) -> list[float]:
    """Return a typical magnitude of each state: temperatures, then own states."""
    return [ROOM_DEGC] * len(equations.capacity) + [
        ROOM_DEGC * float(scale) for scale in equations.scales
    ]


def derivatives_of(equations: Equations) -> dict[str, list[Any]]:
    """Return the derivatives of rates and outputs by the knowns, forward and backward.

    The knowns are, in order, the inputs, the tool's length, the offsets (on which nothing depends
    directly), the states and the parameters.
    """
    cells = [*equations.slopes, *shown(equations)]
    inputs, nodes = equations.input_count, len(equations.capacity)
    given = inputs + 1 + len(AXES)
    knowns = {("u", place): place for place in range(inputs)} | {("w", 1): inputs}
    knowns |= {("T", place): given + place for place in range(nodes)}
    knowns |= {("x", place): given + nodes + place for place in range(len(equations.scales))}
    parameters = given + nodes + len(equations.scales)
    knowns |= {("p", place): parameters + place for place in range(equations.parameter_count)}
    return {"forward": forward(cells, knowns), "backward": backward(cells, knowns)}


def note_on_exchange(equations: Equations) -> str:
    """Return a sentence on model exchange for the FMU's user."""
    if is_continuous(equations):
        return f"Also for model exchange, with {len(equations.slopes)} states."
    jumping = [e.key for e in equations.acting if not set(e.states).isdisjoint(equations.settling)]
    return (
        f"Not for model exchange: {', '.join(jumping)} {'switch' if jumping[1:] else 'switches'} "
        "at the end of a step."
    )


def continuous_variables(
    machine: Machine, equations: Equations, tunable: Sequence[str]
) -> dict[str, Variable]:
    """Return the variables that model exchange adds to an FMU, by name.

    These are states and derivatives; outputs and derivatives state what they depend on.

    Parameters
    ----------
    machine : Machine
    equations : Equations
        The machine's; all states must be continuous.
    tunable : sequence of str
        The parameters that are symbols in the equations.
    """
    states = _states(machine, equations)
    names = {("T", place): state.name for place, state in enumerate(states[: len(machine.nodes)])}
    names |= {("x", place): state.name for place, state in enumerate(states[len(machine.nodes) :])}
    names |= {("u", place): entry.name for place, entry in enumerate(machine.inputs)}
    names |= {("w", 0): TIME, ("w", 1): TOOL_LENGTH}
    names |= {("p", place): variable_name(name) for place, name in enumerate(tunable)}

    def known(cell: Any) -> tuple[str, ...]:
        return tuple(sorted({names[symbol] for symbol in symbols_of(cell) if symbol in names}))

    derivatives = [
        Variable(
            f"der({state.name})",
            "real",
            "local",
            f"Rate of change: {state.description[0].lower()}{state.description[1:]}",
            unit="K/s" if state.unit == "degC" else "",
            derivative_of=state.name,
            depends=known(slope),
        )
        for state, slope in zip(states, equations.slopes, strict=True)
    ]
    outputs = [variable for variable in variables(machine) if variable.is_output]
    outputs = [
        replace(variable, depends=known(cell))
        for variable, cell in zip(outputs, shown(equations), strict=True)
    ]
    return {variable.name: variable for variable in (*outputs, *states, *derivatives)}


def _states(machine: Machine, equations: Equations) -> list[Variable]:
    texts = [
        (f"nodes.{node.name}.temperature", f"Temperature of the lump {node.name}", "degC")
        for node in machine.nodes
    ]
    for effect in equations.acting:
        names = catalogue()[name_of(effect.key)].states
        texts += [
            (f"effects.{effect.key}.{name}", f"Own state {name} of the effect {effect.key}", "")
            for name in names
        ]
    return [
        Variable(variable_name(name), "real", "local", text, unit=unit, nominal=nominal)
        for (name, text, unit), nominal in zip(texts, nominals(equations), strict=True)
    ]


def shown(equations: Equations) -> list[Any]:
    """Return the direct expression of each output; offsets move only at the end of a step."""
    sensors, drift = equations.outputs[:-3], equations.outputs[-3:]
    return [*sensors, *(cell for axis in drift for cell in (axis, 0.0, axis))]


def symbols_of(cell: Any) -> set[tuple[str, int]]:
    """Return the symbols that a cell depends on, each as row and place."""
    waiting = [cell]
    seen, symbols = set[Expr](), set[tuple[str, int]]()
    while waiting:
        now = waiting.pop()
        if not isinstance(now, Expr) or now in seen:
            continue
        seen.add(now)
        if now.op == "symbol":
            symbols.add(now.args)
        else:
            waiting += now.args
    return symbols
