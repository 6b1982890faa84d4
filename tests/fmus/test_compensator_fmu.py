"""The compensator FMU, each test in a fresh process."""

import json
from pathlib import Path

import pytest

import build_fmu
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import parse_model
from tests.fmu_packaging.apart import apart
from tests.fmus.models import RUN, five_point_table, five_point_text, inputs


def _expected(text: str, count: int) -> list[list[object]]:
    """Return what the compensator itself gives, without any FMU."""
    compensator = RunningCompensator(parse_model(text, "test"))
    rows: list[list[object]] = []
    for k in range(count):
        *values, speed, tool = inputs(k)
        out = compensator.step(float(k), 1.0, values, speed, tool)
        rows.append([*out[:9], out.status, out.status_sensor, out.valid, out.status_text])
    return rows


def test_gives_what_the_compensator_gives(compensator):
    found = apart(RUN + "show(steps(started(opened(sys.argv[1])), 0, 120))", compensator)
    assert found == _expected(five_point_text(), 120)
    assert {row[9] for row in found} >= {0, 11, 21}


POISON = """
import sys, types
import fmu_compensator.runtime.compensator as c, fmu_compensator.runtime.error_models.mlr as m
import fmu_compensator.runtime.fmi_slave, fmu_packaging.slave
import plant_model.stepper, measurement.units
def broken(*args, **kwargs): raise RuntimeError("the host's module ran")
c.RunningCompensator.step = broken
c.RunningCompensator.__init__ = broken
m.MultipleLinearRegression.predict = broken
fmu_packaging.slave.DriftSlave.get_real = broken
plant_model.stepper.PlantStepper.step = broken
sys.modules["fmu_compensator.runtime.limits"] = types.ModuleType("poison")
sys.modules["pythonfmu"] = types.ModuleType("poison")
sys.modules["pythonfmu.fmi2slave"] = types.ModuleType("poison")
"""


def test_what_the_host_has_imported_does_not_matter(compensator):
    code = (
        "show([x if isinstance(x, str) else repr(x) for row in steps(started(opened(sys.argv[1]))"
    )
    code += ", 0, 50) for x in row])"
    alone = apart(RUN + code, compensator)
    root = Path(build_fmu.__file__).parent
    poisoned = apart(RUN + code, compensator, before=POISON, path=root)
    assert alone == poisoned
    assert len(set(alone)) > 50


OTHER_FILE = (
    RUN
    + """
fmu = opened(sys.argv[1])
fmu.setString([fmu.refs["model_file"]], [sys.argv[2]])
fmu.enterInitializationMode()
status = status_of(fmu.exitInitializationMode)
rows = steps(fmu, 0, 60) if status == 0 else []
said = [m[1].splitlines()[-1] for m in messages]
fmu.freeInstance()
show([status, rows, said])
"""
)


def test_takes_another_file_with_fewer_sensors(compensator, tmp_path):
    table = five_point_table(gain=0.5)
    table["sensors"] = [table["sensors"][place] for place in (5, 3, 0)]
    path = tmp_path / "fewer sensors.json"
    path.write_text(json.dumps(table))
    status, rows, _ = apart(OTHER_FILE, compensator, path)
    assert status == 0
    assert [row[:6] for row in rows] == [
        row[:6] for row in _expected(five_point_text(gain=0.5), 60)
    ]


def test_blames_the_sensor_by_its_number_among_the_inputs(compensator, tmp_path):
    table = five_point_table()
    table["sensors"] = [table["sensors"][place] for place in (3, 0)]
    path = tmp_path / "two.json"
    path.write_text(json.dumps(table))
    _, rows, _ = apart(OTHER_FILE, compensator, path)
    assert rows[45][9:11] == [11, 4]


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        (None, "cannot be read: No such file or directory"),
        (five_point_text().replace('"hold_s": 30.0', '"hold_s": "long"'), "limits.hold_s"),
        (five_point_text(sensors=12), "sensors.11.name: 'T12' is not allowed"),
    ],
)
def test_a_file_that_cannot_be_used_is_reported_and_the_host_lives(
    compensator, tmp_path, text, cause
):
    path = tmp_path / "bad 100%.json"
    if text is not None:
        path.write_text(text)
    status, _, said = apart(OTHER_FILE, compensator, path)
    assert status > 2
    assert said[-1].startswith("model_file: ")
    assert str(path) in said[-1]
    assert cause in said[-1]
