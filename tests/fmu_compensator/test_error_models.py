"""Every error model found: its file runs as it was fitted."""

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.error_models import fitted_models
from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.training import TrainingRun
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from measurement.faults import looked_over
from measurement.runs import Run
from scenarios.fit_details import details_text
from tests.fmu_compensator.conftest import DIRECT_RIG, make_run
from tests.refusing import refusal

CHOSEN = [0, 3]
NAMES = ["T1", "T4"]
KINDS = sorted(error_models())
LEARNING = [kind for kind in KINDS if kind != "gaussian"]
"""Those with something to fit: no mean function has no option, and needs no row."""
# What is tested here does not need a model fitted to the end.
QUICK: dict[str, dict[str, Any]] = {
    "arma": {"order": 1, "step_s": 180.0},
    "bp": {"iterations": 5},
    "fem": {"identify": False},
    "ga_bp": {"population": 8, "generations": 3, "iterations": 5, "hidden": 4},
    "vac": {"models": ["mlr", "ne", "arx"], "combination": "adaptive"},
}


def direct(name: str, seed: int) -> Run:
    """Return a run with two displacements: one more asks a model nothing else."""
    run = make_run(name, seed, hours=2.0)
    frame = run.frame.assign(disp_x_um=run.frame["S1_um"], disp_z_um=-run.frame["S5_um"])
    return Run(name, frame.drop(columns=[f"S{number}_um" for number in range(1, 6)]))


RUNS = looked_over([direct(name, seed) for seed, name in enumerate("abc")])
TARGETS = ("disp_x", "disp_z")


@cache
def runs_of(form: str) -> tuple[Any, ...]:
    return prepare(RUNS, DIRECT_RIG, form).runs


@cache
def task_of(kind: str, form: str) -> Task:
    model = fitted_models()[kind]
    rows = [run.history(CHOSEN) if model.history else run.complete(CHOSEN) for run in runs_of(form)]
    return Task(rows, NAMES, TARGETS, form)


@cache
def fitted(kind: str, form: str) -> FittedModel:
    return fitted_models()[kind].fit(task_of(kind, form), **QUICK.get(kind, {}))


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_fit_reports_can_be_told(kind):
    found = fitted(kind, "rise")
    lines = details_text(kind, TARGETS, found.report())
    assert all(line and "\n" not in line for line in lines)
    assert json.dumps(found.report())


def runtime_of(kind: str, form: str = "rise") -> ErrorModel:
    table = json.loads(json.dumps(fitted(kind, form).table(), allow_nan=False))
    fields = Fields(table, "test")
    model = error_models()[kind].from_fields(fields, len(CHOSEN), len(TARGETS))
    fields.done()
    return model


@cache
def unseen(form: str) -> TrainingRun:
    """A run with a pause, uneven sampling, unknown speed for a while, and every second row."""
    rows = prepare([direct("new", 7)], DIRECT_RIG, form).runs[0].history(CHOSEN)
    kept = np.ones(len(rows.time_s), dtype=bool)
    kept[60:90] = kept[140:200:2] = False
    rows = rows.at(kept)
    rows.speed[20:25] = np.nan
    return rows


def test_each_fitted_model_has_a_twin_in_the_runtime():
    assert set(fitted_models()) == set(error_models())


@pytest.mark.parametrize("given", ["nothing", "now and then"])
@pytest.mark.parametrize("form", ["rise", "absolute", "level"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_runtime_equals_the_fitted_form(kind, form, given):
    run = unseen(form)
    measured = np.full_like(run.targets, np.nan)
    rows = slice(5, None, 17) if given == "now and then" else []
    measured[rows] = run.targets[rows]
    expected = fitted(kind, form).predict(run, None if given == "nothing" else measured)
    runtime = runtime_of(kind, form)
    elapsed = np.diff(run.time_s, prepend=run.time_s[0])
    for k, (row, wanted) in enumerate(zip(run.inputs, expected, strict=True)):
        known = measured[k - 1].tolist() if k and np.isfinite(measured[k - 1]).all() else None
        found = runtime.predict(row.tolist(), float(elapsed[k]), float(run.speed[k]), known)
        assert found == pytest.approx(wanted.tolist(), abs=1e-9, rel=1e-9)
        if k % 40 == 20:  # a host takes the state, loads the FMU again and gives it back
            state = json.loads(json.dumps(runtime.state(), allow_nan=False))
            runtime = runtime_of(kind, form)
            runtime.restore(state)


@pytest.mark.parametrize("kind", KINDS)
def test_a_reset_forgets_everything(kind):
    run, runtime = unseen("rise"), runtime_of(kind)
    fresh = runtime.state()
    steps = np.diff(run.time_s, prepend=run.time_s[0])
    first = [runtime.predict(run.inputs[k].tolist(), steps[k], run.speed[k]) for k in range(30)]
    runtime.reset()
    assert runtime.state() == fresh
    again = [runtime.predict(run.inputs[k].tolist(), steps[k], run.speed[k]) for k in range(30)]
    assert again == first


@pytest.mark.parametrize("kind", KINDS)
def test_a_state_that_is_not_the_models_is_refused(kind):
    runtime = runtime_of(kind)
    state = runtime.state()
    with pytest.raises(ValueError, match="state"):
        runtime.restore([*state, 0.0])
    if state:
        with pytest.raises(ValueError, match="finite"):
            runtime.restore([float("nan"), *state[1:]])


@pytest.mark.parametrize("kind", KINDS)
def test_equal_data_give_equal_numbers(kind):
    again = fitted_models()[kind].fit(task_of(kind, "rise"), **QUICK.get(kind, {}))
    assert json.dumps(again.table()) == json.dumps(fitted(kind, "rise").table())


@pytest.mark.parametrize("kind", LEARNING)
def test_too_few_rows_are_refused_in_one_line(kind):
    task = task_of(kind, "rise")
    rows = task.runs[0].at(np.arange(len(task.runs[0].time_s)) < 4)
    few = Task([rows], NAMES, task.target_names, "rise")
    assert "too few" in refusal(fitted_models()[kind].fit, few)


def read(kind: str, table: dict[str, Any]) -> None:
    fields = Fields(json.loads(json.dumps(table)), "file.json", "error_model")
    error_models()[kind].from_fields(fields, len(CHOSEN), len(TARGETS))
    fields.done()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bad", ["text", None, [], {}, -1e30, True, [[1.0]], float("nan")])
def test_every_field_of_the_file_is_checked(kind, bad):
    table = fitted(kind, "rise").table()
    for key in table:
        # An empty list is right for some fields (no lag, no prior, no outside); nothing else is.
        if bad == [] and key in {"prior", "lags_s", "outside_inputs"}:
            continue
        assert key in refusal(read, kind, {**table, key: bad})


@pytest.mark.parametrize("kind", KINDS)
def test_no_field_may_be_missing_or_unknown(kind):
    table = fitted(kind, "rise").table()
    read(kind, table)
    for key in table:
        assert key in refusal(read, kind, {k: v for k, v in table.items() if k != key})
    assert "turbo" in refusal(read, kind, {**table, "turbo": 1.0})
