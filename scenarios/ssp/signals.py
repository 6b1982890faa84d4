"""Builds the FMU that plays a scenario's signals."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fmu_packaging.description import Identity
from fmu_packaging.documentation import Page
from fmu_packaging.native.build import Fmi, Native, native_package
from fmu_packaging.native.compilers import Compiler
from fmu_packaging.package import Package, Recipe, build
from fmu_packaging.variables import Variable
from scenarios.scenario import Case
from scenarios.signals.base import FloatArray
from scenarios.ssp.slave import SIGNALS_FILE
from scenarios.version import version

C_FOLDER = Path(__file__).resolve().parent / "c"
SIZES = """\
#ifndef SIGNALS_SIZE_H
#define SIGNALS_SIZE_H

#define SIGNALS {signals}
#define ROWS {rows}

#endif
"""
ICON = Path(__file__).resolve().parents[2] / "fmu_packaging" / "assets" / "signals.png"


def signals_fmu(
    case: Case,
    time_s: FloatArray,
    columns: Mapping[str, FloatArray],
    compilers: Sequence[Compiler] = (),
    fmi: Fmi = 2,
) -> Package:
    """Return the FMU that plays signals.

    Parameters
    ----------
    case : Case
        The scenario's variant.
    time_s : ndarray
        The communication points [s], shape (points,).
    columns : dict of str to ndarray
        The values that hold from each point on, by ``name_unit``; shape (points,).
    compilers : sequence of Compiler
        The FMU is compiled with each; without a compiler it is in Python.
    fmi : {2, 3}
        FMI version of an FMU in C.

    Raises
    ------
    CompileError
        If a compiler fails.
    """
    settings = case.settings
    identity = Identity(
        "signals",
        f"Signals of a scenario: {settings.title}",
        f"Speed, boundary temperatures and tool length of the scenario {settings.name}, variant "
        f"{case.name}, over time.",
        version(),
        settings.duration_s,
        settings.step_s,
    )
    work = (
        f"<h2>What it does</h2>\n<p>Plays {escape(settings.name)} ({escape(settings.title)}), "
        f"variant {escape(case.name)}: {settings.duration_s:g} s. A value holds from its time to "
        "the next, and the last one beyond the end. The table is "
        f"<code>resources/{SIGNALS_FILE}</code>.</p>"
    )
    recipe = Recipe(
        identity,
        "scenarios.ssp.slave",
        "SignalsSlave",
        roots=("scenarios", "fmu_packaging"),
        data={SIGNALS_FILE: table_text(time_s, columns).encode()},
        page=Page("What drives a spindle over time.", work),
        icon=ICON.read_bytes(),
    )
    if not compilers:
        return build(recipe)
    sources = {path.name: path.read_text("utf-8") for path in sorted(C_FOLDER.glob("signals.?"))}
    rows = _changes(columns)
    sources["signals_size.h"] = SIZES.format(signals=len(columns), rows=int(rows.sum()))

    def data(variables: Sequence[Variable], guid: str) -> dict[str, str]:
        return {"model_data.c": data_source(variables, identity.name, guid, time_s, columns)}

    return native_package(recipe, Native(sources, data, SIGNALS_FILE), compilers, fmi)


def data_source(
    variables: Sequence[Variable],
    name: str,
    guid: str,
    time_s: FloatArray,
    columns: Mapping[str, FloatArray],
) -> str:
    """Return ``model_data.c``: the FMU's variables, all outputs, and the table with every digit."""
    rows = _changes(columns)
    times = ", ".join(map(repr, time_s[rows].tolist()))
    values = np.column_stack(list(columns.values()))[rows].tolist()
    return "\n".join(
        [
            '#include "signals.h"\n',
            f'const char *const model_guid = "{guid}";',
            f'const char *const model_name = "{name}";',
            "const struct variable model_variables[] = {",
            *(
                f'    {{"{variable.name}", REAL, OUTPUT, 0.0, {place} * sizeof(double)}},'
                for place, variable in enumerate(variables)
            ),
            "};",
            f"const size_t model_variable_count = {len(variables)};",
            f"const double signals_times[ROWS] = {{{times}}};",
            "const double signals_values[ROWS][SIGNALS] = {",
            *(f"    {{{', '.join(map(repr, row))}}}," for row in values),
            "};",
            "",
        ]
    )


def _changes(columns: Mapping[str, FloatArray]) -> NDArray[np.bool_]:
    """Return the points at which a value differs from the previous one, including the first."""
    values = np.column_stack(list(columns.values()))
    changed = np.ones(len(values), dtype=bool)
    changed[1:] = (values[1:] != values[:-1]).any(axis=1)
    return changed


def table_text(time_s: FloatArray, columns: Mapping[str, FloatArray]) -> str:
    """Return the table of the points at which a value changes, as CSV with every digit."""
    frame = pd.DataFrame({"time_s": time_s, **columns})[_changes(columns)]
    stream = io.StringIO()
    frame.to_csv(stream, index=False, lineterminator="\n")
    return stream.getvalue()
