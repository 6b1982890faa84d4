"""The second truth: heat is kept, elements converge, its owner's page is of the same machine."""

from __future__ import annotations

import ast
from functools import cache
from math import pi
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tomlkit

import benchmarks.gap.belt
from benchmarks.gap import enclosed
from benchmarks.gap.belt.case import COLUMNS, owners_page, simulate_case
from benchmarks.gap.belt.drive import FAMILIES, Drive, make_drive
from benchmarks.gap.belt.effects import BEYOND, OUTSIDE, catalogue, everything
from benchmarks.gap.belt.laws import gap_film, turning_film, turning_share, walther
from benchmarks.gap.belt.machine import POSE, TOP_SPEED, Machine
from benchmarks.gap.belt.march import March
from benchmarks.gap.belt.mesh import revolve
from benchmarks.gap.belt.numbers import HIDDEN, Stretch, draw_drawing
from benchmarks.gap.belt.owner import MISTAKES, page_of
from benchmarks.gap.enclosed import Hidden
from benchmarks.gap.truth.case import RUNS, TruthCase
from benchmarks.gap.truth.effects import make_from
from benchmarks.gap.truth.effects.base import SIZES
from gap_finder.kinds import kinds
from measurement.runs import read_run, write_run
from plant_model.drawing.expand import expanded
from plant_model.effects import catalogue as products_catalogue
from plant_model.machine_file import machine_from_table

OTHERS = {
    "benchmarks.gap.enclosed",
    "benchmarks.gap.truth.case",
    "benchmarks.gap.truth.drive",
    "benchmarks.gap.truth.effects",
    "benchmarks.gap.truth.effects.base",
    "studies.finite_elements",
}
"""From elsewhere: what the lathe shares, the form of a case, walks, weak forms. No plant's laws."""


@cache
def machine(finer: float = 1.0) -> Machine:
    """The middle of the class."""
    numbers = {name: value for name, (value, _) in HIDDEN.items()}
    return Machine(draw_drawing(np.random.default_rng(3)), numbers, finer)


def still(hours: float, speed: float = 0.0, rows: int = 121, feed: float = 0.0) -> Drive:
    """A drive at one speed and feed, the hall at 20 degC and undisturbed."""
    time_s = np.linspace(0.0, 3600.0 * hours, rows)
    outside = np.column_stack([np.full(rows, 20.0), np.zeros((rows, 2))])
    held = [np.full(rows, value) for value in (speed, feed, 0.0)]
    return Drive("test", time_s, *held, time_s, outside)


def at_20(of: Machine) -> np.ndarray:
    return np.full(len(of.capacity), 20.0)


def test_it_shares_nothing_with_the_model_under_test() -> None:
    folder = Path(benchmarks.gap.belt.__file__).parent
    for path in (*folder.rglob("*.py"), Path(enclosed.__file__)):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names += [f"{node.module}.{a.name}" for a in node.names]
            for name in names:
                if name.split(".")[0] in {"benchmarks", "fmu_compensator"}:
                    assert name.startswith(("benchmarks.gap.belt", *OTHERS)), name
                assert name.split(".")[0] not in {"plant_model", "scenarios"}, path.name


def test_its_catalogue_is_of_the_products() -> None:
    assert set(catalogue()) < set(products_catalogue())
    assert set(BEYOND) < set(catalogue())
    assert len(OUTSIDE) >= 4
    for name, size in BEYOND.items():
        assert size > 2.0 * catalogue()[name].sizes[2]


def test_a_body_has_the_volume_and_the_surface_of_its_drawing() -> None:
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


def test_heat_through_a_wall_follows_the_logarithm() -> None:
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


def test_conduction_keeps_heat() -> None:
    of = machine()
    for group, matrix in of.matrices.items():
        assert np.abs(np.asarray(matrix.sum(axis=1)).ravel() + of.to_hall[group]).max() < 1e-9
        assert abs(matrix - matrix.T).max() < 1e-12


def test_the_heat_put_in_is_the_heat_that_leaves() -> None:
    of, speed = machine(0.5), 5000.0
    end = March(of).settle(still(400.0, speed, feed=4000.0), at_20(of), 1800.0)
    put_in = sum(float(q.sum()) for q in of.friction(speed)) + of.p["belt"] * 5.0
    put_in += of.p["feed"] * 4.0
    _, hall = of.conductance(speed, {})
    assert put_in > 200.0
    assert float(hall @ (end - 20.0)) == pytest.approx(put_in, rel=1e-4)


def test_time_steps_converge_with_second_order() -> None:
    of = machine(0.5)
    hidden = [make_from(everything(), "viscosity_temperature", 0.03, np.random.default_rng(0))]
    drive = still(1.0, 7000.0, rows=7)
    runs = [March(of, hidden, refine=k).run(drive, at_20(of)) for k in (1, 2, 4, 16)]
    errors = [np.abs(one[-1] - runs[-1][-1]).max() for one in runs[:3]]
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.4)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.4)


def test_readings_converge_with_the_elements() -> None:
    found = []
    for finer in (0.4, 1.0, 2.5):
        of = machine(finer)
        temperatures = March(of).run(still(3.0, 6000.0, rows=4), at_20(of))
        pose = (temperatures - temperatures[0]) @ of.pose_weights
        shown = of.readings(temperatures, pose)
        found.append(np.array([shown[name][-1] for name in sorted(shown)]))
    coarse, fine = np.abs(found[0] - found[2]), np.abs(found[1] - found[2])
    assert fine.max() < 0.35  # K and um, of 20 K and 50 um
    assert fine.mean() < coarse.mean()


def test_magnitudes_are_those_of_the_machine_class() -> None:
    of = machine()
    temperatures = March(of).run(still(6.0, 6000.0, rows=4), at_20(of))
    pose = (temperatures - temperatures[0]) @ of.pose_weights
    shown = {name: values[-1] for name, values in of.readings(temperatures, pose).items()}
    assert 32.0 < shown["front_degC"] < 60.0
    assert shown["front_degC"] > shown["headstock_degC"] > shown["column_top_degC"] > 20.0
    assert -70.0 < shown["disp_z_um"] < -15.0
    assert 15.0 < shown["disp_y_um"] < 120.0


def test_laws() -> None:
    films = [gap_film(n, 0.0275, 0.012) for n in (0.0, 2e3, 4e3, 8e3)]
    assert films[0] == pytest.approx(0.0262 / 0.012 + 4.5)
    assert np.all(np.diff(films) > 0.0)
    assert turning_film(0.1, 2e3) / turning_film(0.1, 8e3) == pytest.approx(turning_share(0.25))
    assert walther(22.0, 4.3, 40.0) == pytest.approx(22.0)
    assert walther(22.0, 4.3, 100.0) == pytest.approx(4.3)


@cache
def run_of(name: str = "", size: float | str = 0.0) -> pd.DataFrame:
    """Four hours with everything that an effect may need, as sensors without noise show it."""
    of = machine(0.4)
    drive = make_drive(
        "shifts", np.random.default_rng(5), 60.0, {"mean": 22.0, "swing": 2.0}, before=0.0
    )
    rows = slice(0, 241)
    held = [values[rows] for values in (drive.time_s, drive.speed, drive.feed, drive.torque)]
    drive = Drive("test", *held, drive.grid_s, drive.outside)
    known: dict[str, type[Hidden]] = dict(everything())
    channel = "front" if name and known[name].channels else None
    effects = [make_from(known, name, size, np.random.default_rng(1), channel)] if name else []
    temperatures = March(of, effects).run(drive, np.full(len(of.capacity), 21.0))
    pose = (temperatures - temperatures[0]) @ of.pose_weights
    for effect in effects:
        effect.move(of, drive, temperatures, pose)
    shown = pd.DataFrame(of.readings(temperatures, pose))
    for effect in effects:
        effect.record(4, of, drive, shown)
    assert pose.shape[1] == len(POSE)
    return shown


@pytest.mark.parametrize("name", sorted(everything()))
def test_off_changes_nothing_and_more_changes_more(name: str) -> None:
    sizes = everything()[name].sizes
    assert 0.0 < sizes[0] < sizes[1] < sizes[2]
    empty = run_of()
    pd.testing.assert_frame_equal(empty, run_of(name, 0.0), check_exact=True)
    weak, strong = (
        np.abs((run_of(name, size) - empty).to_numpy()) for size in (SIZES[0], SIZES[2])
    )
    assert np.isfinite(strong).all()
    assert strong.max() > 0.3
    assert 0.0 < weak.mean() < strong.mean()


def test_the_same_seed_gives_the_same_case_as_run_files(tmp_path: Path) -> None:
    case = TruthCase(5, (("windage", "medium", ""),), resolution=0.4, runs=RUNS[:2])
    first, again = (simulate_case(case)[0] for _ in range(2))
    other = simulate_case(TruthCase(6, case.hidden, resolution=0.4, runs=RUNS[:2]))[0]
    for one, same, different in zip(first, again, other, strict=True):
        pd.testing.assert_frame_equal(one.frame, same.frame, check_exact=True)
        assert not one.frame["front_degC"].head(50).equals(different.frame["front_degC"].head(50))
        found = read_run(write_run(one.frame, tmp_path / f"{one.name}.csv"))
        assert tuple(found.frame.columns) == COLUMNS
        assert 4.9 * 3600 < found.time_s[-1] < 8.1 * 3600
        assert found.frame["speed_rpm"].max() <= TOP_SPEED


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_turns_the_spindle(family: str) -> None:
    hall = {"mean": 21.0, "swing": 1.0}
    drive = make_drive(family, np.random.default_rng(2), 30.0, hall, before=1.0)
    assert drive.speed.max() > 1000.0
    assert len(drive.segments()) >= 2
    assert drive.grid_s[0] == -3600.0


def test_a_careless_owner_knows_lengths_and_guesses_masses() -> None:
    drawing = draw_drawing(np.random.default_rng(8))
    exact, guessed = page_of(drawing), page_of(drawing, np.random.default_rng(9))
    for key in exact.keys() - {"carriers", "enclosure"}:
        assert exact[key] == guessed[key]
    off = [
        b["mass"] / a["mass"] - 1.0
        for a, b in zip(exact["carriers"], guessed["carriers"], strict=True)
    ]
    assert 0.01 < max(np.abs(off)) < 0.17


@pytest.mark.parametrize("name", MISTAKES)
def test_every_mistake_is_of_a_kind_and_at_a_place_that_the_machine_has(name: str) -> None:
    mistake = MISTAKES[name]
    case = TruthCase(4, mistake=name)
    page = tomlkit.parse(owners_page(case)).unwrap()
    whole = tomlkit.parse(owners_page(TruthCase(4))).unwrap()
    assert (page == whole) == (mistake.edit is None)
    assert mistake.kind in kinds()
    for one in (page, whole):
        one["cells"] = {"longest": 120.0, "sectors": 4}
    told, right = (machine_from_table(expanded(one, "page"), "page") for one in (page, whole))
    known = {node.name for node in told.nodes} | {entry.name for entry in told.inputs}
    known |= {sensor.name for sensor in told.sensors} | {"X", "Y", "Z"}
    assert set(mistake.place) <= known
    if mistake.edit is not None:
        assert right != told
