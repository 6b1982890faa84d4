"""The plant in C beside the plant in Python: every effect, random numbers, random inputs."""

import ctypes
from dataclasses import replace

import numpy as np
import pytest

from gap_finder.keys import driver_keys
from plant_model.effects import catalogue
from plant_model.fmi_slave import start_sensors
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.noise import NormalSequence
from plant_model.parameters import NUMBERS, Parameter
from plant_model.stepper import OFFSETS, PlantStepper
from tests.plant_model.catalogue_machines import lathe
from tests.plant_model.conftest import with_effects
from tests.plant_model.drawing.pages import machine_of, small_page
from tests.plant_model.native.conftest import Core

STEPS_S = (1.0, 10.0, 60.0, 0.1, 300.0)
CLOSE = 1e-8
NOISE_SEED = 11


def tunable(machine: Machine) -> Machine:
    """Return the machine with every number tunable."""

    def free(group: dict[str, Parameter]) -> dict[str, Parameter]:
        return {name: replace(entry, calibrate=True) for name, entry in group.items()}

    return replace(
        machine,
        nodes=tuple(
            replace(node, capacity=replace(node.capacity, calibrate=True)) for node in machine.nodes
        ),
        items=tuple(replace(item, parameters=free(item.parameters)) for item in machine.items),
        effects={key: free(group) for key, group in machine.effects.items()},
        numbers=free(machine.numbers),
    )


def with_all_effects(machine: Machine) -> Machine:
    missing = {name: effect for name, effect in catalogue().items() if name not in machine.effects}
    keys = [key for effect in missing.values() for key in driver_keys(machine, effect)]
    return tunable(with_effects(machine, *keys))


def inputs_of(machine: Machine, rng: np.random.Generator) -> dict[str, float]:
    """Return random inputs: machine at rest now and then, temperatures of a hall."""
    return {
        entry.name: rng.uniform(18.0, 23.0)
        if entry.is_boundary
        else rng.uniform(entry.low, entry.high) * rng.integers(0, 2)
        for entry in machine.inputs
    }


def values_of(machine: Machine, rng: np.random.Generator, share_on: float) -> dict[str, float]:
    """Return effects' numbers near their nominal ones, a share of the effects switched off."""
    found = {}
    for key, group in machine.effects.items():
        effect = catalogue()[key.partition(":")[0]]
        for name, entry in group.items():
            near = entry.value + rng.uniform(-0.1, 0.1) * abs(entry.value)
            found[f"effects.{key}.{name}"] = float(np.clip(near, entry.low, entry.high))
        # A page's class value need not let an effect be off.
        if rng.uniform() > share_on and group[effect.amplitude].low <= effect.off:
            found[f"effects.{key}.{effect.amplitude}"] = effect.off
    return found


def linear_values_of(machine: Machine, rng: np.random.Generator) -> dict[str, float]:
    """Return numbers that switch off what depends on temperature: lags only follow."""
    values = values_of(machine, rng, 1.0)
    for key in machine.effects:
        effect = catalogue()[key.partition(":")[0]]
        follows = effect.lags or effect.settles or not effect.states
        if effect.temperature_dependent or not follows:
            values[f"effects.{key}.{effect.amplitude}"] = effect.off
    return values


def compared(
    machine: Machine,
    library: ctypes.CDLL,
    values: dict[str, float],
    rng: np.random.Generator,
    steps: int,
    seed: int = 0,
) -> tuple[float, PlantStepper]:
    """Return the largest difference of any output over a run, and the plant in Python.

    Where a bearing runs away Python gives up; C must then, too, and that is the end.
    """
    python = PlantStepper(machine, values, noise_seed=seed or None)
    core = Core(library, machine, values, seed)
    assert core.linear == python.network.linear
    inputs, sensors = inputs_of(machine, rng), start_sensors(machine)
    rises = rng.uniform(-1.0, 1.0, len(sensors)).tolist()
    first = inputs[next(iter(machine.boundary_index))]
    readings = {name: first + rise for name, rise in zip(sensors, rises, strict=True)}
    python.reset(inputs | {"tool_length": 150.0}, readings)
    core.start(list(inputs.values()), rises, 150.0)
    worst = difference(python, core)
    for k in range(steps):
        # Speeds that stay, and speeds that are another in every step.
        if k % 15 == 0 or 40 < k % 100 < 50:
            inputs = inputs_of(machine, rng)
        step_s = STEPS_S[(k // 7) % len(STEPS_S)]
        tool, offsets = rng.uniform(0.0, 300.0), rng.uniform(-400.0, 400.0, 3).tolist()
        told = inputs | {"tool_length": tool} | dict(zip(OFFSETS, offsets, strict=True))
        try:
            python.step(step_s, told)
        except IntegrationError:
            assert core.step(step_s, list(inputs.values()), tool, offsets) != ""
            break
        assert core.step(step_s, list(inputs.values()), tool, offsets) == ""
        worst = max(worst, difference(python, core))
    return worst, python


def difference(python: PlantStepper, core: Core) -> float:
    expected = np.array(list(python.outputs().values()))
    found = core.outputs()
    assert np.isfinite(expected).all()
    assert expected.shape == found.shape
    # Where nothing carries the heat away, temperatures grow without end, and rounding with them.
    return float(np.max(np.abs(expected - found) / np.maximum(1.0, np.abs(expected) / 1e3)))


MACHINES = [
    pytest.param(read_machine("jig_borer_lumps"), marks=pytest.mark.long),
    pytest.param(read_machine("lathe"), marks=pytest.mark.long),
    replace(lathe(), name="other_lathe"),
    machine_of(small_page()),
]


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_every_effect_gives_the_numbers_of_python(machine, library_of):
    everything = with_all_effects(machine)
    assert {key.partition(":")[0] for key in everything.effects} == set(catalogue())
    library, rng = library_of(everything), np.random.default_rng(7)
    linear = 0
    for share_on in (1.0, 0.7, 0.7, 0.5):
        worst, python = compared(everything, library, values_of(everything, rng, share_on), rng, 25)
        linear += python.network.linear
        assert worst < CLOSE
    worst, python = compared(everything, library, linear_values_of(everything, rng), rng, 120)
    assert worst < CLOSE
    assert python.network.linear


def test_parts_start_as_in_python(library_of):
    machine = machine_of(small_page())
    shares = {"head": ("T2", 0.4), "column": ("T1", 1.3), "tool": ("coolant_inlet", 0.5)}
    nodes = [
        replace(node, start=shares[node.name][0], start_share=shares[node.name][1])
        if node.name in shares
        else node
        for node in machine.nodes
    ]
    machine = replace(machine, nodes=tuple(nodes))
    assert sum(node.rests for node in machine.nodes) > 10
    worst, _ = compared(machine, library_of(machine), {}, np.random.default_rng(10), 60)
    assert worst < CLOSE


def test_what_is_tied_to_a_number_follows_it_in_c(library_of):
    machine = tunable(machine_of(small_page()))
    library, rng = library_of(machine), np.random.default_rng(12)
    values = {f"{NUMBERS}{name}": entry.high for name, entry in machine.numbers.items()}
    worst, _ = compared(machine, library, values, rng, 60)
    assert worst < CLOSE
    for name, high in values.items():
        worst, _ = compared(machine, library, {name: high}, rng, 20)
        assert worst < CLOSE, name


def test_heat_stays_where_it_is_if_nothing_exchanges_it(library_of):
    everything = with_all_effects(read_machine("jig_borer_lumps"))
    alone = values_of(everything, np.random.default_rng(8), 0.0)
    friction = catalogue()["bearing_friction"]
    alone[f"effects.bearing_friction.{friction.amplitude}"] = 1.0
    rng = np.random.default_rng(9)
    worst, python = compared(everything, library_of(everything), alone, rng, 60)
    assert worst < CLOSE
    assert python.network.linear
    assert python.outputs()["T1"] > python.outputs()["T2"] + 1.0, "only the bearings warm up"


@pytest.mark.parametrize("name", ["jig_borer_lumps", "lathe"])
def test_the_shipped_machines_with_noise_give_the_numbers_of_python(name, library_of):
    machine = read_machine(name)
    rng = np.random.default_rng(3)
    library = library_of(machine)
    assert compared(machine, library, {}, rng, 400)[0] < CLOSE
    assert compared(machine, library, {}, rng, 100, NOISE_SEED)[0] < CLOSE


def test_the_noise_is_normally_distributed_and_its_seeds_differ():
    one, other = NormalSequence(1, 50_000), NormalSequence(2, 50_000)
    first, second = one.draw(), other.draw()
    for drawn in (first, second):
        assert abs(drawn.mean()) < 4.0 / np.sqrt(drawn.size)
        assert abs(drawn.std() - 1.0) < 4.0 / np.sqrt(2.0 * drawn.size)
        assert abs(np.mean(np.abs(drawn) > 1.96) - 0.05) < 0.004
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.02
    assert abs(np.corrcoef(first[1:], first[:-1])[0, 1]) < 0.02
    again = NormalSequence(1, 50)
    assert np.array_equal(np.concatenate([again.draw(), again.draw()]), first[:100])
