"""What may be wrong anyway, beside what calibration moves."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from gap_finder.design import BESIDE, passing, sensitivities_of
from gap_finder.kinds import CalibratedRun
from gap_finder.kinds.heat_path import HeatPath
from gap_finder.linearise import modelled, simulate_at
from gap_finder.observations import observe
from gap_finder.priors import Priors
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from tests.gap_finder.conftest import runs_of


def test_what_passes_a_part_is_what_is_left_of_it_without_its_mass() -> None:
    machine = read_machine("lathe")
    index = machine.node_index
    matrix = np.zeros((len(index), len(index)))
    for item in machine.of_kind("links", "conduction", "contact"):
        i, j = (index[name] for name in item.refs["between"])
        g = machine.parameters[f"links.{item.name}.conductance"].value
        matrix[[i, j], [i, j]] += g
        matrix[[i, j], [j, i]] -= g
    # A part without mass is eliminated: Schur's complement.
    joined = np.flatnonzero(np.diag(matrix))
    without = sum(np.outer(matrix[:, k], matrix[k]) / matrix[k, k] for k in joined)
    told = passing(machine)
    for one, other in combinations(sorted(index), 2):
        i, j = index[one], index[other]
        direct = sum(matrix[i, k] * matrix[k, j] / matrix[k, k] for k in (i, j) if matrix[k, k])
        expected = without[i, j] - direct
        assert told.get((one, other), 0.0) == pytest.approx(expected, abs=1e-9)


def test_heat_that_passes_a_part_is_no_news(jig_borer_lumps: Machine) -> None:
    (observed,) = observe(jig_borer_lumps, runs_of(jig_borer_lumps, every_s=120.0)[:1])
    known = sensitivities_of(
        jig_borer_lumps, observed, Priors.of(jig_borer_lumps, calibrated=False)
    )
    run = CalibratedRun(jig_borer_lumps, observed, known)
    amounts = passing(jig_borer_lumps)
    paths = {one.place: one for one in HeatPath.all_of([run])}
    place, most = max(
        ((pair, g) for pair, g in amounts.items() if pair in paths), key=lambda entry: entry[1]
    )
    machine = paths[place].put_into(jig_borer_lumps, {"conductance": BESIDE * most})
    base, shown = (modelled(simulate_at(m, observed), observed) for m in (jig_borer_lumps, machine))
    change = ((shown - base) * observed.weights).ravel()
    away = np.linalg.norm(known.other - change[:, None], axis=0)
    assert away.min() < 0.05 * np.linalg.norm(change)
