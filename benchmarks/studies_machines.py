"""The two simulated machines on which the studies' experiment is rebuilt.

- The jig borer of `plant_model`: a network of lumps with eleven thermometers and a five-point rig.
- A spindle of finite elements in the same size, whose friction, films and jackets are not those of
  the description that the error model ``fem`` starts from. It is axisymmetric, so it only grows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from fmu_compensator.fit.finite_elements import FiniteElementSpindle, read_description
from fmu_compensator.fit.finite_elements.description import Description
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from scenarios.commands.simulate import inputs_of
from scenarios.scenario import read_scenario

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


def jig_borer(names: Sequence[str]) -> list[Run]:
    """Return runs of the jig borer on the speeds of shipped scenarios, as its rig records them."""
    machine = read_machine("jig_borer")
    runs = []
    for name in names:
        inputs, seed = _inputs(machine, name)
        runs.append(Run(name, simulate(machine, inputs, noise_seed=seed).run_frame()))
    return runs


def finite_element_spindle(names: Sequence[str]) -> list[Run]:
    """Return runs of the finite-element spindle on the same speeds: temperatures and growth."""
    spindle = FiniteElementSpindle(_other_description())
    points = 1e3 * spindle.heat.basis.doflocs
    nearest = {
        sensor: int(np.argmin(np.hypot(points[0] - r, points[1] - z)))
        for sensor, (r, z) in THERMOMETERS.items()
    }
    runs = []
    for name in names:
        inputs, seed = _inputs(read_machine("jig_borer"), name)
        air, coolant = inputs["ambient"].to_numpy(), inputs["coolant_inlet"].to_numpy()
        time, speed = inputs["time_s"].to_numpy(), inputs["speed"].to_numpy()
        found = spindle.transient(time, speed, air, coolant)
        random = np.random.default_rng(seed)
        exact = {name: found.temperatures[:, node] for name, node in nearest.items()}
        exact |= {"T5": air, "T9": coolant}
        frame = {"time_s": time, "speed_rpm": speed}
        for sensor in sorted(exact, key=lambda sensor: int(sensor[1:])):
            frame[f"{sensor}_degC"] = _read(exact[sensor], NOISE_K, RESOLUTION_K, random)
        frame["elongation_um"] = _read(found.growth_um, NOISE_UM, RESOLUTION_UM, random)
        runs.append(Run(name, pd.DataFrame(frame)))
    return runs


def _inputs(machine: Machine, scenario: str) -> tuple[pd.DataFrame, int]:
    """Return a shipped scenario's signals and the seed of its sensors' noise."""
    case = read_scenario(scenario).cases[0]
    return inputs_of(case, machine, EVERY_S), case.settings.seed


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
