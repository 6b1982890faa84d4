"""What is learnt from and what is judged on: measured and simulated runs, like and unlike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.rig import Rig, default_rig, rig_from_table
from measurement.runs import Run, read_run
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from scenarios.machine_inputs import inputs_of
from scenarios.scenario import read_scenario

TRAINING = ("training_down", "training_random", "training_stops", "training_warm_hall")
JUDGED = ("step_speed", "stop_and_go")
RECORD = "electric_spindle/first_3000_min.csv"
EVERY_S = 30.0
NO_SLEW = {"slew_um_per_s": 1000.0}
"""The slew limit of a control has no part in the model's error."""
PIECE_H = 6.0
"""The electric spindle's record is one of 50 h; it is cut into pieces, each a warm restart [h]."""


@dataclass(frozen=True)
class Question:
    """One split of runs.

    Attributes
    ----------
    data, name : str
        Which machine, and what sets the judged runs apart.
    unlike : bool
        Whether the judged runs are of conditions that were not learnt from.
    train, judged : sequence of Run
    rig : Rig
        What the displacements mean.
    """

    data: str
    name: str
    unlike: bool
    train: Sequence[Run]
    judged: Sequence[Run]
    rig: Rig


def fitted(question: Question, kind: str | None, **options: Any) -> Model:
    """Return a compensator of an error model, or of fit's own choice, as it would be installed."""
    table = fit_compensator(question.train, question.rig, kind, **options)
    return parse_model(compensator_text(table), question.name)


def questions(folder: Path) -> Iterator[Question]:
    """Yield all splits of all data that the folder holds, and the simulated ones."""
    yield from lathe_questions(folder / "lathe")
    yield from electric_questions(folder / RECORD)
    yield from simulated_questions()


def lathe_runs(folder: Path) -> list[Run]:
    """Return the lathe's runs, by date; none where the folder has none."""
    return [read_run(path) for path in sorted(folder.glob("2*.csv"))]


def lathe_questions(folder: Path) -> Iterator[Question]:
    """Yield the splits of the lathe's thirty runs: by month, hall, speed, and every fifth run."""
    runs = lathe_runs(folder)
    if not runs:
        return
    rig = default_rig(runs[0], read_machine("jig_borer_lumps").rig)
    places = np.arange(len(runs))
    start = np.array([_start(run) for run in runs])
    speed = np.array([float(np.nanmean(run.frame["speed_rpm"])) for run in runs])
    order = np.argsort(start, kind="stable")
    early = np.array([run.name < "202008" for run in runs])

    def split(name: str, out: np.ndarray, unlike: bool = True) -> Question:
        train = [runs[place] for place in places if place not in out]
        return Question("lathe", name, unlike, train, [runs[place] for place in out], rig)

    for first in (0, 2):
        yield split(f"every fifth run, from number {first + 1}", places[first::5], unlike=False)
    yield split("August to October, from June and July", places[~early])
    yield split("June and July, from the rest", places[early])
    yield split("the ten coldest starts", np.sort(order[:10]))
    yield split("the ten warmest starts", np.sort(order[-10:]))
    yield split("means above 1,200 r/min", places[speed > 1200.0])
    yield split("means below 1,200 r/min", places[speed <= 1200.0])
    yield split("all but the first six", places[6:])


def electric_questions(record: Path) -> Iterator[Question]:
    """Yield the halves of the electric spindle's record, and every other piece of `PIECE_H`."""
    if not record.is_file():
        return
    whole = read_run(record)
    rows = round(PIECE_H * 3600.0 / float(np.median(np.diff(whole.time_s))))
    pieces = [
        Run(f"{whole.name}_{at}", whole.frame.iloc[at : at + rows].reset_index(drop=True))
        for at in range(0, len(whole.frame) - rows // 2, rows)
    ]
    rig = rig_from_table({"kind": "direct", "axes": {"growth": {"axis": "Z"}}}, "rig")
    half = len(pieces) // 2
    for name, unlike, train, judged in (
        ("the second half", True, pieces[:half], pieces[half:]),
        ("the first half", True, pieces[half:], pieces[:half]),
        ("every other piece", False, pieces[::2], pieces[1::2]),
    ):
        yield Question("electric spindle", name, unlike, train, judged, rig)


def simulated_questions() -> Iterator[Question]:
    """Yield the shipped jig borer's training, judged on machines and halls that are not its own."""
    machine = read_machine("jig_borer_lumps")
    rig = rig_from_table(machine.rig, "rig")
    train = [simulated(name) for name in TRAINING]
    judged: list[tuple[str, dict[str, Any]]] = [
        ("the same machine, other speeds", {}),
        ("coolant 3 K warmer", {"coolant_k": 3.0}),
        ("coolant 3 K colder", {"coolant_k": -3.0}),
        ("hall 6 K warmer", {"hall_k": 6.0}),
        ("a thicker lubricant", {"change": lambda key: 1.5 if key.endswith(".viscosity") else 1.0}),
        ("a worn front bearing", {"change": {"sources.front_bearing.f1": 2.5}.get}),
        ("another machine of the series", {"change": _drawn}),
    ]
    for name, changes in judged:
        runs = [simulated(base, f"{base}, {name}", **changes) for base in JUDGED]
        yield Question("jig borer", name, bool(changes), train, runs, rig)


@cache
def _drawn(name: str) -> float:
    """Return a factor within 15 %, the same for the same name."""
    return float(np.random.default_rng([ord(letter) for letter in name]).uniform(0.85, 1.15))


def simulated(
    scenario: str,
    name: str = "",
    *,
    of: str = "jig_borer_lumps",
    coolant_k: float = 0.0,
    hall_k: float = 0.0,
    change: Callable[[str], float | None] = lambda key: 1.0,
) -> Run:
    """Return a run of a library scenario, with noise, on a machine that may be changed.

    *change* gives the factor of each of its parameters by name.
    """
    machine = read_machine(of)
    case = read_scenario(scenario).cases[0]
    inputs = inputs_of(case, machine, EVERY_S)
    inputs["coolant_inlet"] += coolant_k
    inputs["ambient"] += hall_k
    values = {
        key: min(max(parameter.value * factor, parameter.low), parameter.high)
        for key, parameter in machine.parameters.items()
        if parameter.low < parameter.high and (factor := change(key) or 1.0) != 1.0
    }
    result = simulate(machine, inputs, values, noise_seed=case.settings.seed)
    return Run(name or scenario, result.run_frame())


def _start(run: Run) -> float:
    first = run.frame[list(run.temperatures)].to_numpy(float)[0]
    return float(np.nanmedian(first))
