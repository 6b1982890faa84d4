"""The belt-driven spindle and the lathe: heat is kept, cells converge, owners know the machine."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pandas as pd
import pytest
import tomlkit

from benchmarks.gap.belt.case import SHOP as BELTS
from benchmarks.gap.belt.laws import gap_film, turning_film, turning_share, walther
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.belt.march import March
from benchmarks.gap.belt.mesh import revolve
from benchmarks.gap.belt.numbers import CLASS as BELTS_CLASS
from benchmarks.gap.belt.numbers import Stretch
from benchmarks.gap.case import Shop, TruthCase
from benchmarks.gap.drive import Drive
from benchmarks.gap.hidden import SIZES, make_from
from benchmarks.gap.lathe.case import SHOP as LATHES
from benchmarks.gap.lathe.machine import Lathe
from benchmarks.gap.lathe.numbers import CLASS as LATHES_CLASS
from gap_finder.kinds import kinds
from measurement.runs import read_run, write_run
from plant_model.drawing.expand import expanded
from plant_model.machine_file import machine_from_table


@dataclass(frozen=True)
class Subject:
    """What the tests know of a simulator: a steady load, and what is right of it."""

    shop: Shop
    build: Callable[..., Any]
    numbers: dict[str, float]
    speed: float
    feed: float
    watts: Callable[[dict[str, float], float, float], float]
    finer: tuple[float, float]
    within: float
    case: TruthCase
    """Everything in it shows in the held-out run."""


def _belts_watts(p: dict[str, float], speed: float, feed: float) -> float:
    return p["belt"] * speed * 1e-3 + p["feed"] * feed * 1e-3


def _lathes_watts(p: dict[str, float], speed: float, feed: float) -> float:
    parts = [p[f"{axis}_{part}_loss"] for axis in "xz" for part in ("nut", "screw", "motor")]
    return p["motor"] * speed * 1e-3 + sum(parts) * feed * 1e-3


SUBJECTS = {
    "belt": Subject(
        BELTS,
        Machine,
        BELTS_CLASS.nominal(),
        6000.0,
        0.0,
        _belts_watts,
        (0.4, 2.5),
        0.35,
        TruthCase(3, resolution=0.4, runs=("holdout",)),
    ),
    "lathe": Subject(
        LATHES,
        Lathe,
        LATHES_CLASS.nominal(),
        3000.0,
        4000.0,
        _lathes_watts,
        (0.5, 3.0),
        0.4,
        TruthCase(11, runs=("holdout",)),
    ),
}
EFFECTS = [(name, effect) for name, one in SUBJECTS.items() for effect in one.shop.effects]
MISTAKES = [(name, mistake) for name, one in SUBJECTS.items() for mistake in one.shop.mistakes]
each = pytest.mark.parametrize("name", SUBJECTS)


@cache
def machine(name: str, finer: float = 1.0) -> Any:
    """The middle of the class."""
    subject = SUBJECTS[name]
    assert subject.shop.drawing is not None
    return subject.build(subject.shop.drawing(np.random.default_rng(3)), subject.numbers, finer)


def still(hours: float, speed: float = 0.0, rows: int = 121, feed: float = 0.0) -> Drive:
    """A drive at one speed and feed, the hall at 20 degC and undisturbed."""
    time_s = np.linspace(0.0, 3600.0 * hours, rows)
    outside = np.column_stack([np.full(rows, 20.0), np.zeros((rows, 2))])
    held = [np.full(rows, value) for value in (speed, feed, 0.0)]
    return Drive("test", time_s, *held, time_s, outside)


def at_20(of: Any) -> np.ndarray:
    return np.full(len(of.capacity), 20.0)


def shown_after(name: str, hours: float, finer: float = 1.0) -> dict[str, float]:
    """Return what sensors show in the end at the steady load."""
    of, subject = machine(name, finer), SUBJECTS[name]
    drive = still(hours, subject.speed, rows=4, feed=subject.feed)
    temperatures = March(of).run(drive, at_20(of))
    pose = (temperatures - temperatures[0]) @ of.pose_weights
    return {key: values[-1] for key, values in of.readings(temperatures, pose).items()}


@each
def test_conduction_keeps_heat(name):
    of = machine(name)
    for group, matrix in of.matrices.items():
        assert np.abs(np.asarray(matrix.sum(axis=1)).ravel() + of.to_hall[group]).max() < 1e-9
        assert abs(matrix - matrix.T).max() < 1e-12


@each
def test_the_heat_put_in_is_the_heat_that_leaves(name):
    of, subject = machine(name, 0.5), SUBJECTS[name]
    speed, feed = subject.speed, 4000.0
    end = March(of).settle(still(600.0, speed, feed=feed), at_20(of), 1800.0)
    put_in = sum(float(q.sum()) for q in of.friction(speed)) + subject.watts(of.p, speed, feed)
    _, hall = of.conductance(speed, {})
    assert put_in > 200.0
    assert float(hall @ (end - 20.0)) == pytest.approx(put_in, rel=1e-4)


@each
def test_readings_converge_with_the_cells(name):
    subject = SUBJECTS[name]
    coarse, usual, fine = (
        np.array(list(shown_after(name, 3.0, finer).values()))
        for finer in (subject.finer[0], 1.0, subject.finer[1])
    )
    assert np.abs(usual - fine).max() < subject.within  # K and um, of 20 K and 50 um
    assert np.abs(usual - fine).mean() < np.abs(coarse - fine).mean()


def test_time_steps_converge_with_second_order():
    of = machine("belt", 0.5)
    known = BELTS.effects
    hidden = [make_from(known, "viscosity_temperature", 0.03, np.random.default_rng(0))]
    drive = still(1.0, 7000.0, rows=7)
    runs = [March(of, hidden, refine=k).run(drive, at_20(of)) for k in (1, 2, 4, 16)]
    errors = [np.abs(one[-1] - runs[-1][-1]).max() for one in runs[:3]]
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.4)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.4)


@cache
def run_of(name: str, effect: str = "", size: float | str = 0.0) -> pd.DataFrame:
    """The held-out run, as sensors without noise show it."""
    subject = SUBJECTS[name]
    channel = "front" if effect and subject.shop.effects[effect].channels else ""
    hidden = ((effect, size, channel),) if effect else ()
    case = replace(subject.case, hidden=hidden)
    return subject.shop.simulate(case)[0][0].exact


@pytest.mark.parametrize(("name", "effect"), EFFECTS)
def test_off_changes_nothing_and_more_changes_more(name, effect):
    sizes = SUBJECTS[name].shop.effects[effect].sizes
    assert 0.0 < sizes[0] < sizes[1] < sizes[2]
    empty = run_of(name)
    pd.testing.assert_frame_equal(empty, run_of(name, effect, 0.0), check_exact=True)
    weak, strong = (
        np.abs((run_of(name, effect, size) - empty).to_numpy()) for size in (SIZES[0], SIZES[2])
    )
    assert np.isfinite(strong).all()
    assert strong.max() > 0.3
    assert 0.0 < weak.mean() < strong.mean()


@each
def test_the_same_seed_gives_the_same_run_files(name, tmp_path):
    shop = SUBJECTS[name].shop
    case = TruthCase(5, (("sensor_drift", "medium", ""),), resolution=0.4, runs=("run_1",))
    (first,), (again,) = (shop.simulate(case)[0] for _ in range(2))
    pd.testing.assert_frame_equal(first.frame, again.frame, check_exact=True)
    (other,), _ = shop.simulate(TruthCase(6, case.hidden, resolution=0.4, runs=case.runs))
    assert not first.frame["front_degC"].head(50).equals(other.frame["front_degC"].head(50))
    found = read_run(write_run(first.frame, tmp_path / "run_1.csv"))
    assert tuple(found.frame.columns) == shop.columns
    assert 4.9 * 3600 < found.time_s[-1] < 8.1 * 3600
    table = tomlkit.parse(shop.owners_file(case)).unwrap()
    told = machine_from_table(expanded(table, "page") if "kind" in table else table, "file")
    assert {entry.column for entry in told.inputs} < set(found.frame.columns)
    assert {f"{sensor.name}_degC" for sensor in told.sensors} < set(found.frame.columns)


@pytest.mark.parametrize(("name", "which"), MISTAKES)
def test_every_mistake_is_of_a_kind_and_at_a_place_that_the_machine_has(name, which):
    shop = SUBJECTS[name].shop
    mistake = shop.mistakes[which]
    assert mistake.kind in kinds()
    machines = []
    for case in (TruthCase(4, mistake=which), TruthCase(4)):
        table = tomlkit.parse(shop.owners_file(case)).unwrap()
        if "kind" in table:
            table = expanded(table | {"cells": {"longest": 120.0, "sectors": 4}}, "page")
        machines.append(machine_from_table(table, "file"))
    told, right = machines
    assert (told == right) == (mistake.edit is None)
    known = {node.name for node in told.nodes} | {entry.name for entry in told.inputs}
    known |= {sensor.name for sensor in told.sensors} | {"X", "Y", "Z"}
    assert set(mistake.place) <= known


def test_a_body_has_the_volume_and_the_surface_of_its_drawing():
    solid = revolve([Stretch(0.0, 100.0, 80.0, 30.0), Stretch(100.0, 150.0, 60.0, 30.0)], [40.0])
    rings = pi / 4.0 * ((80.0**2 - 30.0**2) * 100.0 + (60.0**2 - 30.0**2) * 50.0)
    assert solid.volume.sum() == pytest.approx(rings * 1e-9)
    _, area = solid.surface("outer", 20.0, 130.0)
    assert area.sum() == pytest.approx(pi * (80.0 * 80.0 + 60.0 * 30.0) * 1e-6)
    nodes, area = solid.surface("inner", 20.0, 90.0)
    # Hat functions: the area's middle is where the span's is.
    assert solid.z[nodes] @ area / area.sum() == pytest.approx(55.0)
    assert solid.mean_over(30.0, 140.0).sum() == pytest.approx(110.0)
    assert solid.mean_over(30.0, 90.0) @ solid.z == pytest.approx(60.0 * 60.0)
    assert solid.at(25.0, 33.0) @ np.stack([solid.r, solid.z]).T == pytest.approx([25.0, 33.0])


def test_heat_through_a_wall_follows_the_logarithm():
    tube = revolve([Stretch(0.0, 10.0, 120.0, 60.0)], [], finer=3.0)
    inside, outside = (np.flatnonzero(np.abs(tube.r - r) < 1e-6) for r in (30.0, 60.0))
    held = np.concatenate([inside, outside])
    free = np.setdiff1d(np.arange(len(tube.r)), held)
    matrix = tube.conduction.toarray()
    state = np.zeros(len(tube.r))
    state[inside] = 1.0
    state[free] = np.linalg.solve(matrix[np.ix_(free, free)], -matrix[free] @ state)
    passed = float((matrix @ state)[inside].sum())
    assert passed == pytest.approx(2.0 * pi * 0.01 / np.log(2.0), rel=2e-3)


def test_laws():
    films = [gap_film(n, 0.0275, 0.012) for n in (0.0, 2e3, 4e3, 8e3)]
    assert films[0] == pytest.approx(0.0262 / 0.012 + 4.5)
    assert np.all(np.diff(films) > 0.0)
    assert turning_film(0.1, 2e3) / turning_film(0.1, 8e3) == pytest.approx(turning_share(0.25))
    assert walther(22.0, 4.3, 40.0) == pytest.approx(22.0)
    assert walther(22.0, 4.3, 100.0) == pytest.approx(4.3)
