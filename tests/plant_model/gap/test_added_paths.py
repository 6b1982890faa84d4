"""Thousands of heat paths at once: the same as one after another, and when that is not possible."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.gap.mistakes import runs_of as lathe_runs
from plant_model.gap.added_paths import path_answers
from plant_model.gap.candidates import with_effect
from plant_model.gap.design import RunSensitivities
from plant_model.gap.kinds.base import CalibratedRun, Change
from plant_model.gap.kinds.heat_path import SIZES_W_PER_K, HeatPath
from plant_model.gap.observations import Observations, observe
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.parameters import FloatArray
from tests.plant_model.gap.conftest import runs_of

NOTHING = np.zeros((0, 0))


def known_of(machine: Machine, observed: Observations) -> CalibratedRun:
    none = RunSensitivities(NOTHING, NOTHING, NOTHING, {}, NOTHING)
    return CalibratedRun(machine, observed, none)


@pytest.fixture(scope="module", params=["jig_borer_lumps", "lathe"])
def run(request: pytest.FixtureRequest) -> CalibratedRun:
    machine = read_machine(request.param)
    runs = lathe_runs(machine) if request.param == "lathe" else runs_of(machine, every_s=120.0)
    (observed,) = observe(machine, runs[:1])
    return known_of(machine, observed)


def test_the_answers_are_those_of_simulating_every_path(run: CalibratedRun) -> None:
    paths = list(HeatPath.all_of([run]))
    chosen = np.random.default_rng(1).choice(len(paths), 24, replace=False)
    boundary = [one for one in paths if one.boundary][:6]
    some = list(dict.fromkeys([*(paths[i] for i in chosen), *boundary]))
    pairs = [one.place for one in some]
    told = path_answers(run.machine, run.observed, pairs, SIZES_W_PER_K)
    assert told is not None
    simulated: list[FloatArray] = Change.answers.__func__(HeatPath, some, run)  # type: ignore[attr-defined]
    largest = max(float(np.abs(one).max()) for one in simulated)
    assert largest > 1.0  # tolerances
    for one, exact in zip(told, simulated, strict=True):
        assert one.shape == exact.shape
        off = np.linalg.norm(one - exact, axis=1)
        assert np.all(off <= 0.04 * np.linalg.norm(exact, axis=1) + 1e-3 * largest)


def test_where_something_depends_on_temperature_every_path_is_simulated(
    run: CalibratedRun,
) -> None:
    paths = list(HeatPath.all_of([run]))[:2]
    pairs = [one.place for one in paths]
    for key in ("viscosity_temperature", "forced_convection", "column_bending"):
        machine = with_effect(run.machine, key)
        assert path_answers(machine, run.observed, pairs, SIZES_W_PER_K) is None
    told = HeatPath.answers(paths, known_of(machine, run.observed))
    assert [one.shape[0] for one in told] == [2, 2]
