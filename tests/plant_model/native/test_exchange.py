"""Model exchange with the plant's C FMU: beside its co-simulation, and what is refused."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu

from fmu_packaging.native.build import Fmi, native_package
from fmu_packaging.native.compilers import compilers
from gap_finder.keys import driver_keys
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.native.build import native_plant
from plant_model.native.equations import equations_of
from scenarios.building import plant_recipe
from tests.fmu_packaging.apart import apart
from tests.plant_model.conftest import with_effects

# The equations are the machine's, the calls the version's: not every pair is a question.
PAIRS = (
    pytest.param("jig_borer", 2, marks=pytest.mark.long),
    pytest.param("jig_borer_lumps", 3, marks=pytest.mark.long),
    ("lathe", 2),
    ("effects", 3),
)
WITHIN = 5e-3  # [K, um]; error control of the co-simulation takes 1e-2 K by its estimate


def machine_of(name: str) -> Machine:
    """Return a shipped machine, or one with every effect whose own states are continuous."""
    if name != "effects":
        return read_machine(name)
    machine = read_machine("jig_borer_lumps")
    effects = {key: law for key, law in catalogue().items() if key not in machine.effects}
    keys = [key for law in effects.values() for key in driver_keys(machine, law)]
    full = with_effects(machine, *keys)
    equations = equations_of(full, [])
    settling = set(equations.settling)
    jumping = {entry.key for entry in equations.acting if settling & set(entry.states)}
    assert jumping
    kept = {key: group for key, group in full.effects.items() if key not in jumping}
    assert len(kept) > 30
    return replace(full, effects=kept)


@pytest.fixture(scope="module")
def fmu_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Machine, Fmi], Path]:
    """Builds the C FMU of a machine."""
    folder = tmp_path_factory.mktemp("exchange")

    def build(machine: Machine, fmi: Fmi) -> Path:
        path = folder / f"{machine.name}_{len(machine.effects)}_{fmi}.fmu"
        if not path.exists():
            recipe, _ = plant_recipe(machine, "plant_native")
            package = native_package(recipe, native_plant(recipe), compilers()[:1], fmi)
            path.write_bytes(package.zipped())
        return path

    return build


RUN = """
import numpy as np
from fmpy import simulate_fmu
description = fmpy.read_model_description(sys.argv[1])
shown = [v.name for v in description.modelVariables if v.causality in ("output", "local")]
given = dict(dX=30.0, dZ=-20.0, tool_length=100.0)
times = np.repeat([0.0, 1200.0, 2400.0, 3600.0], 2)[1:-1]
inputs = np.array(list(zip(times, np.repeat([4000.0, 0.0, 3000.0], 2))),
                  dtype=[("time", float), ("speed", float)])
def run(kind):
    return simulate_fmu(sys.argv[1], fmi_type=kind, solver="CVode", stop_time=3600.0,
                        output_interval=60.0, relative_tolerance=1e-8, input=inputs,
                        start_values=given, output=shown, record_events=False)
one, other = run("CoSimulation"), run("ModelExchange")
assert list(one["time"]) == list(other["time"])
# Where the speed changes, outputs follow at once in model exchange, after a step otherwise.
held = one["time"] % 1200.0 > 0.0
apart = {n: float(np.abs(one[n] - other[n])[held].max()) for n in shown if n[:4] != "der("}
show([max(apart.values()), float(np.ptp(one["drift_Z"])), float(other["offset_X"][-1])])
"""


@pytest.mark.long
@pytest.mark.parametrize(("name", "fmi"), PAIRS)
def test_a_solver_gives_the_numbers_of_the_co_simulation(name, fmi, fmu_of):
    path = fmu_of(machine_of(name), fmi)
    assert validate_fmu(str(path)) == []
    worst, moved, offset = apart(RUN, path)
    assert moved > 0.5
    assert worst < WITHIN
    assert offset == 30.0


OPENED = """
import ctypes
description = fmpy.read_model_description(sys.argv[1])
two = description.fmiVersion == "2.0"
folder = fmpy.extract(sys.argv[1])
names = {v.name: v for v in description.modelVariables}
states = description.numberOfContinuousStates
def row(count=states):
    return (ctypes.c_double * count)()
def exchanged(start=0.0):
    return opened(sys.argv[1], folder, exchange=True, start=start)
def initialised():
    return started(exchanged(100.0))
def get(fmu, name):
    return fmu.get([fmu.refs[name]])[0]
def set_(fmu, name, value):
    fmu.put([fmu.refs[name]], [value])
def rates(fmu, values, count=states):
    (fmu.getDerivatives if two else fmu.getContinuousStateDerivatives)(values, count)
"""

CALLS = """
fmu = exchanged()
x, dx = row(), row()
first = next(n for n in names if n.endswith(".temperature"))
said = [status_of(fmu.enterContinuousTimeMode), status_of(fmu.getContinuousStates, x, states)]
fmu = initialised()
said += [status_of(fmu.setContinuousStates, x, states), status_of(fmu.enterEventMode)]
fmu.enterContinuousTimeMode()
said += [status_of(fmu.getContinuousStates, x, states + 1), status_of(fmu.setTime, float("nan"))]
said += [status_of(fmu.newDiscreteStates if two else fmu.updateDiscreteStates)]
said += [status_of(set_, fmu, first, 30.0), status_of(set_, fmu, "sources.motor.loss", 30.0)]
said += [status_of(fmu.getEventIndicators, x, 1)]
set_(fmu, "speed", 1e6)
said += [status_of(rates, fmu, dx)]
set_(fmu, "speed", 9000.0)
assert 3 == said[0] and set(said) == {3}, said
fmu.getContinuousStates(x, states)
before, value = list(x), get(fmu, first)
state = fmu.getFMUState() if not two else fmu.getFMUstate()
x[0] += 5.0
fmu.setContinuousStates(x, states)
moved = get(fmu, first) - value
(fmu.setFMUstate if two else fmu.setFMUState)(state)
fmu.getContinuousStates(x, states)
rates(fmu, dx)
fmu.terminate()
said = [status_of(rates, fmu, dx), status_of(fmu.setTime, 0.0)]
show([moved, list(x) == before, get(fmu, f"der({first})") == dx[0], said, len(messages)])
"""


@pytest.mark.parametrize(("name", "fmi"), [("jig_borer_lumps", 2), ("effects", 3)])
def test_calls_out_of_place_are_refused_and_a_state_comes_back(name, fmi, fmu_of):
    found = apart(OPENED + CALLS, fmu_of(machine_of(name), fmi))
    assert found == [pytest.approx(5.0), True, True, [0, 3], 12]


NOISY = """
fmu = exchanged()
fmu.setInteger([fmu.refs["noise_seed"]], [3])
started(fmu)
fmu.enterContinuousTimeMode()
shown = [get(fmu, "T1")]
fmu.setTime(0.5)
set_(fmu, "dX", 30.0)
shown += [get(fmu, "T1"), get(fmu, "offset_X")]
fmu.completedIntegratorStep()
show([*shown, get(fmu, "T1"), get(fmu, "offset_X")])
"""


def test_noise_and_offsets_go_on_when_a_step_has_ended(fmu_of):
    first, within, offset, after, moved = apart(
        OPENED + NOISY, fmu_of(read_machine("jig_borer_lumps"), 2)
    )
    assert first == within != after
    assert (offset, moved) == (0.0, pytest.approx(0.5))


def test_what_switches_is_for_co_simulation_only(fmu_of):
    machine = with_effects(read_machine("jig_borer_lumps"), "chiller")
    recipe, _ = plant_recipe(machine, "plant_native")
    assert "Not for model exchange: chiller switches" in native_plant(recipe).note
    path = fmu_of(machine, 2)
    described = fmpy.read_model_description(str(path))
    assert described.modelExchange is None
    assert described.numberOfContinuousStates == 0
    said: Any = apart(
        OPENED
        + """
try:
    exchanged()
    show("taken")
except Exception:
    show(messages[-1][1])
""",
        path,
    )
    assert "this FMU is for co-simulation" in said


COMPARED = """
import numpy as np
unknowns = [v for v in description.modelVariables
            if v.causality == "output" or v.derivative is not None]
of_state = [v.derivative for v in unknowns if v.derivative is not None]
own = np.array([v.name.startswith("effects.") for v in of_state])
inputs = [v for v in description.modelVariables if v.causality == "input"]
refs = [v.valueReference for v in unknowns]
rng = np.random.default_rng(4)
def states_are(fmu, values):
    fmu.setContinuousStates((ctypes.c_double * states)(*values), states)
def slope(moved, h):
    near, far = (moved(by) - moved(-by) for by in (h, 2 * h))
    return (8 * near - far) / (12 * h)
def derivatives(fmu, knowns):
    return np.array([fmu.getDirectionalDerivative(refs, [v.valueReference], [1.0])
                     for v in knowns]).T
def compared(fmu, knowns, by_differences, size, first=0):
    # Beside differences, as declared, and beside those in reverse.
    forward = derivatives(fmu, knowns)
    worst = np.abs(forward[:, first:] - by_differences) / size
    declared = {u.variable.name: u.dependencies for u in
                [*description.outputs, *description.derivatives]}
    told = np.array([[v in declared[u.name] for v in knowns] for u in unknowns])
    said = [float(worst.max()), int((forward != 0.0).sum()), bool(np.isfinite(forward).all()),
            bool(told.any()) and bool((told | (forward == 0.0)).all())]
    if not two:
        weights, known = rng.normal(size=len(unknowns)), [v.valueReference for v in knowns]
        back = np.array(fmu.getAdjointDerivative(refs, known, weights.tolist(), len(known)))
        size = 1e-12 + np.abs(weights) @ np.abs(forward)
        said.append(float((np.abs(back - weights @ forward) / size).max()))
    return said
"""

DERIVED = """
fmu = initialised()
fmu.enterContinuousTimeMode()
speed = float(sys.argv[2])
for v in inputs:
    # Off the ends of the ranges.
    set_(fmu, v.name, float(v.start) or float(v.nominal))
set_(fmu, "speed", speed)
fmu.setTime(5000.0)
start = row()
fmu.getContinuousStates(start, states)
start = np.array(start) + rng.uniform(0.5, 9.0, states)
start[own] = rng.uniform(0.1, 0.4, own.sum())
def values(states_now):
    states_are(fmu, states_now)
    return np.array(fmu.get(refs))
def moved(place, by):
    if place >= len(inputs):
        return values(start + by * (np.arange(states) == place - len(inputs)))
    before = get(fmu, inputs[place].name)
    set_(fmu, inputs[place].name, before + by)
    found = values(start)
    set_(fmu, inputs[place].name, before)
    return found
knowns, first = [*inputs, *of_state], len(inputs) if speed == 0.0 else 0
by_differences = np.array([slope(lambda by: moved(k, by), 1e-3)
                           for k in range(first, len(knowns))]).T
values(start)
said = compared(fmu, knowns, by_differences, 1e-3 + np.abs(by_differences), first)
state, output = of_state[0].valueReference, inputs[0].valueReference
mistaken = [([output], [output]), (refs[:1], refs[:1]), ([99999], [output])]
show([*said, [status_of(fmu.getDirectionalDerivative, u, k, [1.0]) for u, k in mistaken]])
"""


@pytest.mark.parametrize("speed", [3000.0, 0.0])
@pytest.mark.parametrize(("name", "fmi"), PAIRS)
def test_derivatives_are_those_of_differences_and_declared(name, fmi, speed, fmu_of):
    worst, count, finite, declared, *adjoint, mistaken = apart(
        OPENED + COMPARED + DERIVED, fmu_of(machine_of(name), fmi), speed
    )
    assert finite
    assert declared
    assert count > 100
    assert worst < 1e-5
    assert all(apart_by < 1e-12 for apart_by in adjoint)
    assert mistaken == [3, 3, 3]


STEPPED = """
stepped = started(opened(sys.argv[1], folder, start=100.0))
set_(stepped, "speed", 3000.0)
for k in range(20):
    stepped.doStep(100.0 + 60.0 * k, 60.0)
fmu = initialised()
fmu.enterContinuousTimeMode()
fmu.setTime(1300.0)
set_(fmu, "speed", 3000.0)
states_are(fmu, [get(stepped, v.name) for v in of_state])
one, other = (derivatives(f, [*inputs, *of_state]) for f in (stepped, fmu))
show([float(np.abs(one - other).max()), int((one != 0.0).sum())])
"""


def test_derivatives_are_the_same_in_a_co_simulation(fmu_of):
    worst, count = apart(OPENED + COMPARED + STEPPED, fmu_of(machine_of("lathe"), 2))
    assert worst < 1e-12
    assert count > 100


TUNED = """
parameters = [v for v in description.modelVariables if v.causality == "parameter"
              and v.type in ("Real", "Float64") and "start_rise" not in v.name]
def inside(v):
    # Off the ends of the range, where an effect is not there.
    return 0.9 * float(v.start) + 0.05 * (float(v.min) + float(v.max))
at = {v.name: inside(v) for v in parameters}
start = 20.0 * ~own + rng.uniform(0.5, 9.0, states)
start[own] = rng.uniform(0.1, 0.4, own.sum())
fmu = exchanged(100.0)
def values(changed):
    fmu.reset()
    if two:
        fmu.setupExperiment(startTime=100.0)
    for name, value in (at | changed).items():
        set_(fmu, name, value)
    started(fmu)
    fmu.enterContinuousTimeMode()
    set_(fmu, "speed", 3000.0)
    fmu.setTime(5000.0)
    states_are(fmu, start)
    return np.array(fmu.get(refs))
by_differences = np.array([slope(lambda by: values({v.name: at[v.name] + by}),
                                 1e-3 * abs(at[v.name])) for v in parameters]).T
values({})
largest = np.abs(by_differences).max(axis=0)
size = np.where(largest > 0.0, largest, 1.0)
show(compared(fmu, parameters, by_differences, size))
"""


@pytest.mark.parametrize(("name", "fmi"), PAIRS)
def test_derivatives_by_parameters_are_those_of_differences(name, fmi, fmu_of):
    path = fmu_of(machine_of(name), fmi)
    worst, count, finite, declared, *adjoint = apart(OPENED + COMPARED + TUNED, path)
    assert worst < 1e-5
    assert count > 20
    assert finite
    assert declared == (fmi == 3)  # FMI 2.0 has no place for them
    assert all(apart_by < 1e-12 for apart_by in adjoint)
