"""Models with a memory inside the compensator, and inside the FMU."""

import json
from typing import Any

import pytest

import build_fmu
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import parse_model
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


def test_the_fmu_takes_measurements_and_continues_from_a_state(text, tmp_path):
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
    fmu.setReal(fmu.ins + fmu.probed, [*temperatures, speed, 120.0, *drift])
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
