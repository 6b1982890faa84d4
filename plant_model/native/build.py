"""Parts of a machine's C99 FMU."""

from __future__ import annotations

import json
from collections.abc import Sequence

from fmu_packaging.native.build import TWIN_OF, Native
from fmu_packaging.native.compilers import NativeError
from fmu_packaging.package import Recipe
from fmu_packaging.variables import Variable
from plant_model.fmi_slave import MACHINE_FILE
from plant_model.machine import Machine
from plant_model.native.continuous import (
    continuous_variables,
    is_continuous,
    note_on_exchange,
)
from plant_model.native.equations import NoFormulaError, equations_of
from plant_model.native.generate import machine_sources, program, tunable_of, variable_sources


def native_plant(recipe: Recipe, twin_of: str = "") -> Native:
    """Return the parts of the C twin of a plant FMU.

    Parameters
    ----------
    recipe : Recipe
        Of the Python FMU.
    twin_of : str
        GUID of the Python FMU whose results it reproduces.

    Raises
    ------
    NativeError
        If an effect in force has no form in C.
    """
    machine = Machine.from_dict(json.loads(recipe.data[MACHINE_FILE]))
    try:
        tunable = tunable_of(machine)
        equations = equations_of(machine, tunable)
    except NoFormulaError as error:
        raise NativeError(f"--native: {error}") from None
    sources = {**program(), **machine_sources(machine, equations)}
    continuous = is_continuous(equations)
    more = continuous_variables(machine, equations, tunable) if continuous else {}

    def data(variables: Sequence[Variable], guid: str) -> dict[str, str]:
        return {"model_data.c": variable_sources(variables, recipe.identity.name, guid)}

    documents = {TWIN_OF: twin_of.encode()}
    note = note_on_exchange(equations)
    return Native(sources, data, MACHINE_FILE, more, documents, note, derivatives=continuous)
