"""What is installed: what the file does at run time is what was fitted and judged."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.gaussian import Gaussian
from fmu_compensator.fit.installed import COVERAGE, DEVIATIONS, Installed
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import parse_model
from measurement.errors import BadInput
from measurement.runs import Run
from tests.fmu_compensator.conftest import DIRECT_RIG
from tests.fmu_compensator.dense import LAGS_S, drawn
from tests.fmu_compensator.test_error_models import KINDS, QUICK, RUNS, direct

SENSORS = [f"T{number}" for number in range(1, 5)]
FREE = {"slew_um_per_s": 1000.0, "offset_um": 1000.0}


NEW = direct("new", 17)


@cache
def installed(kind: str, form: str = "") -> tuple[dict[str, Any], Installed]:
    """Return a compensator with few limits, which is not judged, and what it was made from."""
    fit, made = Installed.fit, []

    def kept(*given: Any) -> Installed:
        made.append(fit(*given))
        return made[-1]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Installed, "fit", kept)
        table = fit_compensator(
            RUNS,
            DIRECT_RIG,
            kind,
            points="T1,T4",
            input_form=form or None,
            limits=FREE,
            judge=False,
            **QUICK.get(kind, {}),
        )
    return table, made[-1]


def fitted(kind: str, form: str = "") -> dict[str, Any]:
    """Return a compensator with few limits, which is not judged."""
    return installed(kind, form)[0]


@pytest.mark.parametrize(
    ("kind", "form"),
    [*((kind, "") for kind in KINDS), ("gaussian", "absolute"), ("gaussian", "level")],
)
def test_the_file_does_what_was_fitted(kind, form):
    table, twin = installed(kind, form)
    recipe = twin.recipe
    [unseen] = prepare([NEW], DIRECT_RIG, recipe.input_form, sensors=SENSORS).runs
    rows, values, width, _ = twin.predict(unseen)
    assert rows.time_s == pytest.approx(NEW.time_s)
    compensator = RunningCompensator(parse_model(compensator_text(table), "file"))
    readings = NEW.frame[[f"{name}_degC" for name in SENSORS]].to_numpy().tolist()
    speeds = NEW.frame["speed_rpm"].tolist()
    steps = np.diff(NEW.time_s, prepend=NEW.time_s[:1]).tolist()
    told = [
        compensator.step(time, step, reading, speed)
        for time, step, reading, speed in zip(
            NEW.time_s.tolist(), steps, readings, speeds, strict=True
        )
    ][1:]  # in no time nothing moves
    assert {one.status for one in told} <= {0, 2}
    found = np.array([[-one.dX, -one.dZ] for one in told])
    assert found == pytest.approx(values[1:], rel=1e-6, abs=1e-6 * np.abs(values).max())
    found = np.array([[one.dX_uncertainty, one.dZ_uncertainty] for one in told])
    # Nine digits of a difference of large numbers: what the weights leave open.
    assert found == pytest.approx(width[1:], rel=1e-3)
    noise = np.array(table["gaussian"]["noise"])
    assert noise @ noise.T == pytest.approx(twin.gaussian.spread, rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "itself"), [("arma", True), ("arx", True), ("mlr", False), ("thermal_states", False)]
)
def test_a_measurement_goes_to_the_error_model_or_to_the_gaussian(kind, itself):
    model = parse_model(compensator_text(fitted(kind)), "file")
    readings = NEW.frame[[f"{name}_degC" for name in SENSORS]].to_numpy().tolist()
    states = []
    for measured in (None, [0.1, -0.1]):
        compensator = RunningCompensator(model)
        for row, reading in enumerate(readings[:10]):
            compensator.step(60.0 * row, 60.0, reading, 0.0, 100.0, measured)
        states.append(compensator.state())
    changed = [states[0][part] != states[1][part] for part in ("error_model", "gaussian")]
    assert changed == [itself, not itself]


def test_the_interval_holds_what_it_promises_of_runs_drawn_from_the_model():
    weights = np.random.default_rng(2).normal(0.0, 1.0, (2 * (1 + len(LAGS_S)), 2))
    random = np.random.default_rng(3)

    def runs(count: int, first: int) -> list[Any]:
        sizes = 1.0 / np.sqrt(random.chisquare(3.0, count) / 3.0)
        return [
            drawn(first + place, weights, walk=10.0, size=size, rows=24)
            for place, size in enumerate(sizes)
        ]

    model = Gaussian.fit(runs(10, 0))
    spread = np.sqrt(np.diag(model.spread))
    inside = []
    for one in runs(100, 100):
        variance = 1.0 + model.walk**2 * one.hours + model.novelty(one.features)
        half = DEVIATIONS * np.sqrt(variance)[:, None] * spread
        inside.append(np.mean(np.abs(model.missed(one)) <= half))
    # A few runs tell the size of the walk within a factor; the interval is rather too wide.
    assert COVERAGE - 0.05 < np.mean(inside) < COVERAGE + 0.08


def with_a_third_missing(run: Run, *names: str) -> Run:
    """Return a run that lacks one of three thermometers in each third and a little beyond."""
    frame, place = run.frame.copy(), np.linspace(0.0, 1.0, len(run.frame))
    for part, name in enumerate(names):
        frame.loc[np.abs(place - (0.5 + part) / 3.0) < 0.2, f"{name}_degC"] = np.nan
    return Run(run.name, frame)


def test_a_run_without_one_complete_row_teaches_nothing():
    lacking = [with_a_third_missing(run, "T1", "T2", "T4") for run in (*RUNS, NEW)]
    points = ["T1", "T2", "T4"]
    table, without = (
        fit_compensator(runs, DIRECT_RIG, points=points, judge=False)
        for runs in ([*RUNS, lacking[-1]], RUNS)
    )
    assert table["gaussian"] == without["gaussian"]
    assert "new: 0 of 121 rows used, the rest lack a temperature" in table["provenance"]["notes"]
    with pytest.raises(BadInput, match="no row has all temperatures and displacements"):
        fit_compensator(lacking[:2], DIRECT_RIG, points=points, judge=False)
