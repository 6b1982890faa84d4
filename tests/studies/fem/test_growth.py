"""Thermo-elastic growth against what is known in closed form."""

import numpy as np
import pytest

from studies.finite_elements import Description, FiniteElementSpindle
from tests.studies.fem.conftest import STEEL, bar_table


def test_patch_free_expansion_is_free_of_stress(bar):
    """Held along the axis only, a body warmed evenly grows alpha r outwards and alpha z along."""
    model = bar.growth_model
    moved = model.displaced(np.full(bar.heat.basis.N, 10.0))
    basis = model.displacement
    r, z = basis.doflocs
    axial = np.concatenate(
        [dofs[1::2].ravel() for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs)]
    )
    radial = np.setdiff1d(np.arange(basis.N), axial)
    assert moved[axial] == pytest.approx(11.5e-5 * z[axial], abs=1e-12)
    assert moved[radial] == pytest.approx(11.5e-5 * r[radial], abs=1e-12)
    force = model.stiffness @ moved - model.load @ np.full(bar.heat.basis.N, 10.0)
    assert np.abs(force).max() < 1e-3 * np.abs(model.load @ np.full(bar.heat.basis.N, 10.0)).max()


def test_a_bar_with_a_gradient_along_it_grows_by_its_mean(bar):
    """A linear temperature along the axis bends nothing; the ends' mean counts."""
    rise = 0.05 * bar.heat.nodes_mm[1]  # 0 to 10 K
    assert bar.growth_row @ rise == pytest.approx(11.5e-6 * 200e3 * 5.0, rel=2e-3)


def test_the_row_of_influence_is_the_solution(jig_borer):
    """The adjoint answer equals solving for the displacement itself."""
    rise = jig_borer.steady(9000.0) - 20.0
    model = jig_borer.growth_model
    nose = model.displaced(rise)[model.nose].mean() * 1e6
    assert jig_borer.growth_row @ rise == pytest.approx(nose, rel=1e-9)


def test_two_bars_side_by_side_grow_together():
    """A stiff warm tube and a stiff cold one: alpha (E1 A1 dT1 + E2 A2 dT2) / (E1 A1 + E2 A2).

    Poisson's ratio is zero and the bar long, so that the law of mixtures holds but at the end.
    """
    plain = STEEL | {"poisson": 0.0}
    table = bar_table(
        materials={"steel": plain, "soft": plain | {"modulus": 70.0}},
        element_mm=20.0,
        mount={"z": 0.0, "r": [20.0, 40.0]},
        nose={"z": 2000.0, "r": [20.0, 40.0]},
        parts=[
            {"name": "bar", "material": "steel", "r": [20.0, 30.0], "z": [0.0, 2000.0]},
            {"name": "tube", "material": "soft", "r": [30.0, 40.0], "z": [0.0, 2000.0]},
        ],
    )
    table["surfaces"][0]["z"] = [0.0, 2000.0]
    spindle = FiniteElementSpindle(Description.model_validate(table))
    model, places = spindle.growth_model, spindle.heat.nodes_mm
    # Warm by the radius, so that no jump of temperature lies inside an element.
    rise = (places[0] - 20.0) / 2.0
    r = np.linspace(20.0, 40.0, 20001)
    stiff = np.where(r < 30.0, 210.0, 70.0) * r
    mean = np.trapezoid(stiff * (r - 20.0) / 2.0, r) / np.trapezoid(stiff, r)
    middle = model.displaced(rise)
    basis = model.displacement
    # Far from the ends every plane stays plane: the growth from 800 to 1200 mm.
    found = []
    for height in (800.0, 1200.0):
        on = np.isclose(basis.doflocs[1] * 1e3, height)
        axial = np.zeros(basis.N, dtype=bool)
        axial[basis.nodal_dofs[1::2].ravel()] = True
        found.append(middle[on & axial].mean())
    assert (found[1] - found[0]) * 1e6 == pytest.approx(11.5e-6 * 400e3 * mean, rel=5e-3)


def test_a_bar_grows_by_alpha_l_dt(bar):
    assert bar.growth_row.sum() == pytest.approx(11.5e-6 * 200e3, rel=1e-9)
