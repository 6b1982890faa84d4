"""Intervals against oracles that share no algebra with them.

The quantiles of the posterior, the fall of the cost by the chi-squared quantile, and one dense
least-squares problem without any elimination.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtri, ndtri

from gap_finder.calibrate import ParameterEstimate, _Problem, calibrate, intervals
from gap_finder.design import RunDesign, all_sensitivities, design_of
from gap_finder.observations import Observations, observe
from gap_finder.priors import Priors
from gap_finder.score import fit
from measurement.runs import Run
from plant_model.machine import Machine
from tests.gap_finder.conftest import only_free, runs_of

FREE = "links.front_inner-front_outer.conductance"


def test_an_interval_holds_95_percent_of_the_posterior(jig_borer_lumps):
    priors = Priors.of(jig_borer_lumps, calibrated=True)
    generator = np.random.default_rng(1)
    at = generator.uniform(-0.3, 0.3, len(priors.names))
    spread = generator.uniform(0.02, 0.3, len(priors.names))
    drawn = priors.values(generator.normal(at, spread, (40_000, len(priors.names))))
    for one in intervals(jig_borer_lumps, priors, at, spread):
        inside = (drawn[one.name] >= one.low) & (drawn[one.name] <= one.high)
        assert inside.mean() == pytest.approx(0.95, abs=0.006), one.name
        below = (drawn[one.name] < one.low).mean()
        assert below == pytest.approx(0.025, abs=0.005), one.name


def test_a_number_that_left_its_range_stands_beside_the_range_of_the_file(jig_borer_lumps):
    priors = Priors.of(jig_borer_lumps, calibrated=True)
    at = np.full(len(priors.names), 2.5)
    for one in intervals(jig_borer_lumps, priors, at, 0.1 * at):
        given = jig_borer_lumps.parameters[one.name]
        assert one.range == (given.low, given.high)
        assert one.value != given.value


@pytest.fixture(scope="module")
def runs(jig_borer_lumps: Machine) -> list[Run]:
    stiff = jig_borer_lumps.with_values({FREE: 1.15 * jig_borer_lumps.parameters[FREE].value})
    return runs_of(stiff, 60.0)[:2]


@pytest.fixture(scope="module")
def observed(jig_borer_lumps: Machine, runs: list[Run]) -> list[Observations]:
    return observe(jig_borer_lumps, runs)


def distance(priors: Priors, machine: Machine, told: ParameterEstimate, value: float) -> float:
    """Return how far a value is from where calibration left a parameter, in the fitting scale."""
    place = priors.names.index(told.name)
    end, best = (
        priors.position(machine.with_values({told.name: at}, beyond=True))[place]
        for at in (value, told.value)
    )
    return float(abs(end - best))


def test_at_the_ends_of_an_interval_the_cost_has_risen_by_the_chi_squared_quantile(
    jig_borer_lumps, observed
):
    """With one free parameter: the likelihood ratio knows nothing of any covariance."""
    machine = only_free(jig_borer_lumps, FREE)
    priors = Priors.of(machine, calibrated=True)
    assert priors.names == (FREE,)
    found = calibrate(machine, observed, starts=1)
    (told,) = found.parameters
    assert told.low < told.value < told.high
    problem = _Problem(machine, observed, priors, None)
    best = problem.costs(priors.position(found.machine)[None, :])
    for end in (told.low, told.high):
        position = priors.position(machine.with_values({FREE: end}, beyond=True))
        (risen,) = problem.costs(position[None, :]) - best
        assert risen == pytest.approx(chdtri(1, 0.05), rel=0.2)
        half = distance(priors, machine, told, end)
        assert told.prior_contraction == pytest.approx(1.0 - half / ndtri(0.975), abs=1e-3)


def dense_deviations(designs: Sequence[RunDesign], count: int) -> np.ndarray:
    """Return posterior standard deviations from every unknown of every run side by side.

    Each has its prior, and nothing is eliminated; the first *count* are the shared parameters.
    """
    shared = designs[0].shared.shape[1]
    unknown = shared + sum(design.nuisance.shape[1] for design in designs)
    rows, last = [np.eye(unknown)], shared
    for design in designs:
        block = np.zeros((len(design.residual), unknown))
        block[:, :shared] = design.shared
        block[:, last : last + design.nuisance.shape[1]] = design.nuisance
        last += design.nuisance.shape[1]
        rows.append(block)
    inverse = np.linalg.pinv(np.vstack(rows))
    return np.asarray(np.sqrt((inverse**2).sum(axis=1))[:count])


def test_what_one_run_alone_tells_is_as_certain_as_in_one_dense_problem():
    """A fault that began in the last run has no other run's interval, and not its prior's."""
    generator = np.random.default_rng(4)
    designs = []
    for rows, alone in ((60, ()), (40, (1,))):
        shared, own = generator.normal(size=(rows, 3)), generator.normal(size=(rows, 2))
        own = np.hstack([own, shared[:, list(alone)] + 0.5 * shared[:, [0]]])
        shared[:, 1] = 0.0
        own = own[:, : 2 + len(alone)]
        designs.append(RunDesign(np.zeros(rows), shared, own, np.ones(rows), alone))
    squares = sum(one.shared.T @ one.cleaned(one.shared) for one in designs)
    (found,) = designs[1].deviations_alone(np.linalg.inv(squares + np.eye(3)))
    dense = dense_deviations(designs, 3 + 2 + 3)
    assert found == pytest.approx(dense[-1], rel=1e-9)
    assert found < 0.5


@pytest.mark.parametrize("noise", [0.0, 0.37])
def test_the_intervals_of_an_explanation_are_those_of_one_dense_problem(
    noise, jig_borer_lumps, observed
):
    """Also where more is left than the tolerance explains: all is less certain by as much."""
    machine = only_free(jig_borer_lumps, FREE, "links.rear_inner-rear_outer.conductance")
    generator = np.random.default_rng(5)
    noisy = [
        replace(one, values=generator.normal(one.values, noise * one.tolerance + 1e-12))
        for one in observed
    ]
    sensitivities = all_sensitivities(machine, noisy)
    found = fit(machine, noisy, [machine], sensitivities)
    moved = Priors.of(machine, calibrated=True)
    units = found.calibration.units
    over = float(np.mean(found.left / units))
    assert (over > 1.05) == (noise > 0.0)
    designs = design_of(found.calibration.parts, sensitivities, units)
    expected = dense_deviations(designs, len(moved.names)) * np.sqrt(max(1.0, over))
    expected = np.minimum(expected, 1.0)  # no run makes a parameter less certain than its range
    assert expected.min() < 0.95
    for one, wanted in zip(found.calibration.parameters, expected, strict=True):
        assert one.prior_contraction == pytest.approx(1.0 - wanted, abs=1e-9), one.name
        known = machine.parameters[one.name]
        for end, value in (("low", one.low), ("high", one.high)):
            if value != getattr(known, end):  # an interval ends where the range does
                away = distance(moved, machine, one, value)
                assert away == pytest.approx(ndtri(0.975) * wanted, rel=1e-4), (one.name, end)
