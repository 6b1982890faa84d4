"""The parts of the C99 FMU of a compensator file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fmu_compensator.native.generate import constants, data_sources, program
from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from fmu_compensator.runtime.modelfile import parse_model
from fmu_packaging.native.build import TWIN_OF, Native
from fmu_packaging.package import Recipe, slave_of
from fmu_packaging.variables import Variable

NO_OTHER_FILE = (
    "Must be empty: this FMU has its compensator file compiled in and reads no other. The Python "
    "FMU of the same file takes the path of another one here"
)


def native_compensator(recipe: Recipe, *, twin_of: str = "") -> Native:
    """Return the parts of the C twin of a compensator FMU.

    Parameters
    ----------
    recipe : Recipe
        Recipe of the Python FMU.
    twin_of : str
        GUID of the Python FMU whose results it reproduces.

    Raises
    ------
    NativeError
        If the file or a variable has no counterpart in C.
    """
    model = parse_model(recipe.data[MODEL_FILE].decode(), MODEL_FILE)
    inputs = tuple(model.sensors[place].name for place in model.chosen)
    inputs += ("tool_length",) if model.geometry.needs_tool_length else ()
    outputs = [variable for variable in slave_of(recipe).variables if variable.is_output]
    linear = model.new_error_model().linear
    derived = {v.name: replace(v, depends=inputs) for v in outputs} if linear else {}
    other = next(variable for variable in slave_of(recipe).variables if variable.is_parameter)

    def data(variables: Sequence[Variable], guid: str) -> dict[str, str]:
        return {"model_data.c": data_sources(model, variables, recipe.identity.name, guid)}

    return Native(
        {**program(), "constants.h": constants()},
        data,
        MODEL_FILE,
        {other.name: replace(other, description=NO_OTHER_FILE)} | derived,
        {TWIN_OF: twin_of.encode()},
        derivatives=bool(derived),
    )
