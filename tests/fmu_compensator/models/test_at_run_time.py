"""Models with a memory inside the compensator, and inside the FMU."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import build_fmu
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import parse_model
from measurement.errors import BadInput
from tests.fmu_compensator.conftest import RIG, make_run
from tests.fmu_packaging.apart import apart

RUNS = [make_run(name, seed, hours=2.0) for seed, name in enumerate("abc")]
DRIFT = [4.0, 1.0, -1.0, 0.5, 0.5]


@pytest.fixture(scope="module")
def text() -> str:
    table = fit_compensator(RUNS, RIG, "thermal_states", lags_s=(1800.0,), penalty=1e-4, walk=0.0)
    return compensator_text(table)


def samples(count: int) -> list[tuple[list[float], float]]:
    frame = make_run("new", 9, hours=1.0, step_s=10.0).frame
    temperatures = frame[["T1_degC", "T2_degC", "T3_degC", "T4_degC"]].to_numpy()[:count]
    return [
        (row.tolist(), float(speed))
        for row, speed in zip(temperatures, frame["speed_rpm"], strict=False)
    ]


def outputs(
    compensator: RunningCompensator,
    first: int,
    count: int,
    probed: int = -1,
    drift: list[float] = DRIFT,
) -> list[Any]:
    found = []
    for k, (temperatures, speed) in enumerate(samples(first + count)):
        if k >= first:
            measured = drift if k == probed else None
            found.append(
                list(compensator.step(10.0 * k, 10.0, temperatures, speed, 120.0, measured))
            )
    return found


def test_a_measurement_counts_from_the_next_sample_on(text: str) -> None:
    plain, probed = (RunningCompensator(parse_model(text, "t")) for _ in range(2))
    free = outputs(plain, 0, 200)
    # A little off: what is far off has to be confirmed first (test_correction.py).
    near = [*(value - 0.1 for value in free[100][3:6]), *DRIFT[3:]]
    told = outputs(probed, 0, 200, probed=100, drift=near)
    assert free[:101] == told[:101]
    elongation = [row[3] for row in told]
    assert near[0] - 0.1 < elongation[101] < free[101][3] - 1e-3


def test_the_state_holds_the_models_memory_and_the_last_measurement(text: str) -> None:
    first = RunningCompensator(parse_model(text, "t"))
    outputs(first, 0, 101, probed=100)
    state = json.loads(json.dumps(first.state(), allow_nan=False))
    assert state["measured"] == DRIFT
    other = RunningCompensator(parse_model(text, "t"))
    other.restore(state)
    assert outputs(other, 101, 60) == outputs(first, 101, 60)


def test_what_is_not_finite_counts_as_not_measured(text: str) -> None:
    plain, probed = (RunningCompensator(parse_model(text, "t")) for _ in range(2))
    temperatures, speed = samples(1)[0]
    plain.step(0.0, 10.0, temperatures, speed, 120.0)
    probed.step(0.0, 10.0, temperatures, speed, 120.0, [float("nan"), *DRIFT[1:]])
    assert plain.state() == probed.state()
    with pytest.raises(ValueError, match="2 measured targets were given, the file has 5"):
        plain.step(10.0, 10.0, temperatures, speed, 120.0, [1.0, 2.0])


def test_the_fmu_takes_measurements_and_continues_from_a_state(text: str, tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    model.write_text(text)
    arguments = ["--only", "compensator", "--model", str(model), "--out", str(tmp_path)]
    assert build_fmu.main(arguments) == 0
    count, probed = 80, 40
    code = f"""
rows, drift, probed = json.loads({json.dumps(samples(count))!r}), {DRIFT}, {probed}
fmu = started(opened(sys.argv[1]))
found = []
for k, (temperatures, speed) in enumerate(rows):
    fmu.setReal(fmu.ins, [*temperatures, speed, 120.0, *drift])
    fmu.setBoolean([fmu.refs["measured"]], [k == probed])
    fmu.doStep(10.0 * k, 10.0)
    found.append(fmu.getReal(fmu.outs))
    if k == 60:
        data = fmu.serializeFMUstate(fmu.getFMUstate())
        fmu = opened(sys.argv[1])
        fmu.setFMUstate(fmu.deSerializeFMUstate(data))
show(found)
"""
    found = apart(code, tmp_path / "compensator.fmu")
    expected = outputs(RunningCompensator(parse_model(text, "t")), 0, count, probed=probed)
    assert found == [row[:9] for row in expected]


def test_options_of_a_model_reach_it_and_wrong_ones_do_not(text: str) -> None:
    table = fit_compensator(RUNS[:1], RIG, "bp", hidden=(3,), iterations=5)
    assert len(table["error_model"]["layers"][0]["biases"]) == 3
    assert table["input_form"] == "rise"
    assert parse_model(text, "t").input_form == "level"
    with pytest.raises(BadInput, match="turbo"):
        fit_compensator(RUNS[:1], RIG, "bp", turbo=True)


def test_the_file_says_how_far_a_prediction_may_be_off(text: str) -> None:
    figures = parse_model(text, "t").provenance["figures"]["unseen"]
    interval = figures["interval"]
    assert interval["coverage"] == 0.9
    # Three runs: the worst one's own quantile counts, so no RMSE is larger than the half width.
    rmse = max(row["elongation"]["model"] for row in figures["rmse_by_run"])
    grown = (0.25 + interval["longest_h"]) ** interval["power"]
    assert interval["scale"]["elongation"] * grown * 3.0 > rmse > 0.0


def test_a_sensor_with_another_level_in_some_runs_is_not_used_by_level() -> None:
    moved = [
        type(run)(run.name, run.frame.assign(T4_degC=run.frame["T4_degC"] + 31.0))
        for run in RUNS[2:]
    ]
    table = fit_compensator(
        [*RUNS[:2], *moved, make_run("d", 8, hours=2.0)], RIG, "thermal_states", penalty=1e-3
    )
    assert "T4" not in table["chosen"]
    assert any("the level form would carry it" in note for note in table["provenance"]["notes"])
    assert np.isfinite(table["provenance"]["figures"]["training"]["yaw"]["model"]["rmse"])
