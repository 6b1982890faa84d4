"""The third truth: heat is kept, stretches converge, its owner's file is of the same lathe."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tomlkit

import benchmarks.gap.lathe
from benchmarks.gap.belt.march import March
from benchmarks.gap.enclosed import Hidden
from benchmarks.gap.lathe.case import SHOP, owners_file, simulate_case
from benchmarks.gap.lathe.effects import BEYOND, OUTSIDE, catalogue, everything
from benchmarks.gap.lathe.machine import TOP_SPEED, Lathe
from benchmarks.gap.lathe.numbers import HIDDEN, draw_drawing
from benchmarks.gap.lathe.owner import MISTAKES
from benchmarks.gap.truth.case import TruthCase
from benchmarks.gap.truth.effects import make_from
from benchmarks.gap.truth.effects.base import SIZES
from gap_finder.kinds import kinds
from plant_model.effects import catalogue as products_catalogue
from plant_model.machine_file import machine_from_table
from tests.gap_truth.test_belt import still


@cache
def lathe(finer: float = 1.0) -> Lathe:
    """The middle of the class."""
    numbers = {name: value for name, (value, _) in HIDDEN.items()}
    return Lathe(draw_drawing(np.random.default_rng(3)), numbers, finer)


def test_it_shares_nothing_with_the_model_under_test() -> None:
    folder = Path(benchmarks.gap.lathe.__file__).parent
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            foreign = {"plant_model", "scenarios", "fmu_compensator"}
            assert not foreign & {name.split(".")[0] for name in names}, path.name


def test_its_catalogue_is_of_the_products() -> None:
    assert set(catalogue()) < set(products_catalogue())
    assert set(BEYOND) < set(catalogue())
    assert len(OUTSIDE) >= 3


def test_conduction_keeps_heat() -> None:
    of = lathe()
    for group, matrix in of.matrices.items():
        assert np.abs(np.asarray(matrix.sum(axis=1)).ravel() + of.to_hall[group]).max() < 1e-9
        assert abs(matrix - matrix.T).max() < 1e-12


def test_the_heat_put_in_is_the_heat_that_leaves() -> None:
    of, speed, feed = lathe(), 3000.0, 5000.0
    end = March(of).settle(still(600.0, speed, feed=feed), np.full(len(of.capacity), 20.0), 1800.0)
    put_in = sum(float(q.sum()) for q in of.friction(speed)) + of.p["motor"] * 3.0
    put_in += 5.0 * sum(of.p[f"{a}_{p}_loss"] for a in "xz" for p in ("nut", "screw", "motor"))
    _, hall = of.conductance(speed, {})
    assert put_in > 300.0
    assert float(hall @ (end - 20.0)) == pytest.approx(put_in, rel=1e-4)


def test_readings_converge_with_the_stretches() -> None:
    found = []
    for finer in (0.5, 1.0, 3.0):
        of = lathe(finer)
        drive = still(3.0, 3000.0, rows=4, feed=4000.0)
        temperatures = March(of).run(drive, np.full(len(of.capacity), 20.0))
        pose = (temperatures - temperatures[0]) @ of.pose_weights
        shown = of.readings(temperatures, pose)
        found.append(np.array([shown[name][-1] for name in sorted(shown)]))
    coarse, fine = np.abs(found[0] - found[2]), np.abs(found[1] - found[2])
    assert fine.max() < 0.4  # K and um, of 20 K and 40 um
    assert fine.mean() < coarse.mean()


def test_magnitudes_are_those_of_the_machine_class() -> None:
    of = lathe()
    drive = still(6.0, 3000.0, rows=4, feed=4000.0)
    temperatures = March(of).run(drive, np.full(len(of.capacity), 20.0))
    pose = (temperatures - temperatures[0]) @ of.pose_weights
    shown = {name: values[-1] for name, values in of.readings(temperatures, pose).items()}
    assert 26.0 < shown["front_degC"] < 50.0
    assert 24.0 < shown["z_nut_degC"] < 55.0
    assert 20.0 < shown["bed_right_degC"] < 30.0
    assert 5.0 < abs(shown["disp_x_um"]) < 100.0
    assert 5.0 < abs(shown["disp_z_um"]) < 100.0


@cache
def run_of(name: str = "", size: float | str = 0.0) -> pd.DataFrame:
    """One held-out run; every effect shows in it."""
    channel = "front" if name and everything()[name].channels else ""
    hidden = ((name, size, channel),) if name else ()
    return simulate_case(TruthCase(11, hidden, runs=("holdout",)))[0][0].exact


@pytest.mark.parametrize("name", sorted(everything()))
def test_off_changes_nothing_and_more_changes_more(name: str) -> None:
    known: type[Hidden] = everything()[name]
    assert 0.0 < known.sizes[0] < known.sizes[1] < known.sizes[2]
    assert make_from(everything(), name, 0.0, np.random.default_rng(0)).size == 0.0
    empty = run_of()
    pd.testing.assert_frame_equal(empty, run_of(name, 0.0), check_exact=True)
    weak, strong = (
        np.abs((run_of(name, size) - empty).to_numpy()) for size in (SIZES[0], SIZES[2])
    )
    assert np.isfinite(strong).all()
    assert strong.max() > 0.3
    assert 0.0 < weak.mean() < strong.mean()


def test_its_runs_have_the_columns_that_the_owners_file_names() -> None:
    (run,), _ = simulate_case(TruthCase(7, runs=("run_2",)))
    assert tuple(run.frame.columns) == SHOP.columns
    assert run.frame["speed_rpm"].max() <= TOP_SPEED
    machine = machine_from_table(tomlkit.parse(owners_file(TruthCase(7))).unwrap(), "machine.toml")
    assert {entry.column for entry in machine.inputs} < set(run.frame.columns)
    assert {f"{sensor.name}_degC" for sensor in machine.sensors} < set(run.frame.columns)


@pytest.mark.parametrize("name", MISTAKES)
def test_every_mistake_is_of_a_kind_and_at_a_place_that_the_lathe_has(name: str) -> None:
    mistake = MISTAKES[name]
    told, right = (
        machine_from_table(tomlkit.parse(owners_file(case)).unwrap(), "machine.toml")
        for case in (TruthCase(4, mistake=name), TruthCase(4))
    )
    assert (told == right) == (mistake.edit is None)
    assert mistake.kind in kinds()
    known = {node.name for node in told.nodes} | {entry.name for entry in told.inputs}
    known |= {sensor.name for sensor in told.sensors} | {"X", "Z"}
    assert set(mistake.place) <= known
