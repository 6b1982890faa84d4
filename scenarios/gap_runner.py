"""Runs the gap finder on a machine and measured runs, and writes its results folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gap_finder.data_faults import DataFault, need_readings, without_faults
from gap_finder.find import FEWEST_RUNS, answer
from gap_finder.five_lines import five_lines
from gap_finder.long_log import need_no_leap, pieces_of
from gap_finder.observations import Observations
from gap_finder.report import MACHINE_AFTER, MACHINE_BEFORE, report_of
from gap_finder.search import USUAL, Search
from measurement.doubts import doubt_lines
from measurement.errors import BadInput
from measurement.runs import Run
from measurement.warm import named_warm
from plant_model.drive import column_in, outside_ranges
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import machine_path
from plant_model.machine_writer import write_machine
from plant_model.sensors import column_of, displacement_names
from scenarios.fmu_files import build_plant
from scenarios.gap_cosimulation import compare_fmus
from scenarios.pages.gap_page import PAGE, write_gap_page
from scenarios.results import check_folder, results_folder, write_table

GAP = "gap.json"
FMUS = ("plant_before", "plant_after")


def run_find_gap(
    machine: Machine,
    source: str | Path,
    runs: Sequence[Run],
    holdout: Sequence[Run],
    out: Path,
    *,
    search: Search = USUAL,
    fmu: bool = True,
    split_hours: float | None = None,
    say: Callable[[str], None],
) -> tuple[dict[str, Any], list[str]]:
    """Find the gap and write the results folder; no folder is left if anything fails.

    Parameters
    ----------
    machine : Machine
    source : str or Path
        Machine file that it came from, or its shipped name.
    runs, holdout : sequence of Run
        To calibrate on and to judge by; without *holdout* the last of *runs* is held out.
    out : Path
        Results folder.
    search : Search
        Settings of the search.
    fmu : bool
        Whether to build the plant FMUs and co-simulate them.
    split_hours : float, optional
        Longer runs are cut into pieces of this length [h].
    say : callable
        Called with what is being done.

    Returns
    -------
    table : dict
        The content of ``gap.json``.
    lines : list of str
        The same as text.

    Raises
    ------
    BadInput
        If the input cannot be used.
    FmuError
        If a plant FMU fails.
    """
    check_folder(out)
    used, kept_back = _kept_back(runs, holdout, split=split_hours is not None)
    every = [*used, *kept_back]
    lacking = remarks(machine, every)
    for line in lacking:
        say(line)
    say("looking for broken channels")
    used, kept_back, faults = usable_runs(machine, used, kept_back)
    if split_hours is not None:
        used, kept_back = _in_pieces(machine, used, kept_back, split_hours)
    judged, more = answer(machine, used, kept_back, search, progress=say)
    result = judged.result
    observed = [run.observed for run in judged.unseen.before]
    faults = sorted([*faults, *more], key=lambda fault: (fault.run, fault.channel, fault.start_s))
    with results_folder(out) as folder:
        machines = {MACHINE_BEFORE: result.before.machine, MACHINE_AFTER: result.after.machine}
        for name, which in machines.items():
            write_machine(which, source, folder / name)
        cosimulation = _cosimulated(machines, observed, folder, say) if fmu else None
        table = report_of(judged, faults, cosimulation) | {"remarks": lacking}
        facts = [
            ("Machine", f"{machine.title} ({machine_path(source).name})"),
            ("Runs used", _named(used)),
            ("Never used", _named(kept_back)),
            ("Not considered", ", ".join(search.without) or "-"),
            ("Without effect in these runs", ", ".join(table["silent"]) or "-"),
            ("Remarks on the runs", "; ".join(lacking) or "-"),
            ("Seed", str(search.seed)),
        ]
        write_gap_page(judged, table, facts, folder)
        text = json.dumps(table, indent=1, allow_nan=False) + "\n"
        (folder / GAP).write_text(text, encoding="utf-8")
        write_table([], {"gap": GAP}, folder)
    return table, [*five_lines(table), *lacking, f"report: {out / PAGE}"]


def check_search(search: Search, split_hours: float | None) -> None:
    """Refuse an impossible search, or unusable lengths of pieces [h], before a run is read."""
    for name in search.without:
        if name not in catalogue():
            raise BadInput("--without", "", f"{name} is not one of {', '.join(catalogue())}")
    for option, value, low, high in (
        ("--workers", search.workers, 1, 256),
        ("--most", search.most, 1, 20),
        ("--split-hours", split_hours, 0.5, 1000.0),
    ):
        if value is not None and not low <= value <= high:
            raise BadInput(option, "", f"{value:g} is outside {low:g}..{high:g}")


def _kept_back(
    runs: Sequence[Run], unseen: Sequence[Run], *, split: bool
) -> tuple[list[Run], list[Run]]:
    """Return the runs to calibrate on and those to judge by."""
    used, kept_back = list(runs), list(unseen)
    if not kept_back and not split:
        if len(used) <= FEWEST_RUNS:
            problem = f"{len(used)} given; {FEWEST_RUNS + 1} or more are needed without --holdout"
            raise BadInput("--runs", "", problem)
        kept_back = [used.pop()]
    by_content: dict[str, Run] = {}
    for run in (*used, *kept_back):
        same = by_content.setdefault(run.fingerprint(), run)
        if same is not run:
            problem = f"is the same run as {same.path or same.name}"
            raise BadInput(run.path or run.name, "", problem)
    names = [run.name for run in by_content.values()]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BadInput("--runs", "", f"{twice[0]} stands for more than one run")
    return used, kept_back


def _in_pieces(
    machine: Machine, used: list[Run], kept_back: list[Run], hours: float
) -> tuple[list[Run], list[Run]]:
    """Cut long runs into pieces; without runs to judge by, the last piece is held out."""
    pieces = [piece for run in used for piece in pieces_of(machine, run, hours)]
    least = FEWEST_RUNS if kept_back else FEWEST_RUNS + 1
    if len(pieces) < least:
        problem = f"{hours:g} h make {len(pieces)} runs; {least} or more are needed"
        raise BadInput("--split-hours", "", problem)
    return (pieces, kept_back) if kept_back else (pieces[:-1], pieces[-1:])


def usable_runs(
    machine: Machine, runs: Sequence[Run], unseen: Sequence[Run] = ()
) -> tuple[list[Run], list[Run], list[DataFault]]:
    """Remove faulty data from the runs to calibrate on and those to judge by.

    All are checked together, because a wrong level shows only against other runs. No model is
    involved.

    Parameters
    ----------
    machine : Machine
    runs, unseen : sequence of Run
        To calibrate on, and to judge by; no run is in both.

    Returns
    -------
    used, kept_back : list of Run
        With faulty data as NaN, without runs of which too little is left.
    faults : list of DataFault
        What was removed.

    Raises
    ------
    BadInput
        If a run needs cutting, or too little is left of either.
    """
    for run in (*runs, *unseen):
        _need_inputs(machine, run)
        need_no_leap(run)
    left, faults = without_faults(machine, [*runs, *unseen])
    first, last = ({run.name for run in part} for part in (runs, unseen))
    used = [run for run in left if run.name in first]
    kept_back = [run for run in left if run.name in last]
    spoilt = [fault for fault in faults if fault.run not in {run.name for run in left}]
    if unseen and not kept_back:
        raise BadInput("--holdout", unseen[0].name, f"cannot be used: {spoilt[0].text}")
    if len(used) < min(FEWEST_RUNS, len(runs)):
        problem = f"only {len(used)} of {len(runs)} can be used: {spoilt[0].text}"
        raise BadInput("--runs", "", problem)
    need_readings(machine, used, "--runs")
    need_readings(machine, kept_back, "--holdout")
    return used, kept_back, faults


def _need_inputs(machine: Machine, run: Run) -> None:
    """Refuse a run without the machine's inputs."""
    for entry in machine.inputs:
        if entry.default is not None:
            continue
        column = column_in(run.frame, entry)
        if column is None:
            problem = f"has no column {entry.column}, which the machine needs as its {entry.name}"
            raise BadInput(run.path or run.name, "", problem)
        if run.frame[column].isna().all():
            problem = "has no value in the whole run"
            raise BadInput(run.path or run.name, f"column {column}", problem)


def remarks(machine: Machine, runs: Sequence[Run]) -> list[str]:
    """Return a line for whatever makes runs differ from what a machine file describes.

    These are sensors that some or all of the runs lack, inputs outside their ranges, units, clocks
    and signs that look wrong, and runs that began warm.

    Parameters
    ----------
    machine : Machine
    runs : sequence of Run
    """
    lines = []
    for name in [sensor.name for sensor in machine.sensors] + displacement_names(machine):
        column = column_of(machine, name)
        lacking = [run.name for run in runs if column not in run.frame.columns]
        if lacking:
            every = len(lacking) == len(runs)
            where = "in no run" if every else f"not in {', '.join(lacking)}"
            lines.append(f"not compared: {name}, its column {column} is {where}")
    for run in runs:
        for column, text in outside_ranges(machine, run.frame).items():
            lines.append(f"doubtful: {run.name}, {column}: {text}, the machine file's range")
    lines += doubt_lines(runs)
    warm = named_warm(runs)
    if warm:
        problem = "parts without a thermometer start at the hall's temperature in the model"
        lines.append(f"begun while the machine was warm: {warm}; {problem}")
    return lines


def _cosimulated(
    machines: Mapping[str, Machine],
    observed: Sequence[Observations],
    folder: Path,
    say: Callable[[str], None],
) -> dict[str, Any]:
    """Build the FMUs of both machines' files in the folder, and co-simulate the held-out runs."""
    built = []
    for name, (file, which) in zip(FMUS, machines.items(), strict=True):
        say(f"co-simulating {name}.fmu")
        built.append((build_plant(str(folder / file), folder, name), which))
    return compare_fmus(built[0], built[1], observed)


def _named(runs: Sequence[Run]) -> str:
    return ", ".join(f"{run.name} ({run.sha256[:12]})" for run in runs)
