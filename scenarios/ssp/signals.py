"""Builds the FMU that plays a scenario's signals."""

from __future__ import annotations

import io
from collections.abc import Mapping
from html import escape
from pathlib import Path

import numpy as np
import pandas as pd

from fmu_packaging.description import Identity
from fmu_packaging.documentation import Page
from fmu_packaging.package import Package, Recipe, build
from scenarios.scenario import Case
from scenarios.signals.base import FloatArray
from scenarios.ssp.slave import SIGNALS_FILE
from scenarios.version import version

ICON = Path(__file__).resolve().parents[2] / "fmu_packaging" / "assets" / "signals.png"


def signals_fmu(case: Case, time_s: FloatArray, columns: Mapping[str, FloatArray]) -> Package:
    """Return the FMU that plays signals.

    Parameters
    ----------
    case : Case
        The scenario's variant that they belong to.
    time_s : ndarray
        The communication points [s], shape (points,).
    columns : dict of str to ndarray
        The values that hold from each point on, by ``name_unit``; shape (points,).
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
        f"<p>Plays {escape(settings.name)} ({escape(settings.title)}), variant "
        f"{escape(case.name)}: {settings.duration_s:g} s. A value holds from its time to the next, "
        f"and the last one beyond the end. The table is <code>resources/{SIGNALS_FILE}</code>.</p>"
    )
    recipe = Recipe(
        identity,
        "scenarios.ssp.slave",
        "SignalsSlave",
        roots=("scenarios", "fmu_packaging"),
        data={SIGNALS_FILE: table_text(time_s, columns).encode()},
        page=Page("What drives a spindle over time.", (("What it does", work),)),
        icon=ICON.read_bytes(),
    )
    return build(recipe)


def table_text(time_s: FloatArray, columns: Mapping[str, FloatArray]) -> str:
    """Return the table of the points at which a value changes, as CSV with every digit."""
    values = np.column_stack(list(columns.values()))
    changed = np.ones(len(time_s), dtype=bool)
    changed[1:] = (values[1:] != values[:-1]).any(axis=1)
    frame = pd.DataFrame({"time_s": time_s, **columns})[changed]
    stream = io.StringIO()
    frame.to_csv(stream, index=False, lineterminator="\n")
    return stream.getvalue()
