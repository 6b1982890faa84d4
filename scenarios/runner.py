"""Simulates a scenario and writes its results folder."""

from __future__ import annotations

import platform
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

from measurement.errors import BadInput
from scenarios.cosimulation import simulate
from scenarios.fmu_files import check_fmus, find_fmu, fmus_of
from scenarios.pages.web_page import write_page_of
from scenarios.recording import FmuFacts, Recording, without_offsets
from scenarios.results import (
    check_folder,
    results_folder,
    write_recordings,
    write_report,
    write_scenario,
)
from scenarios.scenario import Scenario
from scenarios.table import Group
from scenarios.version import PROGRAM, version
from scenarios.views import charts_of, full_label_of, is_compensated, label_of, rig_of, table_of

LIVE = "spindle.html"

TABLE_NOTE = (
    "Largest and mean absolute drift of the tool tip over the whole run, counted at every "
    "communication step. Better by: 1 - mean with / mean without compensation."
)


def run_scenario(
    scenario: Scenario,
    out: Path,
    fmu_dir: Path,
    *,
    plant: str | None = None,
    compensator: str | None = None,
    live: bool = False,
    quiet: bool = False,
) -> tuple[dict[str, Any], list[Group], float]:
    """Simulate every variant of a scenario and write the results folder.

    Parameters
    ----------
    scenario : Scenario
        With at least one case.
    out : Path
        The results folder; see `scenarios.outputs.check_folder` for what it may contain.
    fmu_dir : Path
        Folder of FMUs named without a folder.
    plant, compensator : str, optional
        FMUs to use in all variants instead of the scenario's.
    live : bool
        Whether to write, next to the report, a page in which the last variant's machine and
        compensator run.
    quiet : bool
        No progress bar, no messages.

    Returns
    -------
    table : dict
        The content of ``table.json``.
    groups : list of Group
        The headline table.
    pace : float
        Simulated seconds per second of the loop.

    Raises
    ------
    BadInput
        If the scenario cannot be used; no folder is left behind.
    FmuError
        If an FMU fails; no folder is left behind.
    """
    check_folder(out)
    recordings: list[Recording] = []
    with tempfile.TemporaryDirectory(prefix="spindle-drift-built-") as work:
        near = scenario.path.resolve().parent
        find = partial(
            find_fmu, fmu_dir=fmu_dir, near=near, work=Path(work), quiet=quiet, native=True
        )
        named = [fmus_of(case, plant, compensator) for case in scenario.cases]
        if live and len(named[-1]) < 2:
            raise BadInput(scenario.path, "compensator", "is none, so there is no live page")
        used = [name for _, *names in named for name in names]
        check_fmus((name for name, *_ in named), used, fmu_dir, near)
        for case, (plant_name, *compensators) in zip(scenario.cases, named, strict=True):
            plant_fmu = find(plant_name)
            compensator_fmu = find(compensators[0]) if compensators else None
            recordings.append(simulate(case, plant_fmu, compensator_fmu, quiet=quiet))
        rig = rig_of(plant_fmu)
        live_page = b""
        if live and compensator_fmu is not None:
            write_page_of(plant_fmu, compensator_fmu, Path(work) / LIVE)
            live_page = (Path(work) / LIVE).read_bytes()
    groups = table_of(recordings)
    compensated = [entry for entry in recordings if is_compensated(entry)]
    notes = [
        note
        for entry in compensated
        for note in without_offsets(full_label_of(entry), entry.frame, entry.events)
    ]
    with results_folder(out) as folder:
        files = write_recordings(recordings, folder)
        if live_page:
            (folder / LIVE).write_bytes(live_page)
        write_scenario(scenario, folder)
        table = write_report(
            folder,
            groups,
            _facts(scenario, recordings, files) | {"notes": notes},
            charts_of(recordings, rig),
            title=scenario.settings.title,
            kicker=f"spindle-drift scenario: {scenario.settings.name}",
            description=scenario.settings.description,
            table_note=TABLE_NOTE,
            notes=notes,
            timelines=[
                (full_label_of(entry), entry.events, entry.case.settings.duration_s)
                for entry in compensated
            ],
            facts=_shown_facts(scenario, recordings),
        )
    simulated = sum(entry.case.settings.duration_s for entry in recordings)
    return (table, groups, simulated / max(sum(entry.wall_s for entry in recordings), 1e-9))


def versions() -> dict[str, str]:
    """Return the versions of the software that computed the results."""
    by_name = {PROGRAM: version(), "Python": platform.python_version()}
    return by_name | {name: metadata.version(name) for name in ("fmpy", "numpy")}


def _facts(
    scenario: Scenario, recordings: Sequence[Recording], files: dict[str, dict[str, str]]
) -> dict[str, Any]:
    settings = scenario.settings
    return {
        "scenario": {
            "name": settings.name,
            "title": settings.title,
            "duration_s": settings.duration_s,
            "step_s": settings.step_s,
            "seed": settings.seed,
            "overrides": dict(scenario.overrides),
        },
        "variants": [
            {
                "name": entry.case.name,
                "title": label_of(entry),
                "compensated": is_compensated(entry),
                "files": files[entry.case.name],
                "fmus": [asdict(fmu) for fmu in entry.fmus],
                "events": [asdict(event) for event in entry.events],
            }
            for entry in recordings
        ],
        "versions": versions(),
    }


def _shown_facts(scenario: Scenario, recordings: Sequence[Recording]) -> list[tuple[str, str]]:
    settings = scenario.settings
    steps = f"{settings.duration_s:g} s in steps of {settings.step_s:g} s, seed {settings.seed}"
    facts = [("Scenario", f"{scenario.path.name}: {steps}")]
    facts += [("Set on the command line", f"{key} = {value}") for key, value in scenario.overrides]
    return facts + fmu_facts([fmu for entry in recordings for fmu in entry.fmus])


def fmu_facts(fmus: Sequence[FmuFacts]) -> list[tuple[str, str]]:
    """Return a report's facts about FMUs and versions; each FMU once."""
    shown = {
        fmu.guid: (
            f"{fmu.label.capitalize()} FMU",
            f"{fmu.file} ({fmu.model}), GUID {fmu.guid}, SHA-256 {fmu.sha256}"
            + (f", by {fmu.tool}" if fmu.tool else ""),
        )
        for fmu in fmus
    }
    named = ", ".join(f"{name} {number}" for name, number in versions().items())
    return [*shown.values(), ("Computed by", named)]
