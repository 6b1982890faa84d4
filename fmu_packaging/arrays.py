"""Temperatures as one array variable instead of many variables, an option for FMI 3.0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fmu_packaging.native.compilers import NativeError
from fmu_packaging.variables import Variable

NAME = "temperatures"
OFFSETS = ("dX", "dY", "dZ")
SOURCE = "fmi3_array.c"
"""The C source that defines which variables an array holds."""
ARRAY = """\
/* Made by spindle-drift; not to be edited. */
#include "model.h"

const struct array model_array = {{{first}, {count}}};
"""


def temperatures(variables: Sequence[Variable]) -> list[Variable]:
    """Return the temperatures that one FMU reads and the other uses.

    Parameters
    ----------
    variables : sequence of Variable
        Variables of a plant, which computes temperatures, or of a compensator, which computes
        offsets.
    """
    computes = any(variable.name in OFFSETS and variable.is_output for variable in variables)
    side = "input" if computes else "output"
    return [v for v in variables if v.unit == "degC" and v.causality == side]


def in_array(variables: Sequence[Variable]) -> list[Variable]:
    """Return the variables with the temperatures as one array, in the place of the first.

    Parameters
    ----------
    variables : sequence of Variable
        In the order of their value references.

    Raises
    ------
    NativeError
        If the temperatures are not contiguous, or another variable has the array's name.
    """
    members = temperatures(variables)
    first = variables.index(members[0]) if members else 0
    if not members or list(variables[first : first + len(members)]) != members:
        raise NativeError("--arrays: the temperatures do not follow one another")
    if any(variable.name == NAME for variable in variables):
        raise NativeError(f"--arrays: there is a variable {NAME} already")
    temperature = members[0]
    names = ", ".join(member.name for member in members)
    missing = "; NaN: missing" if temperature.causality == "input" else ""
    at_start = [member.depends_at_start for member in members]
    known = [names for names in at_start if names is not None]
    lows, highs = [v.low for v in members], [v.high for v in members]
    array = replace(
        temperature,
        name=NAME,
        description=f"Temperatures {names}, in this order{missing}",
        low=min((low for low in lows if low is not None), default=None),
        high=max((high for high in highs if high is not None), default=None),
        depends=tuple(name for member in members for name in member.depends),
        depends_at_start=tuple(n for names in known for n in names) if known == at_start else None,
        elements=len(members),
    )
    gone = {member.name for member in members}
    others = [
        replace(v, depends=tuple(dict.fromkeys(NAME if n in gone else n for n in v.depends)))
        for v in variables
    ]
    return [*others[:first], array, *others[first + len(members) :]]


def array_source(variables: Sequence[Variable]) -> str:
    """Return the C source that defines which variables are in the array.

    Parameters
    ----------
    variables : sequence of Variable
        Individual variables, in the order of their value references.
    """
    members = temperatures(variables)
    return ARRAY.format(first=variables.index(members[0]), count=len(members))
