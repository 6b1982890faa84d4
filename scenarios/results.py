"""The results folder: written next to its destination, then moved there whole.

A results folder contains ``table.json``, which lists its files. A folder that contains nothing else
counts as results and may be replaced by the same command; see `scenarios.outputs`.
"""

from __future__ import annotations

import contextlib
import json
import secrets
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fmu_packaging.reference import DECIMALS
from measurement.errors import BadInput
from measurement.files import FULL
from measurement.runs import write_run
from scenarios.outputs import RESULTS, TABLE, is_replaceable, made_by
from scenarios.outputs import check_folder as check_folder
from scenarios.pages.charts import Chart
from scenarios.pages.report import STATES, spans_of, write_page
from scenarios.recording import Event, Recording
from scenarios.scenario import Scenario
from scenarios.table import Group, as_list
from scenarios.views import seen

REPORT = "report.html"


@contextlib.contextmanager
def results_folder(folder: Path) -> Iterator[Path]:
    """Give a temporary folder that replaces *folder* when the block succeeds.

    If the block fails or is interrupted, nothing of it stays and the existing folder is untouched.

    Parameters
    ----------
    folder : Path
        Missing parents are created.

    Yields
    ------
    Path
        The temporary folder, next to *folder*.

    Raises
    ------
    BadInput
        See `check_folder`; or if the folder cannot be created, or the disk is full.
    """
    check_folder(folder)
    target = folder.resolve()
    mark = secrets.token_hex(4)
    beside, old = (target.parent / f".{target.name}.{mark}.{end}" for end in ("new", "old"))
    try:
        beside.mkdir(parents=True)
    except OSError as error:
        raise BadInput(folder, "", f"cannot be made: {error.strerror}") from None
    try:
        yield beside
        if target.exists() and not is_replaceable(target):  # only reached with --force
            _put_into(target, beside)
            return
        if target.exists():
            target.rename(old)
        try:
            beside.rename(target)
        except OSError as error:
            if old.exists():
                old.rename(target)
            raise BadInput(folder, "", f"cannot be replaced: {error.strerror}") from None
    except BadInput as error:  # of a file in it: nobody knows the temporary folder's name
        source = error.source.replace(str(beside), str(folder))
        raise BadInput(source, error.place, error.problem) from None
    except OSError as error:
        if error.errno in FULL:
            raise BadInput(folder, "", f"cannot be written: {error.strerror}") from None
        raise
    finally:
        shutil.rmtree(beside, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)


def _put_into(folder: Path, results: Path) -> None:
    """Move results into a folder that contains other files; those with other names stay."""
    for path in sorted(results.iterdir()):
        try:
            path.replace(folder / path.name)
        except OSError as error:
            raise BadInput(folder / path.name, "", f"cannot be replaced: {error}") from None


def write_recordings(recordings: Sequence[Recording], folder: Path) -> dict[str, dict[str, str]]:
    """Write the time series, and return the names of the files by variant.

    The first variant has ``results.csv`` and ``run.csv``, the others ``results_<variant>.csv`` and,
    if their machine's readings differ, ``run_<variant>.csv``.
    """
    files: dict[str, dict[str, str]] = {}
    first: pd.DataFrame | None = None
    for recording in recordings:
        end = "" if first is None else f"_{recording.case.name}"
        rows = recorded(recording)
        names = {"results": f"results{end}.csv"}
        numbers = rows.round(DECIMALS)
        write_run(numbers.replace([np.inf, -np.inf], np.nan), folder / names["results"])
        run = machine_run(recording, rows)
        if first is None or not run.equals(first):
            names["run"] = f"run{end}.csv"
            write_run(run, folder / names["run"])
        else:
            names["run"] = "run.csv"
        first = run if first is None else first
        files[recording.case.name] = names
    return files


def recorded(recording: Recording) -> pd.DataFrame:
    """Return the rows to record in the scenario: the first, and one every *record_s* [s]."""
    settings = recording.case.settings
    every = round(settings.record_s / settings.step_s)
    return recording.frame.iloc[::every].reset_index(drop=True)


def machine_run(recording: Recording, rows: pd.DataFrame) -> pd.DataFrame:
    """Return what the machine itself would have recorded: a run file like a measured one.

    It has commands (speed, feed, torque), the machine's inputs under their run-file columns, and
    sensor readings with noise and faults; not drift and error at the tool tip, which nobody
    measures.
    """
    commands = {
        str(name): str(name)
        for name in rows.columns
        if str(name).endswith(("_s", "_rpm", "_mm_min", "_Nm", "_W", "_lpm"))
    }
    columns = {
        file: rows[own].to_numpy()
        for own, file in (commands | recording.inputs).items()
        if own in rows and file not in recording.sensors
    }
    columns |= {name: seen(rows, name) for name in recording.sensors}
    return pd.DataFrame(columns).round(DECIMALS)


def write_table(groups: Sequence[Group], facts: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Write ``table.json`` into *folder*, and return its content.

    Parameters
    ----------
    groups : sequence of Group
    facts : dict
        Other entries of the file.
    folder : Path

    Returns
    -------
    dict
        The content, as read from JSON.
    """
    files = sorted({*(path.name for path in folder.iterdir()), TABLE})
    head = {"kind": RESULTS, "format": 1, **made_by(), **facts}
    table = {**head, "files": files, "table": as_list(groups)}
    text = json.dumps(table, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    (folder / TABLE).write_text(text, encoding="utf-8")
    return table


def write_findings(
    out: Path, name: str, text: str, draw: Callable[[Path], Sequence[Path]]
) -> list[Path]:
    """Write the folder of a command's findings: ``NAME.json`` and its figures.

    Parameters
    ----------
    out : Path
        Replaced whole or not at all.
    name, text : str
        Name and text of the JSON.
    draw : callable
        Takes the folder to draw into, and returns the files.

    Returns
    -------
    list of Path
        The files, the JSON first.
    """
    with results_folder(out) as folder:
        (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
        drawn = draw(folder)
        write_table([], {name: f"{name}.json"}, folder)
    return [out / f"{name}.json", *(out / path.name for path in drawn)]


def write_scenario(scenario: Scenario, folder: Path) -> None:
    """Write a copy of the scenario, with the command line's settings as comments on top."""
    lines = [
        f"# set on the command line: {key} = {json.dumps(value, default=str)}\n"
        for key, value in scenario.overrides
    ]
    (folder / "scenario.toml").write_text("".join(lines) + scenario.text, encoding="utf-8")


def write_report(
    folder: Path,
    groups: Sequence[Group],
    details: dict[str, Any],
    charts: Sequence[Chart],
    *,
    timelines: Sequence[tuple[str, Sequence[Event], float]],
    **values: Any,
) -> dict[str, Any]:
    """Write figures, report and ``table.json`` of a scenario or a replay into its results folder.

    Parameters
    ----------
    folder : Path
    groups : sequence of Group
        The headline table.
    details : dict
        Other entries of ``table.json``.
    charts : sequence of Chart
        Each becomes a figure, and all are in the report.
    timelines : sequence of (label, events, end)
        The compensator's status over time, by variant or run; the end in seconds.
    **values
        ``title``, ``kicker`` above it, ``description`` below; ``table_note``, a sentence under the
        table, and ``notes`` on it; ``facts``, the provenance.

    Returns
    -------
    dict
        The content of ``table.json``.
    """
    from scenarios.pages.figures import draw  # only here: it loads Matplotlib

    for chart in charts:
        draw(chart, folder)
    write_page(
        "report.html",
        folder / REPORT,
        groups=groups,
        axes=sorted({axis for group in groups for row in group.rows for axis in row.axes}),
        states=STATES,
        timelines=[
            (label, spans_of(events, end_s), end_s, events) for label, events, end_s in timelines
        ],
        charts=charts,
        files=sorted({*(path.name for path in folder.iterdir()), TABLE}),
        **values,
    )
    return write_table(groups, details, folder)
