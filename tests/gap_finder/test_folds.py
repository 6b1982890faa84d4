"""How a fold's derivatives follow what it sees on its way."""

import numpy as np
import pytest

from gap_finder.design import RunDesign
from gap_finder.score import _Folds

MOVED, UNKNOWNS, SAMPLES, OWN = 3, 5, 12, 2


@pytest.fixture
def folds() -> _Folds:
    random = np.random.default_rng(3)
    designs = [
        RunDesign(
            random.normal(size=SAMPLES),
            random.normal(size=(SAMPLES, UNKNOWNS)),
            random.normal(size=(SAMPLES, OWN)),
            np.ones(SAMPLES),
        )
        for _ in range(3)
    ]
    return _Folds(None, (), None, np.zeros(MOVED), designs)  # type: ignore[arg-type]


def test_derivatives_say_along_a_step_what_was_seen_and_elsewhere_what_they_said(folds):
    random = np.random.default_rng(4)
    fold = folds._folds()[0]
    derivatives = [design.shared for design in folds._designs]
    for _ in range(2):
        step = random.normal(size=UNKNOWNS)
        answers = [random.normal(size=SAMPLES) for _ in derivatives]
        folds._turn(fold, step, [r + dr for r, dr in zip(fold.shown, answers, strict=True)])
        moved = np.where(np.arange(UNKNOWNS) < MOVED, step, 0.0)
        derivatives = [
            j + np.outer(dr - j @ step, moved) / (moved @ moved)
            for j, dr in zip(derivatives, answers, strict=True)
        ]
        for j, dr in zip(derivatives, answers, strict=True):
            assert j @ step == pytest.approx(dr)
    kept = list(zip(folds._designs, derivatives, strict=True))[1:]
    normal = sum(j.T @ design.cleaned(j) for design, j in kept) + np.eye(UNKNOWNS)
    assert fold.matrix == pytest.approx(normal)
    r = [random.normal(size=SAMPLES) for _ in derivatives]
    slope = sum(j.T @ design.cleaned(r[1 + i][:, None])[:, 0] for i, (design, j) in enumerate(kept))
    assert folds._slope(fold, r) == pytest.approx(slope)
