"""Thousands of heat paths at once: the same as one after another."""

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.gap.mistakes import runs_of as lathe_runs
from gap_finder.added_paths import AddedPath, path_answers
from gap_finder.candidates import with_effect
from gap_finder.design import RunSensitivities
from gap_finder.kinds.base import CalibratedRun, Change
from gap_finder.kinds.conductance_with_motion import ConductanceWithMotion
from gap_finder.kinds.heat_path import HeatPath
from gap_finder.linearise import simulate_at
from gap_finder.observations import Observations, observe
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.parameters import FloatArray
from tests.gap_finder.conftest import runs_of

NOTHING = np.zeros((0, 0))


def known_of(machine: Machine, observed: Observations) -> CalibratedRun:
    none = RunSensitivities(NOTHING, NOTHING, NOTHING, NOTHING)
    return CalibratedRun(machine, observed, simulate_at(machine, observed), none)


@pytest.fixture(scope="module", params=["jig_borer_lumps", "lathe"])
def run(request: pytest.FixtureRequest) -> CalibratedRun:
    machine = read_machine(request.param)
    runs = lathe_runs(machine) if request.param == "lathe" else runs_of(machine, every_s=120.0)
    (observed,) = observe(machine, runs[:1])
    return known_of(machine, observed)


def test_the_answers_are_those_of_simulating_every_path(run):
    paths = list(HeatPath.all_of([run]))
    chosen = np.random.default_rng(1).choice(len(paths), 24, replace=False)
    boundary = [one for one in paths if one.boundary][:6]
    some = list(dict.fromkeys([*(paths[i] for i in chosen), *boundary]))
    told = path_answers(run.machine, run.observed, [*map(added, some)])
    assert_those_of_simulating(HeatPath, some, told, run)


def added(one: HeatPath | ConductanceWithMotion) -> AddedPath:
    sizes = tuple(point["conductance"] for point in one.points())
    return AddedPath(one.place[:2], sizes, *one.place[2:])


def assert_those_of_simulating(
    kind: type[Change],
    some: Sequence[Change],
    told: Sequence[FloatArray],
    run: CalibratedRun,
    least: float = 1e-3,
    share: float = 0.04,
) -> None:
    simulated: list[FloatArray] = Change.answers.__func__(kind, some, [run])[0]  # type: ignore[attr-defined]
    largest = max(float(np.abs(one).max()) for one in simulated)
    assert largest > 1.0  # tolerances
    for one, exact in zip(told, simulated, strict=True):
        assert one.shape == exact.shape
        off = np.linalg.norm(one - exact, axis=1)
        assert np.all(off <= share * np.linalg.norm(exact, axis=1) + least * largest)


@pytest.mark.parametrize(
    "key", ["viscosity_temperature", "natural_convection", "column_bending", "sensor_lag:front"]
)
def test_the_answers_are_those_of_simulating_beside_other_laws(run, key):
    machine = with_effect(run.machine, key)
    paths = [one for one in HeatPath.all_of([run]) if not one.boundary]
    some = [paths[i] for i in np.random.default_rng(3).choice(len(paths), 12, replace=False)]
    known = known_of(machine, run.observed)
    # A large path takes what depends on temperature out of its linear range.
    assert_those_of_simulating(HeatPath, some, HeatPath.answers(some, [known])[0], known, share=0.1)
