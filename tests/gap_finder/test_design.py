"""What may be wrong anyway, beside what calibration moves."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.added_paths import AddedPath, path_answers
from gap_finder.design import PASSING_SHARE, RunSensitivities, design_of, passing_paths
from gap_finder.linearise import Linearisation
from gap_finder.observations import observe
from plant_model.machine_file import read_machine
from tests.gap_finder.conftest import runs_of


def test_what_passes_a_slow_part_is_half_of_what_is_left_of_it_without_its_mass():
    machine = read_machine("lathe")
    slow = [replace(n, capacity=replace(n.capacity, value=1e12, high=1e13)) for n in machine.nodes]
    names = [node.name for node in slow]
    matrix = np.zeros((len(slow), len(slow)))
    for item in machine.of_kind("links", "conduction", "contact"):
        i, j = (names.index(name) for name in item.refs["between"])
        g = machine.parameters[f"links.{item.name}.conductance"].value
        matrix[[i, j], [i, j]] += g
        matrix[[i, j], [j, i]] -= g
    paths = passing_paths(replace(machine, nodes=tuple(slow)))
    counted = 0
    for k in range(len(slow)):
        around = sorted(names[i] for i in np.flatnonzero(matrix[:, k]) if i != k)
        for part in around[: 1 if len(around) == 2 else None] if len(around) > 1 else []:
            others = [name for name in around if name != part]
            # A part without mass is eliminated: Schur's complement.
            row = np.outer(matrix[:, k], matrix[k])[names.index(part)] / matrix[k, k]
            expected = [PASSING_SHARE * row[names.index(name)] for name in others]
            passed = [
                np.multiply(path.shares, path.sizes[0])
                for path in paths
                if path.between == (part, *others)
            ]
            assert any(given == pytest.approx(expected) for given in passed)
            counted += 1
    assert counted == len(paths)


def test_a_quick_part_has_one_temperature():
    machine = read_machine("lathe")
    quick = [replace(n, capacity=replace(n.capacity, value=1.0, low=0.5)) for n in machine.nodes]
    assert passing_paths(replace(machine, nodes=tuple(quick))) == []


def test_heat_is_shared_among_several_as_by_a_path_to_each(jig_borer_lumps):
    machine = jig_borer_lumps
    (observed,) = observe(machine, runs_of(machine, every_s=120.0)[:1])
    part, near, far = passing_paths(machine)[0].between[:3]
    size = 1e-4  # [W/K], so small that no path changes what drives it
    shared = AddedPath((part, near, far), (size,), shares=(0.25, 0.75))
    pairs = [AddedPath(pair, (size,)) for pair in ((part, near), (part, far), (near, far))]
    ((together,),) = path_answers(machine, observed, [shared])
    (to_near,), (to_far,), (across,) = path_answers(machine, observed, pairs)
    # The answer is a square in the direction that heat is moved in, and that drives it.
    crossed = to_near + to_far - across
    expected = 0.25**2 * to_near + 0.75**2 * to_far + 0.25 * 0.75 * crossed
    assert together == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


def test_what_acts_in_one_run_alone_is_that_runs_own():
    generator = np.random.default_rng(0)
    parts, known = [], []
    for run in range(3):
        answer = generator.normal(size=(8, 2))
        answer[:, 1] *= 1.0 if run == 1 else 1e-12  # Rounding: nothing drives it in the others.
        parts.append(
            Linearisation(
                generator.normal(size=8),
                answer,
                np.zeros((8, 0)),
                np.zeros((answer.shape[1], 8, 0)),
            )
        )
        none, one = np.zeros((8, 1)), np.ones(8)
        known.append(RunSensitivities(none, none, none, one))
    designs = design_of(parts, known, np.ones(1))
    assert [design.alone for design in designs] == [(), (1,), ()]
    assert not designs[1].shared[:, 1].any()
    assert np.array_equal(designs[1].nuisance[:, -1], parts[1].by_parameter[:, 1])
    assert np.array_equal(designs[1].shared[:, 0], parts[1].by_parameter[:, 0])
