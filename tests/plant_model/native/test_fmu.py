"""The plant's C FMU as a host meets it: beside the Python FMU of the same machine."""

from pathlib import Path
from types import SimpleNamespace

import fmpy
import pytest
from fmpy.validation import validate_fmu

from tests.fmu_packaging.apart import apart, variables_of

RUN = """
import math
def inputs(k):
    speed = [3000.0, 12000.0, 0.0][(k // 20) % 3] + (k if 40 < k < 60 else 0)
    # The machine's inputs, then tool_length, dX, dY, dZ.
    return [speed, 20.0 + 0.01 * k, 21.0, 5.0, 120.0, 30.0 - k, 5.0, 500.0]

def steps(fmu, first, count):
    rows = []
    for k in range(first, first + count):
        fmu.setReal(fmu.ins, inputs(k))
        fmu.doStep(float(k), 1.0)
        rows.append(list(fmu.getReal(fmu.outs)))
    return rows

def ready(path, seed=0, **reals):
    fmu = opened(path)
    fmu.setReal([fmu.refs[name] for name in reals], list(reals.values()))
    fmu.setInteger([fmu.refs["noise_seed"]], [seed])
    fmu.setReal(fmu.ins, inputs(0))
    before = list(fmu.getReal(fmu.outs))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, before
"""


@pytest.fixture(scope="module")
def both(shipped_in_c: Path) -> SimpleNamespace:
    """The FMU in C and the one in Python."""
    return SimpleNamespace(
        native=shipped_in_c / "plant_native.fmu", python=shipped_in_c / "plant.fmu"
    )


def test_validation_is_clean_and_the_variables_are_those_of_the_python_fmu(both):
    assert validate_fmu(str(both.native)) == []
    found, expected = variables_of(both.native), variables_of(both.python)
    # Behind them come the states and derivatives of model exchange.
    assert found[: len(expected)] == expected
    assert {one["causality"] for one in found[len(expected) :]} == {"local"}
    assert not fmpy.read_model_description(str(both.native)).coSimulation.needsExecutionTool


@pytest.mark.parametrize(
    ("seed", "moved"), [(0, {}), (4, {"sources.motor.loss": 33.0, "start_rise.T1": 1.5})]
)
def test_a_run_gives_the_numbers_of_the_python_fmu(both, seed, moved):
    code = (
        f"fmu, before = ready(sys.argv[1], {seed}, **{moved})\nshow([before, *steps(fmu, 0, 90)])"
    )
    found, expected = (apart(RUN + code, path) for path in (both.native, both.python))
    assert max(map(abs, expected[-1])) > 10.0
    for one, other in zip(found, expected, strict=True):
        assert one == pytest.approx(other, rel=0.0, abs=1e-8)


REFUSED = """
fmu = opened(sys.argv[1])
def with_input(name, value):
    fmu.setReal([fmu.refs[name]], [value])
    before = list(fmu.getReal(fmu.outs))
    status = status_of(fmu.doStep, reached, 1.0)
    assert list(fmu.getReal(fmu.outs)) == before
    fmu.setReal(fmu.ins, inputs(0))
    return status
fmu.setReal(fmu.ins, inputs(0))
fmu.setReal([fmu.refs["tool_length"]], [-1.0])
fmu.enterInitializationMode()
said = [status_of(fmu.exitInitializationMode)]
fmu.setReal([fmu.refs["tool_length"]], [100.0])
said.append(status_of(fmu.exitInitializationMode))
reached = 3.0
fmu.doStep(0.0, 3.0)
nan, inf = math.nan, math.inf
for name, value in (("tool_length", nan), ("tool_length", 1e6), ("dX", nan), ("dY", inf),
                    ("speed", 1e6), ("ambient", nan)):
    said.append(with_input(name, value))
said += [status_of(fmu.doStep, reached, step) for step in (0.0, -1.0, nan, inf)]
said += [status_of(fmu.doStep, 500.0, 1.0), status_of(fmu.doStep, 0.0, 1.0)]
said.append(status_of(fmu.doStep, reached, 1.0))
fmu.terminate()
said.append(status_of(fmu.doStep, reached + 1.0, 1.0))
show([said, [m[1] for m in messages]])
"""


@pytest.mark.parametrize("kind", ["native", "python"])
def test_what_is_out_of_range_is_refused_and_changes_nothing(both, kind):
    statuses, messages = apart(RUN + REFUSED, getattr(both, kind))
    failure = 3 if kind == "native" else 4
    begun = statuses.pop(0), statuses.pop(0)
    # A refusal is fatal in pythonfmu's binary, but the initialisation can be tried again.
    assert begun == (failure, 0)
    assert statuses[:10] == [2] * 10
    # A step at another time and one after the end: an error, which pythonfmu can only discard.
    refused = 3 if kind == "native" else 2
    assert statuses[10:] == [refused, refused, 0, refused]
    words = ["tool_length: -1", "tool_length: nan", "tool_length: 1e+06", "dX: nan", "dY: inf"]
    words += ["speed: 1e+06", "ambient: nan"]
    for word in words:
        assert any(word in said for said in messages), word


def test_the_stop_time_holds(both):
    code = """
said = []
for path in sys.argv[1:]:
    fmu = opened(path)
    if "native" in path:
        fmu.reset()
    fmu.setupExperiment(startTime=0.0, stopTime=2.0)
    fmu.setReal(fmu.ins, inputs(0))
    started(fmu)
    fmu.doStep(0.0, 2.0)
    state = fmu.serializeFMUstate(fmu.getFMUstate())
    said.append(status_of(fmu.doStep, 2.0, 1e-3))
    other = opened(path)
    said.append(status_of(other.setupExperiment, None, 5.0, 0.0))
    other.setFMUstate(other.deSerializeFMUstate(state))
    said.append(status_of(other.doStep, 2.0, 1e-3))
show(said)
"""
    assert apart(RUN + code, both.native, both.python) == [3, 3, 3, 2, 4, 2]


@pytest.mark.long
def test_fmi3_gives_the_same_numbers(shipped_in_c, shipped_in_fmi3):
    assert validate_fmu(str(shipped_in_fmi3 / "plant_native_fmi3.fmu")) == []
    one, other = (
        shipped_in_c / "plant_native_ref.csv",
        shipped_in_fmi3 / "plant_native_fmi3_ref.csv",
    )
    assert one.read_text() == other.read_text()


TUNED = """
def changed(fmu, name, value):
    return status_of(fmu.setReal, [fmu.refs[name]], [value])

fmu, _ = ready(sys.argv[1], seed=5)
first = steps(fmu, 0, 30)
(preload,) = fmu.getReal([fmu.refs["sources.front.preload"]])
said = [changed(fmu, "sources.front.preload", 1.3 * preload)]
state = fmu.serializeFMUstate(fmu.getFMUstate())
rows = steps(fmu, 30, 40)
other = opened(sys.argv[1])
other.setFMUstate(other.deSerializeFMUstate(state))
same = steps(other, 30, 40) == rows
# Back from a step that was refused, and from another value.
fmu.setReal([fmu.refs["speed"], fmu.refs["sources.front.preload"]], [1e6, preload])
status_of(fmu.doStep, 70.0, 1.0)
fmu.setFMUstate(fmu.deSerializeFMUstate(state))
same = same and steps(fmu, 30, 40) == rows
plain, _ = ready(sys.argv[1], seed=5)
stays = steps(plain, 0, 70)
said.append(changed(fmu, "numbers.steel_expansion", 12.0))
said.append(changed(fmu, "sources.front.preload", -1.0))
fmu.setReal(fmu.ins, inputs(70))
said.append(status_of(fmu.doStep, 70.0, 1.0))
fmu.setFMUstate(fmu.getFMUstate())
said.append(status_of(fmu.doStep, 70.0, 1.0))
show([first + rows, stays, same, said, messages[-1][1]])
"""


def test_a_parameter_that_wears_changes_in_mid_run(both):
    (native, plain, same, said, cause), python = (
        apart(RUN + TUNED, path) for path in (both.native, both.python)
    )
    assert same
    assert python[2]
    for one, other in zip(native, python[0], strict=True):
        assert one == pytest.approx(other, rel=1e-8, abs=1e-8)
    # As it was up to the change, and in the step after it.
    assert native[:30] == plain[:30]
    assert native[30] != plain[30]
    assert said == [0, 3, 0, 2, 2]
    assert "sources.front.preload: -1 is not allowed" in cause


def test_lengths_and_expansions_are_fixed(both):
    listed = fmpy.read_model_description(str(both.native)).modelVariables
    found = {one.name: one.variability for one in listed if one.causality == "parameter"}
    assert found["sources.front.preload"] == found["sources.front.f0"] == "tunable"
    assert found["numbers.steel_expansion"] == found["structure.pedestal_y.length"] == "fixed"
    assert found["start_rise.T1"] == found["noise_seed"] == "fixed"
