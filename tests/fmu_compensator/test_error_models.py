"""Every error model found: its file runs as it was fitted."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.error_models import fitted_models
from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.fields import Fields
from tests.fmu_compensator.conftest import RIG, make_run

CHOSEN = [0, 3]


def test_each_fitted_model_has_a_twin_in_the_runtime() -> None:
    assert "mlr" in fitted_models()
    assert set(fitted_models()) <= set(error_models())


@pytest.mark.parametrize("input_form", ["rise", "absolute"])
@pytest.mark.parametrize("kind", sorted(fitted_models()))
def test_the_runtime_equals_the_fitted_form(kind: str, input_form: str) -> None:
    prepared = prepare([make_run("a", 1), make_run("b", 2)], RIG, input_form)
    rows = [run.complete(CHOSEN) for run in prepared.runs]
    fitted = fitted_models()[kind].fit(Task(rows, ["T1", "T4"], prepared.targets, input_form))
    table = json.loads(json.dumps(fitted.table()))
    fields = Fields(table, "test")
    runtime = error_models()[kind].from_fields(fields, len(CHOSEN), len(prepared.targets))
    fields.done()
    unseen = prepare([make_run("c", 3)], RIG, input_form).runs[0].complete(CHOSEN)
    expected = fitted.predict(unseen)
    elapsed = np.diff(unseen.time_s, prepend=unseen.time_s[0])
    states = []
    for row, step, speed, wanted in zip(
        unseen.inputs, elapsed, unseen.speed, expected, strict=True
    ):
        # A state goes through JSON before every step, as a host may do it.
        runtime.restore(json.loads(json.dumps(states[-1] if states else runtime.state())))
        found = runtime.predict(row.tolist(), float(step), float(speed))
        states.append(runtime.state())
        assert found == pytest.approx(wanted.tolist(), abs=1e-9)
    runtime.reset()
    again = runtime.predict(unseen.inputs[0].tolist(), 0.0, float(unseen.speed[0]))
    assert again == pytest.approx(expected[0].tolist(), abs=1e-9)
    assert json.dumps(fitted.report(), allow_nan=False)


@pytest.mark.parametrize("kind", sorted(error_models()))
def test_a_state_that_is_not_the_models_is_refused(kind: str) -> None:
    prepared = prepare([make_run("a", 1)], RIG)
    rows = [run.complete(CHOSEN) for run in prepared.runs]
    fitted = fitted_models()[kind].fit(Task(rows, ["T1", "T4"], prepared.targets, "rise"))
    runtime = error_models()[kind].from_fields(
        Fields(fitted.table(), "test"), len(CHOSEN), len(prepared.targets)
    )
    with pytest.raises(ValueError, match="state"):
        runtime.restore([*runtime.state(), 0.0])
