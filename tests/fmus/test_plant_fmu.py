"""The plant FMU, each test in a fresh process."""

import zipfile
from html import unescape

import fmpy
import pytest

from fmu_packaging.units import fmi_name
from plant_model.fmi_slave import variable_name
from plant_model.machine_file import read_machine
from plant_model.stepper import PlantStepper
from tests.fmu_packaging.apart import apart

RUN = """
def steps(fmu, first, count, h=1.0):
    rows = []
    for k in range(first, first + count):
        names = ["speed", "ambient", "coolant_inlet", "torque", "tool_length", "dX", "dY", "dZ"]
        values = [8000.0 if k < 60 else 2000.0, 21.0 + 0.001 * k, 20.0, 3.0, 150.0, 4.0, -3.0, 2.0]
        fmu.setReal([fmu.refs[n] for n in names], values)
        fmu.doStep(k * h, h)
        rows.append(fmu.getReal(fmu.outs))
    return rows
"""
AT_START = {"speed": 8000.0, "ambient": 21.0, "coolant_inlet": 20.0}


def _expected(count: int, parameters: dict[str, float] | None = None) -> list[list[float]]:
    stepper = PlantStepper(read_machine("jig_borer"), parameters)
    inputs = {**AT_START, "torque": 0.0, "tool_length": 150.0, "dX": 0.0, "dY": 0.0, "dZ": 0.0}
    stepper.reset(inputs)
    rows = []
    for k in range(count):
        inputs |= {"speed": 8000.0 if k < 60 else 2000.0, "ambient": 21.0 + 0.001 * k}
        inputs |= {"torque": 3.0, "dX": 4.0, "dY": -3.0, "dZ": 2.0}
        stepper.step(1.0, inputs)
        rows.append(list(stepper.outputs().values()))
    return rows


def test_gives_what_the_stepper_gives(plant):
    start = ", ".join(f"{name}={value}" for name, value in AT_START.items())
    found = apart(RUN + f"show(steps(started(opened(sys.argv[1]), {start}), 0, 120))", plant)
    assert found == _expected(120)


def test_outputs_before_the_first_step_follow_the_inputs(plant):
    found = apart(
        """
fmu = opened(sys.argv[1])
t1 = fmu.refs["T1"]
fmu.enterInitializationMode()
rows = []
for ambient in (18.0, 25.0):
    fmu.setReal([fmu.refs[n] for n in ("ambient", "coolant_inlet")], [ambient, ambient])
    rows.append(fmu.getReal([t1])[0])
fmu.exitInitializationMode()
show([*rows, fmu.getReal([t1])[0]])
""",
        plant,
    )
    assert found == pytest.approx([18.0, 25.0, 25.0])


def test_it_can_begin_as_warm_as_a_measured_run(plant):
    found = apart(
        """
fmu = opened(sys.argv[1])
names = ["T1", "T2", "T11", "T6"]
fmu.setReal([fmu.refs[n] for n in ("start_rise.T1", "start_rise.T2")], [4.0, -1.5])
fmu.setReal([fmu.refs[n] for n in ("ambient", "coolant_inlet")], [21.0, 20.0])
fmu.enterInitializationMode()
fmu.exitInitializationMode()
show(fmu.getReal([fmu.refs[n] for n in [*names, "drift_Z"]]))
""",
        plant,
    )
    assert found == [25.0, 19.5, 21.0, 21.0, 0.0]


def test_the_machine_s_parameters_can_be_set(plant):
    machine = read_machine("jig_borer")
    name = next(n for n, p in machine.parameters.items() if p.calibrate and "-" in n)
    value = machine.parameters[name].high
    start = ", ".join(f"{key}={number}" for key, number in AT_START.items())
    found = apart(
        RUN
        + "fmu = opened(sys.argv[1])\n"
        + "fmu.setReal([fmu.refs[sys.argv[2]]], [float(sys.argv[3])])\n"
        + f"show(steps(started(fmu, {start}), 0, 90))",
        plant,
        variable_name(name),
        value,
    )
    assert found == _expected(90, {name: value})
    assert found != _expected(90)


def test_parameters_carry_unit_range_and_source(plant):
    machine = read_machine("jig_borer")
    declared = {v.name: v for v in fmpy.read_model_description(str(plant)).modelVariables}
    movable = {n: p for n, p in machine.parameters.items() if p.calibrate}
    assert movable
    with zipfile.ZipFile(plant) as archive:
        page = unescape(archive.read("documentation/index.html").decode())
    for name, parameter in movable.items():
        variable = declared[variable_name(name)]
        assert variable.unit == fmi_name(parameter.unit)
        assert (float(variable.min), float(variable.max)) == (parameter.low, parameter.high)
        assert float(variable.start) == parameter.value
        source = machine.references.get(parameter.source, parameter.source)
        assert f"<td>{variable.name}</td><td>{source}</td>" in page


def test_an_input_out_of_range_discards_the_step_with_its_cause(plant):
    found = apart(
        """
fmu = started(opened(sys.argv[1]), ambient=21.0)
fmu.setReal([fmu.refs["speed"]], [1e6])
status = status_of(fmu.doStep, 0.0, 1.0)
show([status, messages[-1][1].splitlines()[-1]])
""",
        plant,
    )
    assert found[0] == 2
    assert "speed: 1e+06 is not allowed: it must be 0 to 20000 rpm" in found[1]
