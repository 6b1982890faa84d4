"""Run the gap finder on one case, as a user would, and keep its answer and details."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import gap_finder
import plant_model
from benchmarks.gap.case import RUNS
from benchmarks.gap.clock import clocked
from benchmarks.gap.make import OWNERS_FILE
from gap_finder.calibrate import calibrate
from gap_finder.comparison import GapComparison
from gap_finder.find import Judged, answer
from gap_finder.observations import observe
from gap_finder.regimes import by_channel
from gap_finder.report import report_of
from gap_finder.search import Search
from measurement.runs import Run, read_run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from scenarios.gap_runner import usable_runs

MACHINE = "jig_borer_lumps"


def runs_of(folder: Path) -> tuple[list[Run], list[Run]]:
    """Return a case's runs: those to calibrate on, and the held-out run."""
    runs = [read_run(path) for path in sorted(folder.glob("run_*.csv"))]
    return runs, [read_run(folder / f"{RUNS[-1]}.csv")]


def machine_of(folder: Path) -> Machine:
    """Return the machine of a case: its owner's file if there is one, else the shipped one."""
    own = folder / OWNERS_FILE
    return read_machine(str(own) if own.exists() else MACHINE)


def ask(folder: Path, without: Sequence[str] = (), seed: int = 0) -> dict[str, Any]:
    """Return the gap finder's answer to a case.

    Parameters
    ----------
    folder : Path
        With the case's runs and its owner's file, if there is one; the gap finder is given nothing
        else.
    without : sequence of str
        Effects removed from its catalogue.
    seed : int
        Of the gap finder.

    Returns
    -------
    dict
        ``answer`` is the content of ``gap.json``, ``details`` how it was reached, ``seconds`` the
        time.
    """
    machine = machine_of(folder)
    with clocked() as spent:
        judged, table = answered(machine, *runs_of(folder), without, seed)
    return {"seconds": spent, "answer": table, "details": _details(judged)}


def answered(
    machine: Machine,
    runs: list[Run],
    unseen: list[Run],
    without: Sequence[str] = (),
    seed: int = 0,
) -> tuple[Judged, dict[str, Any]]:
    """Return the result, judged on unseen runs, and the content of ``gap.json``."""
    sound, kept, faults = usable_runs(machine, runs, unseen)
    # One process, because several cases run in parallel.
    judged, more = answer(machine, sound, kept, Search(without, seed=seed, workers=1))
    return judged, report_of(judged, [*faults, *more])


def ask_empty(folder: Path, seed: int = 0) -> dict[str, Any]:
    """Return the gap of calibration with nothing hidden, in the form of ``answer``."""
    machine = machine_of(folder)
    with clocked() as spent:
        runs, unseen, _ = usable_runs(machine, *runs_of(folder))
        observed = observe(machine, runs)
        found = calibrate(machine, observed, seed=seed).machine
        gap = {
            "calibration": GapComparison(found, found, observed).gap(),
            "holdout": GapComparison(found, found, observe(machine, unseen)).gap(),
        }
    return {"seconds": spent, "answer": {"gap": gap}}


def _details(judged: Judged) -> dict[str, Any]:
    """Return data for studying thresholds later: all scores, and residuals by run and channel."""
    used, unseen = judged.used, judged.unseen
    before, after = (*used.before, *unseen.before), (*used.after, *unseen.after)
    return {
        "steps": [
            {
                "from": list(step.baseline.keys),
                "fall": step.fall,
                "unit": float(step.units.channels.mean()),
                "numbers_unit": step.units.numbers,
                "base": step.baseline.fit.left.sum(axis=0).tolist(),
                "base_moved": step.baseline.fit.numbers_moved,
                "base_others": step.baseline.fit.others_moved,
                "base_prior": step.baseline.prior_cost,
                "base_in_fit": step.baseline.cost_in_fit,
                "tried": {
                    one.keys[-1]: {
                        "cost": one.fit.cost,
                        "left": one.fit.left.sum(axis=0).tolist(),
                        "runs": len(one.fit.left),
                        "moved": one.fit.numbers_moved,
                        "others": one.fit.others_moved,
                        "prior": one.prior_cost,
                        "in_fit": one.cost_in_fit,
                    }
                    for one in step.tried
                },
            }
            for step in judged.result.search.steps
        ],
        "channels_by_run": {
            part.observed.run.name: {
                "before": by_channel([part]),
                "after": by_channel([later]),
            }
            for part, later in zip(before, after, strict=True)
        },
    }


@cache
def finder_version() -> str:
    """Return a fingerprint of the gap finder's code, the plant model's and the shipped machine."""
    rooms = [Path(module.__file__ or "").parent for module in (gap_finder, plant_model)]
    digest = hashlib.sha256()
    for room in rooms:
        for path in sorted((*room.rglob("*.py"), *room.rglob(f"{MACHINE}.toml"))):
            name = path.relative_to(room.parent).as_posix()
            digest.update(name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
