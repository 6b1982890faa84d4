"""Two processes on one bus: the commands as they are used, killed, and started again."""

import contextlib
import json
import time
from itertools import pairwise
from pathlib import Path

import can
import numpy as np
import pytest

from gateway.database import COMPENSATOR, Database
from measurement.runs import read_run
from scenarios.cli import main
from scenarios.cosimulation import simulate
from scenarios.scenario import read_scenario
from tests.gateway.bench import WARM, decoded
from tests.gateway.bus import Answer, Control, Listener
from tests.gateway.conftest import SLEW_UM_PER_S, new_wire
from tests.patience import PATIENCE_S

TIMEOUT, LONG = ("--timeout", f"{1e3 * PATIENCE_S:g}"), f"{PATIENCE_S:g}"
LOCKSTEP = ("--clock", "machine", "--startup-timeout", LONG, *TIMEOUT)
WAITING = ("--wait", LONG, *TIMEOUT)
LONG_S = 100


def answers_of(log: Path, database: Database) -> dict[float, tuple[object, ...]]:
    """Return what a log's gateway sent, by the time that it answered; the last one counts."""
    frames = {frame.frame_id: frame for frame in database.of(COMPENSATOR)}
    parts: Answer = {}
    found: dict[float, tuple[object, ...]] = {}
    with can.LogReader(str(log)) as reader:
        for message in reader:
            frame = frames.get(message.arbitration_id)
            if frame is None:
                continue
            content = decoded(frame.message, message)
            parts |= content
            if "gateway_state" in content and parts["gateway_state"] == "running":
                names = ("dX", "dY", "dZ", "elongation", "yaw", "pitch", "valid", "status")
                found[float(parts["answered_time"])] = tuple(parts[name] for name in names)
    return found


def test_the_loop_of_two_processes_and_its_replay(
    shared_wire, database, shipped, tmp_path, start, capsys
):
    """The offsets are the co-simulation's; the recorded log gives the same ones again."""
    bus = [*shared_wire.arguments(), "--fmu-dir", shipped]
    run, log, again = tmp_path / "run.csv", tmp_path / "first.log", tmp_path / "again.log"
    gateway = start("gateway", *bus, *LOCKSTEP, "--until-off", "--json", "--log", log)
    machine = ["machine", *map(str, bus), "--speed-up", "max", *WAITING]
    more = ["--set", f"duration_s={LONG_S}", "--set", "signals.speed=9000", "--out", str(run)]
    assert main([*machine, "step_speed", *more, "--json", "--quiet"]) == 0
    assert gateway.wait() == 0, gateway.text()
    summary = json.loads(capsys.readouterr().out)
    assert summary["answered"] == summary["steps"] == LONG_S
    frames = json.loads(gateway.text()[gateway.text().index("{\n") :])["frames"]
    assert set(frames) == {"good", "startup"}

    overrides = [("duration_s", LONG_S), ("signals.speed", 9000)]
    case = read_scenario("step_speed", overrides).cases[0]
    direct = simulate(case, shipped / "plant.fmu", shipped / "compensator.fmu", quiet=True).frame
    over_can = read_run(run).frame
    for axis in "XYZ":
        difference = direct[f"d{axis}_um"].to_numpy() - over_can[f"d{axis}_um"].to_numpy()
        assert np.abs(difference).max() <= 0.01 + 1e-9
    assert direct["dZ_um"].abs().max() > 1.0

    # Nothing proves that a recording is fresh.
    gateway = start("gateway", *bus, *LOCKSTEP, "--until-off", "--log", again, "--freshness", "any")
    assert main([*machine, "--replay", str(log), "--quiet"]) == 0
    assert gateway.wait() == 0, gateway.text()
    first, second = answers_of(log, database), answers_of(again, database)
    assert len(first) == LONG_S + 1
    assert second == first


def test_a_killed_gateway_comes_back_where_it_was(
    shared_wire, database, quick_fmu, tmp_path, start
):
    state = tmp_path / "state.json"
    arguments = (
        *("gateway", *shared_wire.arguments(), "--compensator", quick_fmu),
        *("--clock", "machine", "--state", state, "--state-every", 0.1),
    )
    first = start(*arguments)
    with contextlib.closing(Control(shared_wire, database, 0.5)) as control:
        control.settle(WARM, cycles=200)
        for _ in range(5):
            held = control.cycle(WARM)
            time.sleep(0.1)
        first.kill()
        assert control.ear.next(0.5) is None
        before = len(control.answers)
        start(*arguments)
        for _ in range(100):
            # Until it is there, nobody answers. A frame is left out, so that what it hears first is
            # no whole cycle, however fast it started.
            with contextlib.suppress(AssertionError):
                control.cycle(WARM, lambda messages: messages[1:], timeout_s=0.3)
            if len(control.answers) > before:
                break
        control.until_valid(WARM)
        after = control.answers[before:]
    assert after[0]["gateway_state"] != "running"
    assert after[0]["valid"] == "invalid"
    assert str(after[0]["status"]).endswith("_missing")
    for name in ("dX", "dY", "dZ"):
        values = [float(held[name]), *(float(answer[name]) for answer in after)]
        # A cycle is 0.5 s; what was missed while it was away counts as one.
        assert max(abs(b - a) for a, b in pairwise(values[1:])) <= SLEW_UM_PER_S * 1.0 + 0.02
        assert values[-1] == pytest.approx(values[0], abs=0.02)


@pytest.mark.long
def test_a_killed_machine_comes_back(shared_wire, quick_fmu, shipped, tmp_path, start):
    bus = [*shared_wire.arguments(), "--fmu-dir", shipped]
    state = tmp_path / "plant.json"
    machine_arguments = (
        *("machine", "step_speed", *bus, "--speed-up", 10, "--state", state),
        *("--state-every", 0.2, "--set", "signals.speed=9000", "--set", "plant.noise=false"),
    )
    gateway = start("gateway", *bus, "--compensator", quick_fmu, "--speed-up", 10)
    first = start(*machine_arguments)
    with contextlib.closing(Listener(shared_wire)) as listener:
        listener.until(lambda answer: answer["valid"] == "valid")
        # Until it has saved its state, heard as they come: what is in the queue answers no kill.
        started = time.monotonic()
        listener.until(
            lambda answer: (
                answer["valid"] == "valid" and state.exists() and time.monotonic() - started > 1.0
            )
        )
        first.kill()
        listener.until(lambda answer: answer["valid"] == "invalid")
        silent = listener.until(lambda answer: answer["status"] == "zero_missing")
        assert all(answer["valid"] == "invalid" for answer in silent)
        assert silent[-1]["dZ"] == 0.0
        second = start(*machine_arguments)
        listener.until(lambda answer: answer["valid"] == "valid")
    assert "goes on at" in second.text()
    assert second.stop() == 0, second.text()
    assert gateway.stop() == 0, gateway.text()


def test_a_machine_without_a_gateway_runs_all_the_same(shipped, tmp_path, capsys):
    run = tmp_path / "alone.csv"
    command = ["machine", "step_speed", *new_wire("virtual").arguments(), "--json", "--quiet"]
    command += ["--fmu-dir", str(shipped), "--speed-up", "10", "--wait", "0.2"]
    assert main([*command, "--set", "duration_s=10", "--out", str(run)]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["answered"], summary["steps"]) == (0, 10)
    assert (read_run(run).frame["dX_um"] == 0.0).all()
