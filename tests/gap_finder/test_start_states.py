"""Parts that start at another temperature than the machine file says."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.find import answer
from gap_finder.five_lines import five_lines
from gap_finder.kinds.start_state import StartState
from gap_finder.report import report_of
from gap_finder.search import Search
from measurement.runs import Run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from plant_model.simulate import simulate
from plant_model.stepper import PlantStepper
from tests.gap_finder.conftest import SPECTRA, inputs_of

HIDDEN = ("rotor", "stator", "shaft_middle")
WARMTH = (0.0, 35.0, 12.0, 45.0)
"""How far above the hall the motor is when each run begins [K]."""


def warm_runs(machine: Machine) -> list[Run]:
    """Return runs that begin with the motor still warm from the run before."""
    runs = []
    for seed, (name, warm) in enumerate(zip(SPECTRA, WARMTH, strict=True)):
        inputs = inputs_of(name, 60.0)
        firsts = {"T11": 1.0, "T8": 0.5, "T1": 0.6, "T6": 0.4, "T7": 0.3, "T10": 0.3}
        for sensor, share in firsts.items():
            inputs[f"{sensor}_degC"] = inputs["T5_degC"].iloc[0] + share * warm
        runs.append(Run(name, simulate(machine, inputs, noise_seed=seed).run_frame()))
    return runs


@pytest.fixture(scope="module")
def told_wrong(jig_borer_lumps: Machine) -> Machine:
    """The machine as an owner would describe it who has no thermometer on the motor."""
    nodes = tuple(
        replace(node, start="ambient") if node.name in HIDDEN else node
        for node in jig_borer_lumps.nodes
    )
    return replace(jig_borer_lumps, nodes=nodes)


def test_a_share_of_the_way_in_the_file_the_simulation_and_the_stepper(jig_borer_lumps, tmp_path):
    machine = StartState(("rotor",), "T8", (0.25,), True).put_into(jig_borer_lumps, {"share": 0.25})
    path = write_machine(machine, "jig_borer_lumps", tmp_path / "after.toml")
    assert read_machine(path) == machine
    assert Machine.from_dict(machine.to_dict()) == machine
    inputs = inputs_of("down", 60.0).assign(T8_degC=29.0)
    at = machine.node_index["rotor"]
    assert simulate(machine, inputs).temperatures[0, 0, at] == pytest.approx(21.0 + 2.0)
    stepper = PlantStepper(machine)
    stepper.reset(
        {"ambient": 21.0, "coolant_inlet": 21.0, "speed": 0.0, "torque": 0.0}, {"T8": 29.0}
    )
    assert stepper.state()["start"][at] == pytest.approx(23.0)


@pytest.mark.long
def test_parts_that_no_sensor_starts_are_named_with_their_place(
    jig_borer_lumps, told_wrong, tmp_path
):
    few = ("windage", "natural_convection")
    without = [name for name in catalogue() if name not in few]
    runs = warm_runs(jig_borer_lumps)
    judged, faults = answer(told_wrong, runs[:3], runs[3:], Search(without, workers=1))
    table = report_of(judged, faults)
    assert table["verdict"] == "effect"
    (effect,) = table["effects"]
    assert effect["name"] == "start_state"
    assert set(effect["place"]) & set(HIDDEN)
    gap = table["gap"]["holdout"]
    assert gap["after"] < 0.4 * gap["before"]
    assert "starts at another temperature" in five_lines(table)[0]
    after = judged.result.after.machine
    moved = [
        n.name for n, o in zip(after.nodes, told_wrong.nodes, strict=True) if n.start != o.start
    ]
    assert moved == effect["place"]
    # Told rightly, nothing of the kind is said.
    sound, _ = answer(jig_borer_lumps, runs[:3], runs[3:], Search(without, workers=1))
    assert sound.result.keys == ()
    assert sound.verdict == "none_missing"
    assert np.isfinite(gap["reference"])
