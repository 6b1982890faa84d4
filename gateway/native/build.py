"""What a compensator FMU with a CAN terminal is made of: the C twin behind a node of the bus."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from fmu_packaging.bus_terminal import BusTerminal
from fmu_packaging.native.build import Native
from fmu_packaging.package import Recipe, slave_of
from fmu_packaging.variables import Variable
from gateway.dbc import DBC
from gateway.mapping import read_database
from gateway.native.generate import node_data

C_FOLDER = Path(__file__).resolve().parent / "c"
TERMINAL = BusTerminal("CAN", "can")
HEARD = " As the bus brings it; NaN: missing"
NOTE = (
    "It is a node of a CAN bus (FMI-LS-BUS 1.0.0, low cut): readings come in frames, and frames "
    "carry the offsets."
)
NO_BUS = "no_bus.c"
"""The source that the node stands in for."""


def native_on_bus(recipe: Recipe, native: Native, dbc: Path | None = None) -> Native:
    """Return what a compensator with a CAN terminal is made of.

    What was an input is an output: it shows what the frames brought.

    Parameters
    ----------
    recipe : Recipe
        Of the compensator's FMU.
    native : Native
        What its C twin is made of.
    dbc : Path, optional
        The frames; by default those of the gateway.

    Raises
    ------
    BadInput
        If the DBC file cannot be used, or does not carry what the compensator needs.
    """
    database = read_database(dbc or DBC)
    own = [native.variables.get(v.name, v) for v in slave_of(recipe).variables]
    inputs = {variable.name: variable for variable in own if variable.causality == "input"}
    sources = {path.name: path.read_text("utf-8") for path in sorted(C_FOLDER.iterdir())}
    sources |= node_data(database, own)

    def data(variables: Sequence[Variable], guid: str) -> Mapping[str, str]:
        # To the compensator's own C they are the inputs that they were.
        return native.data([inputs.get(variable.name, variable) for variable in variables], guid)

    return replace(
        native,
        program={**native.program, NO_BUS: sources.pop("node.c"), **sources},
        data=data,
        variables={**native.variables, **{name: _shown(v) for name, v in inputs.items()}},
        documents={**native.documents, database.path.name: database.path.read_bytes()},
        note=NOTE,
        bus=TERMINAL,
    )


def _shown(variable: Variable) -> Variable:
    description = f"{variable.description.partition(';')[0]}.{HEARD}"
    return replace(
        variable,
        causality="output",
        variability="discrete",
        description=description,
        start=None,
        depends_at_start=(),
    )
