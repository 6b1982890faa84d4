"""The independent truth: heat is kept, cells converge, effects are switched and nothing else."""

import ast
import re
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import benchmarks.gap.truth
from benchmarks.gap.case import TruthCase
from benchmarks.gap.drive import Drive, lagged
from benchmarks.gap.hidden import SIZES, make_from
from benchmarks.gap.truth.case import COLUMNS, SHOP, simulate_case
from benchmarks.gap.truth.cells import INLET
from benchmarks.gap.truth.laws import gap_film, vogel_factor
from benchmarks.gap.truth.march import March
from benchmarks.gap.truth.spindle import CLASS, Spindle
from measurement.runs import read_run, write_run

PRODUCT = ("plant_model", "gap_finder", "fmu_compensator", "scenarios", "spindle_drift")


def still(hours: float, speed: float = 0.0, rows: int = 121) -> Drive:
    """A drive at one speed, everything outside at 20 degC and undisturbed."""
    time_s = np.linspace(0.0, 3600.0 * hours, rows)
    outside = np.column_stack([np.full((rows, 3), 20.0), np.zeros((rows, 2))])
    held = np.full(rows, speed)
    return Drive("test", time_s, held, np.zeros(rows), np.zeros(rows), time_s, outside)


def test_no_simulator_shares_anything_with_the_model_under_test():
    """Nor do the physics of the jig borer with those of the others."""
    folder = Path(benchmarks.gap.truth.__file__).parent
    beside = [
        folder.parent / f"{name}.py"
        for name in ("case", "drive", "hidden", "laws", "march", "numbers", "cells")
    ]
    for path in (*folder.parent.rglob("*/**/*.py"), *beside):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert not name.startswith((*PRODUCT, "benchmarks.gap.around_page")), path
                if folder in path.parents:
                    assert not re.match(r"benchmarks\.gap\.(belt|lathe|enclosed)", name), path
                elif path not in beside:
                    assert not name.startswith("benchmarks.gap.truth"), path


def test_conduction_keeps_heat():
    """Each link gives what it takes; only boundaries and the coolant's flow carry heat away."""
    spindle = Spindle(CLASS.nominal())
    for group, (inner, outer) in spindle.matrices.items():
        # A machine at the boundaries' temperature is in balance.
        assert np.abs(inner.sum(axis=1) + outer.sum(axis=1)).max() < 1e-9 * np.abs(inner).max()
        if not group.startswith("flow_"):
            assert np.allclose(inner, inner.T, rtol=1e-12, atol=0.0)


def test_the_heat_put_in_is_the_heat_that_leaves():
    spindle, speed = Spindle(CLASS.nominal()), 12000.0
    march, drive = March(spindle), still(200.0, 12000.0)
    end = march.settle(drive, np.full(len(spindle.capacity), 20.0), 1800.0)
    put_in = sum(float(q.sum()) for q in spindle.friction(speed)) + spindle.p["motor"] * 12.0
    lost = 0.0
    for group, (_, outer) in spindle.matrices.items():
        if group.startswith("film_"):
            lost += float(outer.sum(axis=1) @ (end - 20.0))
    for name in ("rear", "motor", "front"):
        flow = spindle.matrices[f"flow_{name}"][1][:, INLET].sum()
        lost += float(flow * (end[spindle.parts[f"jacket_{name}"][-1]] - 20.0))
    assert put_in > 500.0
    assert lost == pytest.approx(put_in, rel=1e-4)


def test_over_a_transient_heat_is_stored_or_lost():
    """The time stepping itself neither makes nor loses heat (closed machine, heated)."""
    spindle = Spindle(CLASS.nominal())
    for group, (inner, outer) in spindle.matrices.items():
        if group.startswith(("film_", "flow_")):
            inner[:], outer[:] = 0.0, 0.0
    for group in spindle.surfaces:
        spindle.surfaces[group] = []
    drive = still(2.0, 9000.0)
    temperatures = March(spindle).run(drive, np.full(len(spindle.capacity), 20.0))
    stored = (temperatures - 20.0) @ spindle.capacity
    power = sum(float(q.sum()) for q in spindle.friction(9000.0)) + spindle.p["motor"] * 9.0
    assert stored == pytest.approx(power * drive.time_s, rel=1e-6, abs=1.0)


def test_time_steps_converge_with_second_order():
    spindle = Spindle(CLASS.nominal())
    drive = still(1.0, 15000.0, rows=7)
    start = np.full(len(spindle.capacity), 20.0)
    hidden = [make_from(SHOP.effects, "viscosity_temperature", 0.03, np.random.default_rng(0))]
    runs = [March(spindle, hidden, refine=k).run(drive, start) for k in (1, 2, 4, 16)]
    errors = [np.abs(one[-1] - runs[-1][-1]).max() for one in runs[:3]]
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.35)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.35)


def test_readings_converge_with_resolution():
    drive = still(3.0, 14000.0, rows=10)
    found = []
    for resolution in (0.5, 1.0, 2.0):
        spindle = Spindle(CLASS.nominal(), resolution)
        temperatures = March(spindle).run(drive, np.full(len(spindle.capacity), 20.0))
        pose = (temperatures - temperatures[0]) @ spindle.pose_weights
        shown = spindle.readings(temperatures, pose)
        found.append(np.array([shown[name][-1] for name in sorted(shown)]))
    coarse, fine = np.abs(found[0] - found[2]), np.abs(found[1] - found[2])
    assert fine.max() < 0.6  # K and um, of 15 K and 30 um
    assert fine.mean() < 0.6 * coarse.mean()


def test_laws():
    assert gap_film(0.0, 0.05, 0.7e-3) == pytest.approx(0.0263 / 0.7e-3)
    films = [gap_film(n, 0.05, 0.7e-3) for n in (0.0, 5e3, 10e3, 20e3)]
    assert np.all(np.diff(films) > 0.0)
    steps = np.array([-1e-4, 1e-4])
    assert np.diff(np.log(vogel_factor(steps, 0.03)))[0] / 2e-4 == pytest.approx(-0.03, rel=1e-4)
    time_s = np.linspace(0.0, 100.0, 11)
    ramp = lagged(time_s, time_s, 20.0)
    assert ramp == pytest.approx(time_s - 20.0 * (1.0 - np.exp(-time_s / 20.0)))


@cache
def run_of(*hidden: tuple[str, str | float, str]) -> pd.DataFrame:
    """One held-out run; every effect shows in it."""
    case = TruthCase(11, hidden, resolution=0.5, runs=("holdout",))
    return simulate_case(case)[0][0].frame


@pytest.mark.parametrize("name", sorted(SHOP.effects))
def test_off_is_bit_identical_and_more_changes_more(name):
    sizes = SHOP.effects[name].sizes
    assert 0.0 < sizes[0] < sizes[1] < sizes[2]
    channel, empty = ("T6" if SHOP.effects[name].channels else ""), run_of()
    pd.testing.assert_frame_equal(empty, run_of((name, 0.0, channel)), check_exact=True)
    small, changed = (run_of((name, size, channel)) for size in (SIZES[0], SIZES[2]))
    weak, strong = (np.abs((run - empty).to_numpy()) for run in (small, changed))
    assert np.isfinite(strong).all()
    assert strong.max() > 0.3
    assert 0.0 < weak.mean() < strong.mean()
    for column in ("time_s", "speed_rpm", "torque_Nm", "T5_degC", "T9_degC"):
        assert changed[column].equals(empty[column])


def test_its_runs_are_run_files(tmp_path):
    runs, _ = simulate_case(TruthCase(7, resolution=0.5))
    families = [run.drive.family for run in runs]
    assert len(set(families)) == len(families)
    for run in runs:
        found = read_run(write_run(run.frame, tmp_path / f"{run.name}.csv"))
        assert tuple(found.frame.columns) == COLUMNS
        assert 4.9 * 3600 < found.time_s[-1] < 8.1 * 3600
        assert 19.0 <= np.median(np.diff(found.time_s)) <= 61.0
        assert found.frame["speed_rpm"].max() <= 20e3
        assert np.array_equal(found.frame, run.frame)
    assert any(run.frame["torque_Nm"].max() > 0.0 for run in runs[:4])
