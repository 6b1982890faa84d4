"""Models with a memory inside the compensator, and inside the FMU."""

import json

import build_fmu
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import parse_model
from tests.fmu_compensator.conftest import RIG, make_run
from tests.fmu_packaging.apart import apart

RUNS = [make_run(name, seed, hours=2.0) for seed, name in enumerate("abc")]
DRIFT, PROBED = [4.0, 1.0, -1.0, 0.5, 0.5], 40


def test_the_fmu_takes_measurements_and_continues_from_a_state(tmp_path):
    table = fit_compensator(RUNS, RIG, "thermal_states", lags_s=(1800.0,), penalty=1e-4, walk=0.0)
    text, model = compensator_text(table), tmp_path / "model.json"
    model.write_text(text)
    arguments = ["--only", "compensator", "--model", str(model), "--out", str(tmp_path)]
    assert build_fmu.main(arguments) == 0
    frame = make_run("new", 9, hours=1.0, step_s=10.0).frame.head(80)
    rows = frame[["T1_degC", "T2_degC", "T3_degC", "T4_degC", "speed_rpm"]].to_numpy().tolist()
    code = f"""
rows = json.loads({json.dumps(rows)!r})
fmu = started(opened(sys.argv[1]))
found = []
for k, row in enumerate(rows):
    fmu.setReal(fmu.ins + fmu.probed, [*row, 120.0, *{DRIFT}])
    fmu.setBoolean([fmu.refs["measured"]], [k == {PROBED}])
    fmu.doStep(10.0 * k, 10.0)
    found.append(fmu.getReal(fmu.outs))
    if k == 60:
        data = fmu.serializeFMUstate(fmu.getFMUstate())
        fmu = opened(sys.argv[1])
        fmu.setFMUstate(fmu.deSerializeFMUstate(data))
show(found)
"""
    found = apart(code, tmp_path / "compensator.fmu")
    compensator = RunningCompensator(parse_model(text, "t"))
    for k, (*temperatures, speed) in enumerate(rows):
        measured = DRIFT if k == PROBED else None
        output = compensator.step(10.0 * k, 10.0, temperatures, speed, 120.0, measured)
        assert found[k] == list(output[:9])
