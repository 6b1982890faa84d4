"""Heat conduction: exact solutions, orders of convergence, balances."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve
from skfem import Basis, ElementQuad1, Functional, LinearForm, MeshQuad, condense

from studies.finite_elements import forms
from studies.finite_elements.films import (
    friction_heat,
    friction_numbers,
    gap_conductivity,
    still_film,
    turning_film,
)


def exact(x: np.ndarray) -> np.ndarray:
    """A temperature on a ring, r from 1 to 2 and z from 0 to 1."""
    return np.sin(2.0 * x[0]) * np.cos(3.0 * x[1])


def manufactured(x: np.ndarray) -> np.ndarray:
    """The heat density that gives it with k = 1: -(T_rr + T_r / r + T_zz)."""
    r, z = x
    return (4.0 + 9.0) * exact(x) - 2.0 * np.cos(2.0 * r) * np.cos(3.0 * z) / r


def error_with(cells: int) -> float:
    mesh = MeshQuad.init_tensor(np.linspace(1, 2, cells + 1), np.linspace(0, 1, cells + 1))
    basis = Basis(mesh, ElementQuad1(), intorder=4)
    matrix = forms.conduction(basis, np.ones(mesh.t.shape[1]))
    load = LinearForm(lambda v, w: 2.0 * np.pi * w.x[0] * manufactured(w.x) * v).assemble(basis)
    solution = exact(basis.doflocs)
    inner, right, solution, kept = condense(matrix, load, x=solution, D=basis.get_dofs().flatten())
    solution[kept] = spsolve(inner.tocsc(), right)
    square = Functional(lambda w: (w["t"] - exact(w.x)) ** 2 * w.x[0])
    return float(np.sqrt(square.assemble(basis, t=solution)))


def test_a_manufactured_solution_is_met_with_second_order():
    errors = [error_with(cells) for cells in (4, 8, 16, 32)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0, 2.0], abs=0.1)
    assert errors[-1] < 1e-3


def test_steady_heat_in_is_heat_out(jig_borer):
    heat = jig_borer.heat
    for speed in (0.0, 6000.0, 20000.0):
        end = jig_borer.steady(speed, ambient=22.0, coolant=19.0)
        groups = heat.groups(speed)
        lost = float((groups["air"][0] @ end - 22.0 * groups["air"][1]).sum())
        lost += float((groups["coolant"][0] @ end - 19.0 * heat.coolant).sum())
        assert lost == pytest.approx(heat.powers(speed).sum(), abs=1e-6)
        assert np.abs(groups["conduction"][0].sum(axis=1)).max() < 1e-9


def test_time_steps_converge_with_second_order(bar):
    time_s = np.array([0.0, 900.0, 1200.0])
    speed = np.array([9000.0, 0.0, 0.0])  # a short stop
    ends = [
        bar.transient(time_s, speed, longest_s=step).temperatures[-1].mean()
        for step in (100.0, 50.0, 25.0, 2.0)
    ]
    errors = np.abs(np.array(ends[:3]) - ends[3])
    assert errors[:-1] / errors[1:] == pytest.approx([4.0, 4.0], rel=0.15)


def test_laws_of_films_and_friction(jig_borer):
    # Re = pi 10,000 / 60 0.08^2 / 16e-6 = 209,440; Nu = 0.133 Re^(2/3) 0.701^(1/3) = 416.7
    assert turning_film(10000.0, 0.08) == pytest.approx(416.7 * 0.026 / 0.08, rel=1e-3)
    assert turning_film(0.0, 0.08) == still_film(0.08)
    assert 7.0 < still_film(0.19) < 12.0
    assert gap_conductivity(0.0, 0.05, 0.7e-3) == pytest.approx(0.026)
    assert gap_conductivity(20000.0, 0.05, 0.7e-3) > 2.0 * 0.026
    front = jig_borer.description.bearings[0]
    # M0 = 1e-7 0.5 (26.6 10,000)^(2/3) 70^3 = 70.93 N mm, M1 = 0.001 250 70 = 17.5 N mm
    numbers = friction_numbers(front)
    assert friction_heat(10000.0, numbers) == pytest.approx(1.047e4 * 1e-4 * 2 * 88.43, rel=1e-3)
    # Below nu n = 2000 the torque does not depend on speed.
    slow = 1.047e-4 * 50.0 * 2 * (160e-7 * 0.5 * 70.0**3 + 17.5)
    assert friction_heat(50.0, numbers) == pytest.approx(slow, rel=1e-6)
    assert friction_heat(-50.0, numbers) == friction_heat(50.0, numbers)


def test_a_bar_cools_with_its_own_time_constant(bar):
    """A small Biot number: T decays with C / (h A)."""
    time_s = np.linspace(0.0, 7200.0, 121)
    hot = np.full(bar.heat.basis.N, 40.0)
    run = bar.transient(time_s, np.zeros(121), start=hot)
    capacity = np.pi * (0.04**2 - 0.02**2) * 0.2 * 7800.0 * 470.0
    rate = still_film(0.08) * np.pi * 0.08 * 0.2 / capacity
    assert run.temperatures.mean(axis=1) == pytest.approx(
        20.0 + 20.0 * np.exp(-rate * time_s), abs=0.05
    )
