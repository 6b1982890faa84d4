"""Score and screening against dense least-squares problems that eliminate nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gap_finder.design import RunDesign
from gap_finder.leave_one_out import LeaveOneOut
from gap_finder.proposals import Screen

RUNS, CHANNELS, MOVED, OTHER, OWN = 4, 3, 2, 3, 2
X = np.array([0.4, -0.3])
EVERY = list(range(RUNS))


@pytest.fixture(scope="module")
def designs() -> list[RunDesign]:
    generator = np.random.default_rng(3)
    return [
        RunDesign(
            generator.normal(0.0, 2.0, rows * CHANNELS),
            generator.normal(size=(rows * CHANNELS, MOVED + OTHER)),
            generator.normal(size=(rows * CHANNELS, OWN)),
            np.ones(rows * CHANNELS),
        )
        for rows in (20, 25, 30, 22)
    ]


def _solved(
    designs: list[RunDesign], runs: list[int], x: np.ndarray, columns: list[np.ndarray]
) -> np.ndarray:
    """Return the shared unknowns, solved side by side with every run's own.

    *columns* are those of the shared unknowns in every run. The first have a prior at -x, the
    others at 0; those after the shared columns of the designs have none.
    """
    shared = columns[0].shape[1]
    rows, right = [], []
    for place, run in enumerate(runs):
        design = designs[run]
        block = np.zeros((len(design.residual), shared + OWN * len(runs)))
        block[:, :shared] = columns[run]
        block[:, shared + OWN * place : shared + OWN * (place + 1)] = design.nuisance
        rows.append(block)
        right.append(-design.residual)
    prior = np.ones(shared + OWN * len(runs))
    prior[MOVED + OTHER : shared] = 0.0
    rows.append(np.diag(prior))
    right.append(-np.pad(x, (0, len(prior) - len(x))))
    return np.asarray(np.linalg.lstsq(np.vstack(rows), np.concatenate(right))[0][:shared])


def _left(design: RunDesign, missed: np.ndarray) -> float:
    """Return the squares that a run's own unknowns leave."""
    own, padded = np.vstack([design.nuisance, np.eye(OWN)]), np.append(missed, np.zeros(OWN))
    best = np.linalg.lstsq(own, -padded)[0]
    return float(np.sum((padded + own @ best) ** 2))


def _predicted(designs: list[RunDesign], run: int, columns: list[np.ndarray]) -> float:
    """Return what is left of a run that is predicted from the others."""
    unknowns = _solved(designs, [i for i in EVERY if i != run], X, columns)
    return _left(designs[run], designs[run].residual + columns[run] @ unknowns)


def test_a_run_is_predicted_from_the_others_alone(designs):
    left = LeaveOneOut(designs, X).left(CHANNELS)
    assert left.shape == (RUNS, CHANNELS)
    shared = [design.shared for design in designs]
    expected = [_predicted(designs, run, shared) for run in EVERY]
    assert left.sum(axis=1) == pytest.approx(expected, rel=1e-9)


def test_what_calibration_does_not_move_lies_where_all_runs_have_it(designs):
    columns = [design.shared[:, MOVED:] for design in designs]
    found = _solved(designs, EVERY, np.zeros(0), columns)
    assert LeaveOneOut(designs, X).other_position() == pytest.approx(found, rel=1e-9)


def test_a_candidate_is_one_more_unknown_of_all_runs(designs):
    generator = np.random.default_rng(4)
    # As large as what is left, so that its factor is within the limits.
    answers = [generator.normal(size=len(d.residual)) - d.residual for d in designs]
    scores = Screen(LeaveOneOut(designs, X), [SimpleNamespace(answers=answers)], CHANNELS).scores()
    plain = [design.shared for design in designs]
    more = [np.column_stack([design.shared, a]) for design, a in zip(designs, answers, strict=True)]
    with_it = sum(_predicted(designs, run, more) for run in EVERY)
    assert scores.left.shape == (1, CHANNELS)
    assert scores.left.sum() == pytest.approx(with_it, rel=1e-9)
    before, after = (_solved(designs, EVERY, X, columns) for columns in (plain, more))
    assert scores.scale[0] == pytest.approx(after[-1], rel=1e-9)
    moved = np.pad(X, (0, OTHER))
    squares = (moved + before) ** 2 - (moved + after[:-1]) ** 2
    assert scores.position[0] == pytest.approx((moved + after[:-1])[:MOVED], rel=1e-9)
    assert scores.numbers_gain[0] == pytest.approx(squares[:MOVED].sum(), rel=1e-9)
    assert scores.others_gain[0] == pytest.approx(squares[MOVED:].sum(), rel=1e-9)


def test_numbers_that_no_run_depends_on_are_not_determined(designs):
    """The second of the two is; the first is as uncertain as its prior says."""
    without = [np.where(np.arange(MOVED + OTHER) == 0, 0.0, d.shared) for d in designs]
    blind = [replace(d, shared=columns) for d, columns in zip(designs, without, strict=True)]
    assert LeaveOneOut(designs, X).determined() == pytest.approx(2.0, abs=0.05)
    assert LeaveOneOut(blind, X).determined() == pytest.approx(1.0, abs=0.03)
