"""Probes on the bus: taken once, in their cycle, or not at all."""

import contextlib
from collections.abc import Callable, Iterator
from math import isnan, nan
from pathlib import Path

import can
import numpy as np
import pytest

from gateway.database import MACHINE, Database
from gateway.node import GatewaySettings
from gateway.probes import COUNTED, ProbeSender
from gateway.unit import CompensatorUnit
from measurement.runs import read_run
from scenarios.cli import main
from scenarios.cosimulation import simulate
from scenarios.scenario import read_scenario
from tests.gateway.bench import Bench
from tests.gateway.bus import gateway_thread
from tests.gateway.conftest import new_wire
from tests.patience import PATIENCE_S

# Small enough to be believed at once.
SHOWN = {"elongation": 0.4, "yaw": 1.0, "pitch": -1.0, "near_x": 0.4, "near_y": -0.3}
MEASURED = {f"measured_{name}": value for name, value in SHOWN.items()}
Change = Callable[[list[can.Message]], list[can.Message]]


@pytest.fixture
def probed(database: Database, shipped: Path) -> Iterator[Bench]:
    """A gateway with the shipped compensator, which takes probes."""
    with contextlib.closing(CompensatorUnit(shipped / "compensator.fmu")) as unit:
        bench = Bench(database, unit)
        bench.begin()
        bench.cycles(30)
        assert bench.last["valid"] == "valid"
        yield bench


class Probe:
    """Probes of one control for the bench."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.sender = ProbeSender(bench.database.events(MACHINE))

    def frames(self, measured: dict[str, float], late_s: float = 0.0) -> list[can.Message]:
        """Return the frames of a probe of the cycle that was made last."""
        self.sender.start(measured, 0.0)
        return self.sender.messages(self.bench.time_s - self.bench.step_s - late_s, 0.0)

    def cycle(self, measured: dict[str, float], late_s: float = 0.0) -> dict[str, float | str]:
        """Run a cycle with a probe before it."""
        return self.bench.cycle({}, lambda m: [*self.frames(measured, late_s), *m])


def test_a_probe_reaches_the_compensator(probed):
    given, step = [], probed.unit.step

    def watched(values: dict[str, float], step_s: float) -> dict[str, float]:
        given.append({name: value for name, value in values.items() if name in MEASURED})
        return step(values, step_s)

    probed.unit.step = watched
    Probe(probed).cycle(MEASURED)
    probed.cycle()
    assert [values for values in given if values] == [pytest.approx(MEASURED, abs=0.01)]


def test_one_probe_counts_once_however_often_it_comes(probed):
    sender = ProbeSender(probed.database.events(MACHINE))
    sender.start(MEASURED, 0.0)
    time_s = probed.time_s
    probed.cycles(2, {}, lambda m: [*sender.messages(time_s, 0.0), *m])
    assert probed.last["probes_taken"] == 1
    assert sender.messages(0.0, 1.0) == []  # it has been taken
    probe = Probe(probed)
    for k in range(2, 7):
        answer = probe.cycle(MEASURED)
        assert answer["probes_taken"] == k % COUNTED


def spoilt(messages: list[can.Message]) -> list[can.Message]:
    """Change a byte behind the CRC's back."""
    messages[0].data[3] ^= 1
    return messages


def other_count(messages: list[can.Message]) -> list[can.Message]:
    """Leave the second half out."""
    return messages[:1]


@pytest.mark.parametrize("change", [spoilt, other_count])
def test_a_damaged_probe_is_not_used(probed, change):
    before = probed.last["dZ_uncertainty"]
    probed.cycle({}, lambda m: [*change(Probe(probed).frames(MEASURED)), *m])
    assert probed.last["probes_taken"] == 0
    assert probed.last["dZ_uncertainty"] == pytest.approx(before, abs=0.02)
    assert probed.last["valid"] == "valid"


@pytest.mark.parametrize("late_s", [0.5, 5.0, 60.0])
def test_a_probe_that_waited_is_not_used(probed, late_s):
    assert Probe(probed).cycle(MEASURED, late_s)["probes_taken"] == 0
    assert any("old" in line for line in probed.said)


def test_half_a_probe_is_not_used(probed):
    assert Probe(probed).cycle(MEASURED | {"measured_near_y": nan})["probes_taken"] == 0
    assert any("measured_near_y is missing" in line for line in probed.said)


def test_a_probe_waits_for_a_cycle_that_can_be_used(probed):
    sender = ProbeSender(probed.database.events(MACHINE))
    sender.start(MEASURED, 0.0)

    def probing(messages: list[can.Message]) -> list[can.Message]:
        return [*sender.messages(probed.time_s - probed.step_s, 0.0), *messages]

    for _ in range(2):
        assert probed.cycle({}, lambda m: probing(m[1:]))["probes_taken"] == 0
    assert 1 in {answer["probes_taken"] for answer in probed.cycles(20, {}, probing)}


def test_nobody_takes_it_and_the_control_gives_up(database):
    sender = ProbeSender(database.events(MACHINE))
    sender.start(MEASURED, nan)
    sent = [bool(sender.messages(5.0 + 10.0 * k, nan)) for k in range(8)]
    assert sent == [True] * 6 + [False] * 2


def test_the_machine_probes_as_the_co_simulation_does(database, shipped, tmp_path):
    wire, run = new_wire("virtual"), tmp_path / "run.csv"
    settings = {"duration_s": 120.0, "signals.speed": 9000, "compensator.probe.when_um": 0.5}
    clock = GatewaySettings(machine_clock=True, timeout_s=PATIENCE_S)
    plant, compensator = shipped / "plant.fmu", shipped / "compensator.fmu"
    with gateway_thread(wire, database, compensator, clock) as service:
        command = ["machine", "step_speed", *wire.arguments(), "--fmu-dir", str(shipped)]
        command += ["--timeout", f"{1e3 * PATIENCE_S:g}", "--speed-up", "max", "--out", str(run)]
        assert main([*command, *(f"--set={name}={value}" for name, value in settings.items())]) == 0
    case = read_scenario("step_speed", [*settings.items(), ("record_s", 1.0)]).cases[0]
    direct = simulate(case, plant, compensator, quiet=True).frame
    assert service.node.probes.taken == direct["measured_1"].sum() >= 1
    over_can = read_run(run).frame
    for axis in "XYZ":
        apart = np.abs(direct[f"d{axis}_um"].to_numpy() - over_can[f"d{axis}_um"].to_numpy())
        # A probe is rounded to 0.02 um on its way, and so is an offset.
        assert apart.max() <= 0.04
    assert not isnan(float(direct["dZ_um"].iloc[-1]))
