"""Multiple linear regression."""

from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.error_models.mlr import MultipleLinearRegression
from fmu_compensator.fit.training import TrainingRun, row_weights
from tests.refusing import refusal


def task_of(
    inputs: Any, targets: Any, form: str = "absolute", time_s: Any = None, names: str = "ABCD"
) -> Task:
    x, y = np.asarray(inputs, float), np.asarray(targets, float)
    time = np.arange(float(len(x))) if time_s is None else np.asarray(time_s, float)
    run = TrainingRun("r", time, x, y, np.full(len(x), np.nan), row_weights(time))
    return Task([run], list(names[: x.shape[1]]), ["E", "F"][: y.shape[1]], form)


def inputs_of(rows: int = 60, columns: int = 3, seed: int = 0) -> Any:
    return np.random.default_rng(seed).standard_normal((rows, columns))


def test_the_rise_form_has_no_constant_unless_asked():
    x = inputs_of()
    y = (4.0 + x @ [1.0, 2.0, 3.0])[:, None]
    assert MultipleLinearRegression.fit(task_of(x, y, "rise")).intercept == [0.0]
    asked = MultipleLinearRegression.fit(task_of(x, y, "rise"), intercept=True)
    assert asked.intercept == pytest.approx([4.0])


def test_a_gap_does_not_weigh():
    weights = row_weights(np.array([0.0, 1.0, 2.0, 1000.0, 1001.0, 1002.0]))
    assert weights.tolist() == [0.5, 1.0, 3.0, 3.0, 1.0, 0.5]
    assert row_weights(np.array([5.0])).tolist() == [1.0]


def test_the_best_subset_leaves_out_what_does_not_help():
    x = inputs_of(40, 4, seed=3)
    y = x[:, [1]] * 2.0 + 0.5 * np.random.default_rng(4).standard_normal((40, 1))
    chosen = MultipleLinearRegression.fit(task_of(x, y))
    everything = MultipleLinearRegression.fit(task_of(x, y), subset=False)
    figures, all_figures = (f.report()["targets"]["E"] for f in (chosen, everything))
    assert "B" in figures["inputs"]
    assert len(figures["inputs"]) < 4
    assert figures["r2_adjusted"] > all_figures["r2_adjusted"]
    assert figures["r2"] < all_figures["r2"]
    left_out = [i for i, name in enumerate("ABCD") if name not in figures["inputs"]]
    assert np.all(chosen.coefficients[0, left_out] == 0)


@pytest.mark.parametrize(
    ("inputs", "targets", "told"),
    [
        (inputs_of(9, 2), inputs_of(9, 1), "9 complete rows are too few: 30 are needed"),
        (np.zeros((0, 2)), np.zeros((0, 1)), "0 complete rows are too few"),
        (np.ones((50, 1)), inputs_of(50, 1), "A: is constant"),
        (inputs_of(50, 1), np.full((50, 1), 2.0), "E: never changes"),
        (inputs_of(50, 1)[:, [0, 0]], inputs_of(50, 1), "A, B: determine each other"),
        (inputs_of(50, 3) @ [[1, 0, 1], [0, 1, 2], [0, 0, 0]], inputs_of(50, 1), "A, B, C: det"),
    ],
)
def test_what_cannot_be_fitted_is_refused_in_one_line(inputs, targets, told):
    assert told in refusal(MultipleLinearRegression.fit, task_of(inputs, targets))


@pytest.mark.parametrize("form", ["absolute", "rise"])
def test_it_is_what_statsmodels_and_scikit_learn_find(form):
    from sklearn.linear_model import LinearRegression
    from statsmodels.regression.linear_model import WLS

    x = 20.0 + inputs_of(80, 4, seed=5) @ inputs_of(4, 4, seed=6)
    y = (x @ [1.0, -2.0, 0.5, 3.0] + inputs_of(80, 1, seed=7)[:, 0])[:, None]
    time = np.cumsum(1.0 + np.random.default_rng(8).uniform(0.0, 9.0, 80))
    weights, constant = row_weights(time), form == "absolute"
    fitted = MultipleLinearRegression.fit(task_of(x, y, form, time), subset=False)
    design = np.column_stack([np.ones(80), x]) if constant else x
    known = WLS(y[:, 0], design, weights).fit()
    found = [*([fitted.intercept[0]] if constant else []), *fitted.coefficients[0]]
    assert found == pytest.approx(known.params)
    told = fitted.report()["targets"]["E"]
    assert told["r2"] == pytest.approx(known.rsquared)
    assert told["r2_adjusted"] == pytest.approx(known.rsquared_adj)
    learnt = LinearRegression(fit_intercept=constant).fit(x, y[:, 0], weights)
    assert fitted.coefficients[0] == pytest.approx(learnt.coef_)
    inflation = [
        1.0 / (1.0 - WLS(x[:, k], np.delete(design, k + constant, 1), weights).fit().rsquared)
        for k in range(4)
    ]
    assert list(fitted.report()["variance_inflation"].values()) == pytest.approx(inflation)
