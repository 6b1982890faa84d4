"""C sources of one machine, from its machine file and the effects in Python."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fmu_packaging.variables import Variable
from plant_model.axis import MOST_ALLOWANCE
from plant_model.fmi_slave import start_sensors
from plant_model.integrate import MOST_PARTS, ROUNDING, TOLERANCE
from plant_model.machine import Machine
from plant_model.native.continuous import derivatives_of, is_continuous, nominals
from plant_model.native.emit import Stage, function, stage_function
from plant_model.native.equations import Equations, equations_of
from plant_model.native.product import Product
from plant_model.native.trace import Expr, literal
from plant_model.rest import RestingParts
from plant_model.sensors import noise_and_resolution
from plant_model.stepper import OFFSETS

C_FOLDER = Path(__file__).resolve().parent / "c"
LARGEST = sys.float_info.max
NOISE_SEED = "noise_seed"
HEAD = "/* Made by spindle-drift from the machine {name}; not to be edited. */\n"


def program() -> dict[str, str]:
    """Return the sources common to all plants, by path in the folder of sources."""
    paths = sorted([*C_FOLDER.glob("*.c"), *C_FOLDER.glob("*.h")])
    return {path.name: path.read_text("utf-8") for path in paths}


def tunable_of(machine: Machine) -> list[str]:
    """Return the full names of the parameters that an FMU's user may set."""
    return [name for name, entry in machine.parameters.items() if entry.calibrate]


def machine_sources(machine: Machine, equations: Equations | None = None) -> dict[str, str]:
    """Return the sources of one machine, by path in the folder of sources.

    Parameters
    ----------
    machine : Machine
    equations : Equations, optional
        The machine's, with its tunable parameters as symbols, if already known.

    Raises
    ------
    NoFormulaError
        For an effect without a C form.
    """
    tunable = tunable_of(machine)
    equations = equations or equations_of(machine, tunable)
    edges = (place for place in equations.matrix if place[0] != place[1])
    product = Product(len(machine.nodes), edges)
    files, of_parameters, of_inputs = _functions(equations, product)
    sizes = {
        "NODES": len(machine.nodes),
        "STATES": len(equations.scales),
        "INPUTS": len(machine.inputs),
        "BOUNDARIES": len(machine.boundary_index),
        "ENTRIES": len(product.entries),
        "OUTSIDE": len(equations.boundary),
        "LEVELS": len(equations.levels),
        "ACTING": len(equations.acting),
        "TUNABLE": len(tunable),
        "RISES": len(start_sensors(machine)),
        "RESTING": sum(node.rests for node in machine.nodes),
        "SENSORS": len(noise_and_resolution(machine)),
        "KEPT_OF_PARAMETERS": of_parameters,
        "KEPT_OF_INPUTS": of_inputs,
        "CONTINUOUS": int(is_continuous(equations)),
        "TOLERANCE": TOLERANCE,
        "ROUNDING": ROUNDING,
        "MOST_PARTS": MOST_PARTS,
        "MOST_ALLOWANCE": MOST_ALLOWANCE,
    }
    head = HEAD.format(name=machine.name)
    includes = '#include "machine_data.h"\n#include "formulas.h"\n'
    defines = "\n".join(f"#define {name} {size}" for name, size in sizes.items())
    guard = "MACHINE_SIZES_H"
    return {
        "machine_sizes.h": f"{head}#ifndef {guard}\n#define {guard}\n\n{defines}\n\n#endif\n",
        "machine_data.c": "\n".join(
            [head, '#include "machine_data.h"\n', *_tables(machine, equations), ""]
        ),
        **{name: "\n".join([head, includes, *functions]) for name, functions in files.items()},
    }


def _functions(equations: Equations, product: Product) -> tuple[dict[str, list[str]], int, int]:
    """Return the C functions by file, and the number of values that each stage keeps."""
    of_parameters = Stage("k", {"p"})
    of_inputs = Stage("h", {"p", "u"})
    first, both = [of_parameters], [of_parameters, of_inputs]
    k, now = "const double *k", "const double *k, const double *u"
    rows = f"{now}, const double *T, const double *x"
    shown = f"{rows}, const double *s, const double *w"
    names = ("capacity", "decay", "time_constants")
    matrix = equations.matrix
    parts = {
        "diagonal": [matrix[i, i] for i in range(len(equations.capacity))],
        "entries": [
            0.0 if place is None else matrix[min(place), max(place)] for place in product.entries
        ],
        "outside": list(equations.boundary.values()),
    }
    places = _places(parts.items())
    still = [(place, _still(cell)) for place, cell in places]
    moving = [(place, cell) for place, cell in places if _moves(cell)]
    of_matrix = "double *diagonal, double *entries, double *outside"
    fixed = _places((name, getattr(equations, name)) for name in names)
    dependent = _places([("heat", equations.dependent), ("rates", equations.rates)])
    force = _places([("force", equations.force)])
    made = [
        function(f"void equations_fixed({k}, double *{', double *'.join(names)})", fixed, first),
        function(f"void equations_still({k}, {of_matrix})", still, first),
        function(f"void equations_moving({now}, {of_matrix})", moving, first),
        function(
            f"void equations_force({now}, const double *h, const double *outside, double *force)",
            force,
            both,
        ),
        function(
            f"void equations_dependent({now}, const double *h, "
            "const double *T, const double *x, double *heat, double *rates)",
            dependent,
            both,
        ),
    ]
    for name, given in (
        ("target", f"{now}, const double *T"),
        ("settled", rows),
        ("first", f"{now}, const double *T"),
        ("outputs", shown),
    ):
        cells = _places([(name, getattr(equations, name))])
        made.append(function(f"void equations_{name}({given}, double *{name})", cells, first))
    files = {"equations.c": made}
    # The largest functions, which no controller needs, each compiled beside the others.
    for name, expressions in derivatives_of(equations).items():
        head = f"void equations_{name}({shown}, const double *d, double *found)"
        body = function(head, _places([("found", expressions)]), first)
        files[f"{name}.c"] = ["#ifndef NO_HEAP", body, "#endif"]
    made.append(stage_function(f"void equations_held({now}, double *h)", of_inputs, first))
    made.append(
        stage_function("void equations_prepare(const double *p, double *k)", of_parameters, [])
    )
    made.append(product.text)
    return files, len(of_parameters.kept), len(of_inputs.kept)


def _places(lists: Iterable[tuple[str, Sequence[object]]]) -> list[tuple[str, object]]:
    return [(f"{row}[{place}]", cell) for row, cells in lists for place, cell in enumerate(cells)]


def _moves(cell: object) -> bool:
    return isinstance(cell, Expr) and "u" in cell.rows


def _still(cell: Any) -> Any:
    """Return the part of a sum of conductances that does not depend on inputs."""
    if not _moves(cell):
        return cell
    linear = cell.op in {"add", "subtract", "negative"}
    return cell.graph.apply(cell.op, *map(_still, cell.args)) if linear else 0.0


def _tables(machine: Machine, equations: Equations) -> Iterator[str]:
    names = [entry.name for entry in machine.inputs]
    lagging = set(equations.lagging)
    boundaries = [names.index(name) for name in machine.boundary_index]
    acting = [
        (effect.amplitude, effect.off, effect.dependent, effect.states.start, len(effect.states))
        for effect in equations.acting
    ]
    lags = [place in lagging for place in range(len(equations.scales))]
    axis = machine.axis
    limits = (axis.slew_um_per_s, axis.farthest_um, axis.increment_um)
    yield from _array("size_t", "machine_boundaries", "BOUNDARIES", boundaries)
    yield from _array("size_t", "machine_levels", "LEVELS", equations.levels)
    yield from _array("struct acting", "machine_acting", "ACTING", acting)
    yield from _array("struct start", "machine_starts", "NODES", _starts(machine))
    yield from _array("struct resting", "machine_resting", "RESTING", _resting(machine))
    noise = noise_and_resolution(machine).values()
    yield from _array("struct sensor_noise", "machine_sensors", "SENSORS", noise)
    yield f"const struct axis_limits machine_axis = {_in_c(limits)};"
    node_scales = map(float, equations.node_scales)
    yield from _array("double", "machine_node_scales", "NODES", node_scales)
    yield from _array("double", "machine_state_scales", "STATES", map(float, equations.scales))
    yield from _array("double", "machine_nominals", "SIZE", nominals(equations))
    yield from _array("bool", "machine_lags", "STATES", lags)
    yield f"const bool machine_one_way = {_in_c(equations.one_way)};"
    yield f"const bool machine_settles = {_in_c(bool(equations.settling))};"


def _array(kind: str, name: str, size: str, rows: Iterable[object]) -> list[str]:
    lines = [f"    {_in_c(row)}," for row in rows]
    nothing = "    {0}," if kind.startswith("struct") else "    0,"
    return [f"const {kind} {name}[AT_LEAST_ONE({size})] = {{", *(lines or [nothing]), "};"]


def _in_c(value: object) -> str:
    """Return a value in C; a text is kept as it is."""
    match value:
        case None:
            return "NONE"
        case bool():
            return str(value).lower()
        case float():
            return literal(value)
        case tuple():
            return "{" + ", ".join(map(_in_c, value)) + "}"
    return str(value)


def _starts(machine: Machine) -> Iterator[tuple[object, ...]]:
    names = [entry.name for entry in machine.inputs]
    first = names.index(next(iter(machine.boundary_index)))
    sensors = start_sensors(machine)
    for node in machine.nodes:
        if node.start in machine.boundary_index:
            yield names.index(node.start), None, node.start_share
        else:
            yield first, None if node.rests else sensors.index(node.start), node.start_share


def _resting(machine: Machine) -> Iterator[tuple[object, ...]]:
    """Yield every node at rest: its place, and its shares of boundaries, start rises and 1 degC.

    The starts of the other nodes are also sums of these, so C does not have to solve a network.
    """
    if not any(node.rests for node in machine.nodes):
        return
    resting = RestingParts.of(machine)
    boundaries, sensors = list(machine.boundary_index), start_sensors(machine)
    starts = np.zeros((len(resting.others), len(boundaries) + len(sensors) + 1))
    for row, place in zip(starts, resting.others, strict=True):
        node = machine.nodes[place]
        if node.start in boundaries:
            row[0] += 1.0 - node.start_share
            row[boundaries.index(node.start)] += node.start_share
        else:
            row[0] = 1.0
            row[len(boundaries) + sensors.index(node.start)] = node.start_share
    of_others, of_ends = np.split(resting.weights[0], [len(resting.others)], axis=1)
    shares = of_others @ starts
    shares[:, : len(boundaries)] += of_ends[:, :-1]
    shares[:, -1] += of_ends[:, -1]
    for place, row in zip(resting.at, shares, strict=True):
        yield place, tuple(row.tolist())


def variable_sources(variables: Sequence[Variable], name: str, guid: str) -> str:
    """Return ``model_data.c``: the FMU's variables, in the order of their value references.

    Parameters
    ----------
    variables : sequence of Variable
    name, guid : str
        Of the FMU.
    """
    outputs = [variable.name for variable in variables if variable.is_output]
    derivatives = [variable.derivative_of for variable in variables if variable.derivative_of]
    rows, ranges = [], []
    for variable in variables:
        offset, start = "0", 0.0 if variable.is_computed else float(variable.start or 0.0)
        kind, causality = variable.kind.upper(), variable.causality.upper()
        if variable.is_output:
            offset = _in_memory("outputs", outputs.index(variable.name))
        elif variable.derivative_of:
            causality, offset = "DERIVATIVE", str(derivatives.index(variable.derivative_of))
        elif variable.is_computed:
            # Own states come after the temperatures.
            causality = "OUTPUT"
            offset = _in_memory("temperatures", derivatives.index(variable.name))
        elif variable.variability == "tunable":
            causality = "TUNABLE_PARAMETER"
        rows.append(_in_c((f'"{variable.name}"', kind, causality, start, offset)))
        unit = "" if variable.unit == "1" else f" {variable.unit}"
        ranges.append(_in_c((*_bounds(variable), f'"{unit}"')))
    seed = next(ref for ref, variable in enumerate(variables) if variable.name == NOISE_SEED)
    return "\n".join(
        [
            HEAD.format(name=name),
            '#include "plant.h"\n',
            f'const char *const model_guid = "{guid}";',
            f'const char *const model_name = "{name}";\n',
            "const struct variable model_variables[] = {",
            *(f"    {row}," for row in rows),
            "};",
            f"const size_t model_variable_count = {len(rows)};",
            "const struct range machine_ranges[] = {",
            *(f"    {row}," for row in ranges),
            "};",
            f"const struct ports model_ports = {{{seed}}};",
            "",
        ]
    )


def _in_memory(row: str, place: int) -> str:
    return f"offsetof(struct plant_memory, {row}) + {place} * sizeof(double)"


def _bounds(variable: Variable) -> tuple[float, float]:
    """Return a variable's allowed range; for offsets any finite number: the control limits them."""
    bounds = (None, None) if variable.name in OFFSETS else (variable.low, variable.high)
    low, high = (None, None) if variable.is_computed else bounds
    return -LARGEST if low is None else float(low), LARGEST if high is None else float(high)
