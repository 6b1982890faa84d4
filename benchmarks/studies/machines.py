"""The simulated machines, and what a study's experiment measures on each.

- The jig borer of `plant_model`: a network of lumps with eleven thermometers and a five-point rig.
- The same with a tilt and a cooler of the studies' size (`study_size.toml`).
- A spindle of finite elements in the same size, whose friction, films and jackets are not those of
  the description that the error model ``fem`` starts from. It is axisymmetric, so it only grows.

Every run comes with its twin without noise: what a perfect model would predict.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.studies.cooler import with_cooler
from fmu_compensator.fit.columns import MeasuredColumns
from measurement.rig import FivePointRig, rig_from_table
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from scenarios.machine_inputs import inputs_of
from scenarios.scenario import read_scenario
from studies.finite_elements import FiniteElementSpindle, read_description
from studies.finite_elements.description import Description

EVERY_S = 30.0
NOISE_K, RESOLUTION_K = 0.03, 0.01
NOISE_UM, RESOLUTION_UM = 0.2, 0.1
THERMOMETERS = {  # radius and place along the axis [mm], on the resting parts
    "T1": (46.0, -75.0),  # rear bearing
    "T2": (90.0, 7.0),  # spindle pedestal
    "T6": (46.0, 285.0),  # front bearing
    "T7": (46.0, 315.0),  # front bearing, towards the nose
    "T8": (74.0, 60.0),  # motor
    "T11": (74.0, 120.0),  # motor
}
FRICTION, MOTOR, JACKET, FILM = 1.25, 0.9, 0.85, 0.7
"""The finite-element spindle's own f0, loss, jackets and film diameters, over the shipped ones."""

STEP, OTHER = "step_speed", "random_speed"
LIKE: Mapping[str, Any] = {
    "ambient": 21.0,
    "coolant_inlet": {"kind": "first_order", "start": 21.0, "end": 24.2, "time_constant_s": 6000.0},
}
"""Hall and coolant of the training run; with a cooler of its own the coolant is what it makes."""
UNLIKE: Mapping[str, Any] = {
    "ambient": {"kind": "ramp", "start": 21.0, "end": 23.0, "end_s": 28800.0},
    "coolant_inlet": {"kind": "first_order", "start": 21.0, "end": 21.6, "time_constant_s": 7200.0},
}
COLDER_K = 1.5
"""By so much lower the studies' cooler is set where the coolant is another [K]."""
PROTOCOLS = {
    "fit": (STEP, LIKE),
    "repeated": (STEP, LIKE),
    "like": (OTHER, LIKE),
    "unlike": (OTHER, UNLIKE),
}
"""Speeds and surroundings. ``fit`` is the training run itself; each other run has its own noise,
and the unseen spectrum is another one for every seed."""


@dataclass(frozen=True)
class Pair:
    """One run as the rig records it, and as it would without noise."""

    measured: Run
    exact: Run

    def thinned(self, every: int) -> Pair:
        """Return the same with one row of so many."""
        return Pair(*(_run(run, run.frame.iloc[::every]) for run in (self.measured, self.exact)))


def _run(run: Run, frame: pd.DataFrame) -> Run:
    return Run(run.name, frame.reset_index(drop=True))


@dataclass(frozen=True)
class Truth:
    """A machine of the benchmark.

    Attributes
    ----------
    title : str
        For the tables.
    rig : FivePointRig or MeasuredColumns
        What it measures.
    record : callable
        From speeds, surroundings and a number of the noise to a pair of runs.
    """

    title: str
    rig: FivePointRig | MeasuredColumns
    record: Callable[[list[tuple[str, Any]], bool, int], Pair]

    def runs(self, seed: int) -> dict[str, Pair]:
        """Return the runs of all protocols."""
        found = {}
        for number, (name, (speeds, surroundings)) in enumerate(PROTOCOLS.items()):
            overrides = [(f"signals.{key}", value) for key, value in surroundings.items()]
            if speeds == OTHER:
                overrides.append(("signals.speed.seed", 500 + seed))
            scenario = [("", speeds), *overrides]
            found[name] = self.record(scenario, surroundings is UNLIKE, 100 * seed + number)
        return found


def _inputs(machine: Machine, scenario: list[tuple[str, Any]], every_s: float) -> pd.DataFrame:
    case = read_scenario(scenario[0][1], scenario[1:]).cases[0]
    return inputs_of(case, machine, every_s)


def _lumps(
    machine: Machine, scenario: list[tuple[str, Any]], noise: int, parameters: Mapping[str, float]
) -> Pair:
    inputs = _inputs(machine, scenario, EVERY_S)
    frames = [
        simulate(machine, inputs, parameters, noise_seed=seed).run_frame() for seed in (noise, None)
    ]
    return Pair(*(Run(scenario[0][1], frame) for frame in frames))


def _jig_borer() -> Truth:
    machine = read_machine("jig_borer_lumps")

    def record(scenario: list[tuple[str, Any]], unlike: bool, noise: int) -> Pair:
        return _lumps(machine, scenario, noise, {})

    return Truth("jig borer", _rig(machine), record)


def _study_size() -> Truth:
    table = tomllib.loads(Path(__file__).with_name("study_size.toml").read_text("utf-8"))
    machine, cooler = read_machine(table["machine"]), table["cooler"]
    lower = {name: cooler[name] - COLDER_K for name in ("on_above", "off_below")}
    cooled, colder = with_cooler(machine, **cooler), with_cooler(machine, **{**cooler, **lower})

    def record(scenario: list[tuple[str, Any]], unlike: bool, noise: int) -> Pair:
        return _lumps(colder if unlike else cooled, scenario, noise, table["parameters"])

    return Truth("study-sized jig borer", _rig(machine), record)


def _elements() -> Truth:
    spindle = FiniteElementSpindle(_other_description())
    machine = read_machine("jig_borer_lumps")
    points = 1e3 * spindle.heat.basis.doflocs
    nearest = {
        sensor: int(np.argmin(np.hypot(points[0] - r, points[1] - z)))
        for sensor, (r, z) in THERMOMETERS.items()
    }

    def record(scenario: list[tuple[str, Any]], unlike: bool, noise: int) -> Pair:
        inputs = _inputs(machine, scenario, EVERY_S)
        air, coolant = inputs["ambient"].to_numpy(), inputs["coolant_inlet"].to_numpy()
        time, speed = inputs["time_s"].to_numpy(), inputs["speed"].to_numpy()
        found = spindle.transient(time, speed, air, coolant)
        exact = {name: found.temperatures[:, node] for name, node in nearest.items()}
        exact |= {"T5": air, "T9": coolant}
        columns = {f"{name}_degC": exact[name] for name in sorted(exact, key=lambda s: int(s[1:]))}
        random = np.random.default_rng(noise)
        base = {"time_s": time, "speed_rpm": speed}
        noisy = {name: _read(v, NOISE_K, RESOLUTION_K, random) for name, v in columns.items()}
        noisy["elongation_um"] = _read(found.growth_um, NOISE_UM, RESOLUTION_UM, random)
        clean = columns | {"elongation_um": found.growth_um}
        name = scenario[0][1]
        return Pair(Run(name, pd.DataFrame(base | noisy)), Run(name, pd.DataFrame(base | clean)))

    return Truth("finite elements", MeasuredColumns(["elongation_um"]), record)


TRUTHS: Mapping[str, Callable[[], Truth]] = {
    "study_size": _study_size,
    "jig_borer": _jig_borer,
    "elements": _elements,
}


@cache
def truth(name: str) -> Truth:
    """Return a machine by its name in `TRUTHS`."""
    return TRUTHS[name]()


def settling_min() -> tuple[float, float]:
    """Return when the study-sized machine's axial drift first is 75 % and 95 % of its largest."""
    frame = truth("study_size").runs(1)["fit"].exact.frame
    drift = np.abs(frame["S5_um"] - frame["S5_um"].iloc[0]).to_numpy()
    minutes = frame["time_s"].to_numpy() / 60.0
    early, late = (float(minutes[np.argmax(drift >= part * drift.max())]) for part in (0.75, 0.95))
    return early, late


def _rig(machine: Machine) -> FivePointRig:
    rig = rig_from_table(dict(machine.rig), machine.name)
    assert isinstance(rig, FivePointRig)
    return rig


def _read(
    exact: np.ndarray, noise: float, resolution: float, random: np.random.Generator
) -> np.ndarray:
    noisy = exact + noise * random.standard_normal(len(exact))
    return np.round(noisy / resolution) * resolution


def _other_description() -> Description:
    table = read_description("jig_borer").model_dump()
    for bearing in table["bearings"]:
        bearing["f0"] *= FRICTION
    for motor in table["motors"]:
        motor["watts_per_1000rpm"] *= MOTOR
    for jacket in table["jackets"]:
        jacket["conductance"] *= JACKET
    for surface in table["surfaces"]:
        surface["diameter_mm"] *= FILM
    return Description.model_validate(table)
