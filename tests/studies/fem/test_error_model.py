"""The finite-element spindle as an error model: reduction, identification, refusals."""

import dataclasses
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.fields import Fields
from measurement.rig import DirectRig
from measurement.runs import Run
from studies.finite_elements import FiniteElementSpindle
from studies.finite_elements.reduce import ReducedSpindle
from studies.fit.fem import FiniteElementModel
from tests.mangling import mangled
from tests.refusing import refusal

RIG = DirectRig.model_validate({"axes": {"disp_z": {"axis": "Z"}, "disp_x": {"axis": "X"}}})


def spectrum(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    time_s = np.arange(0.0, 5.0 * 3600.0, 60.0)
    speed = np.repeat(random.integers(0, 9, 20) * 2000.0, 15)[: len(time_s)]
    return time_s, speed


def run_of(seed: int, air: np.ndarray, near: np.ndarray, growth: np.ndarray) -> Run:
    """A run whose axial displacement is the spindle's own, and X a third of it."""
    time_s, speed = spectrum(seed)
    columns = {"time_s": time_s, "speed_rpm": speed, "T5_degC": air, "T1_degC": near}
    moved = {"disp_z_um": growth, "disp_x_um": growth / 3.0}
    return Run(f"run_{seed}", pd.DataFrame(columns | moved))


def measured(spindle: FiniteElementSpindle, seed: int) -> Run:
    """A run with noise, in air that swings."""
    time_s, speed = spectrum(seed)
    air = 21.0 + np.sin(time_s / 4000.0 + seed)
    rested = spindle.steady(0.0, float(air[0]), 22.0)
    found = spindle.transient(time_s, speed, air, 22.0, start=rested, longest_s=20.0)
    run = run_of(seed, air, found.temperatures[:, 0], found.growth_um)
    run.frame[["disp_z_um", "disp_x_um"]] += (
        0.05 * np.random.default_rng(seed).standard_normal((2, len(time_s))).T
    )
    return run


def level_run(spindle: FiniteElementSpindle, seed: int) -> Run:
    """A run without noise in which air and coolant stay as warm as the machine is at the start."""
    time_s, speed = spectrum(seed)
    growth = spindle.transient(time_s, speed, 20.0, 20.0, longest_s=20.0).growth_um
    return run_of(seed, 20.0 + 1e-3 * np.sin(time_s), 20.0 + growth, growth)


def task_of(runs: list[Run], form: str = "rise") -> Task:
    prepared = prepare(runs, RIG, form)
    return Task(
        [run.history([0, 1]) for run in prepared.runs], ["T5", "T1"], prepared.targets, form
    )


@pytest.fixture(scope="module")
def runs(jig_borer: FiniteElementSpindle) -> list[Run]:
    return [measured(jig_borer, seed) for seed in (1, 2, 3)]


@pytest.fixture(scope="module")
def table(runs: list[Run]) -> dict[str, Any]:
    return FiniteElementModel.fit(task_of(runs[:1]), identify=False).table()


def test_the_reduced_spindle_follows_the_whole_one(jig_borer):
    reduced = ReducedSpindle(jig_borer, 14, (0.0, 12000.0))
    mass = jig_borer.heat.mass
    identity = reduced.basis.T @ (mass @ reduced.basis)
    assert identity == pytest.approx(np.eye(len(identity)), abs=1e-8)
    # The steady state lies within the basis.
    (_, turning) = reduced.regimes()
    forcing = jig_borer.heat.powers(12000.0) @ reduced.entries
    steady = turning.vectors @ ((turning.vectors.T @ forcing) / turning.rates)
    assert reduced.growth @ steady == pytest.approx(jig_borer.zss(12000.0), rel=2e-3)


def growth_missed(fitted: FiniteElementModel, found: list[Run]) -> list[float]:
    rows = task_of(found).runs
    errors = [(fitted.predict(run) - run.targets)[:, 0] for run in rows]
    return [float(np.sqrt(np.mean(error**2))) for error in errors]


@pytest.mark.long
def test_fourteen_coordinates_do_for_a_thousand_nodes(jig_borer):
    """The figures of docs/methods.md: 0.05 um in fit, 0.1 um on other spectra."""
    level = [level_run(jig_borer, seed) for seed in (1, 2, 3, 4)]
    assert jig_borer.heat.basis.N == 1045
    assert all(28.0 < run.frame["disp_z_um"].max() < 36.0 for run in level)
    fitted = FiniteElementModel.fit(task_of(level[:1]), modes=14)
    first, *others = growth_missed(fitted, level)
    assert first < 0.05
    assert max(others) < 0.1


@pytest.mark.long
def test_a_start_that_is_not_level_costs_more_than_the_reduction(jig_borer, runs):
    """The same where air swings by 1 K and the coolant differs from it: up to 0.8 um."""
    fitted = FiniteElementModel.fit(task_of(runs[:1]))
    missed = growth_missed(fitted, [runs[2], measured(jig_borer, 4)])
    assert 0.3 < missed[0] < missed[1] < 0.85


def test_it_identifies_a_spindle_that_differs(jig_borer):
    """Half the cooling: the factor on the jackets finds it, and the error on new speeds shrinks."""
    form = jig_borer.description
    jackets = [one.model_copy(update={"conductance": one.conductance / 2}) for one in form.jackets]
    other = FiniteElementSpindle(form.model_copy(update={"jackets": jackets}))
    found = [measured(other, seed) for seed in (4, 5, 6)]
    task, unseen = task_of(found[:2]), task_of(found[2:]).runs[0]
    errors = []
    for identify in (False, True):
        fitted = FiniteElementModel.fit(task, identify=identify)
        errors.append(float(np.sqrt(np.mean((fitted.predict(unseen) - unseen.targets) ** 2))))
    assert fitted.report()["factors"]["jackets"] == pytest.approx(0.5, rel=0.25)
    assert errors[1] < 0.8 * errors[0]


def test_air_is_used_where_it_was_chosen(runs, table):
    assert table["outside_inputs"] == [0]
    without = dataclasses.replace(task_of(runs[:1]), input_names=["A", "T1"])
    assert FiniteElementModel.fit(without, identify=False).table()["outside_inputs"] == []


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"modes": 3}, "modes"),
        ({"penalty": -1.0}, "penalty"),
        ({"description": "no_such.toml"}, "no_such.toml"),
        ({"description": 5}, "is not a file's name"),
    ],
)
def test_wrong_options_are_refused(runs, options, problem):
    assert problem in refusal(FiniteElementModel.fit, task_of(runs[:1]), **options)


def test_runs_without_speed_are_refused(runs):
    task = task_of(runs[:1])
    for value, problem in ((np.nan, "speed_rpm: is not known in every run"), (0.0, "is always 0")):
        run = dataclasses.replace(task.runs[0], speed=np.full(len(task.runs[0].time_s), value))
        assert problem in refusal(FiniteElementModel.fit, dataclasses.replace(task, runs=[run]))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("regimes.1.rates.0", 0.0),
        ("regimes.1.speed", 0.0),
        ("outputs.0.0", ...),
        ("outside_inputs.0", 7),
        ("sources.0.load", -1.0),
        ("regimes.0.colour", 1),
    ],
)
def test_a_damaged_table_is_refused(table, field, value):
    damaged = Fields(mangled(table, field, value), "file")
    assert refusal(error_models()["fem"].from_fields, damaged, 2, 2)
