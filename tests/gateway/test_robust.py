"""Gateways as processes that are stopped, hung up, or told that the machine is cold."""

import contextlib
import os
import signal
import socket
import time
from pathlib import Path

import pytest

from scenarios.cli import main
from tests.gateway.bench import WARM
from tests.gateway.bus import Control, Wire
from tests.patience import until


@pytest.fixture
def arguments(shared_wire: Wire, quick_fmu: Path) -> tuple[object, ...]:
    """A gateway that steps by the machine's time."""
    bus = shared_wire.arguments()
    return ("gateway", *bus, "--compensator", quick_fmu, "--clock", "machine")


@pytest.mark.long
def test_a_gateway_that_was_stopped_answers_nothing_old_as_valid(
    shared_wire, database, arguments, start
):
    gateway = start(*arguments, "--timeout", 400)
    with contextlib.closing(Control(shared_wire, database, 1.0)) as control:
        control.settle(WARM)
        os.kill(gateway.pid, signal.SIGSTOP)
        sent: dict[float, float] = {}
        # No more than a socket keeps.
        for _ in range(30):
            answered = round(control.time_s * 1e3) % 65536 / 1e3
            control.send(control.messages(WARM))
            sent[answered] = time.monotonic()
            time.sleep(0.05)
        os.kill(gateway.pid, signal.SIGCONT)
        first = time.monotonic()
        last = [*sent][-1]
        answers = control.ear.until(lambda answer: answer["answered_time"] == last)
    queued = {float(answer["answered_time"]): answer for answer in answers}
    old = [queued[t] for t, at in sent.items() if t in queued and first - at > 0.4]
    assert len(old) > 10
    assert {answer["valid"] for answer in old} == {"invalid"}
    assert "stale" in {answer["bus_fault"] for answer in old}
    assert gateway.stop() == 0, gateway.text()


@pytest.mark.long
def test_a_full_disk_and_a_hangup_do_not_stop_it_and_its_end_is_told(
    shared_wire, database, arguments, tmp_path, start
):
    log, state = tmp_path / "frames.log", tmp_path / "no_folder" / "state.json"
    log.symlink_to("/dev/full")
    state.parent.touch()
    # A folder that is none is refused at the start, unless the user insists.
    gateway = start(*arguments, "--force", "--log", log, "--state", state, "--state-every", 0.1)
    with contextlib.closing(Control(shared_wire, database, 1.0)) as control:
        control.settle(WARM)
        for told in ("No space left", "without saving"):
            until(lambda told=told: told in gateway.text() or not control.cycle(WARM))
        os.kill(gateway.pid, signal.SIGHUP)
        for _ in range(20):
            answer = control.cycle(WARM)
        assert answer["valid"] == "valid"
        # Two interrupts end a program at once; the bus is told all the same.
        os.kill(gateway.pid, signal.SIGINT)
        os.kill(gateway.pid, signal.SIGINT)
        last = control.ear.until(lambda answer: answer["gateway_state"] == "stopping", 5.0)[-1]
        assert (last["valid"], last["dX"]) == ("invalid", "not_available")
        gateway.wait(20.0)

        gateway = start(*arguments)
        control.settle(WARM)
        os.kill(gateway.pid, signal.SIGHUP)
        last = control.ear.until(lambda answer: answer["gateway_state"] == "stopping", 5.0)[-1]
    assert last["valid"] == "invalid"
    assert gateway.wait(20.0) == 0


def test_a_service_is_alive_and_takes_a_new_reference(
    shared_wire, database, arguments, tmp_path, start, monkeypatch
):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(60.0)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "200000")
        state = tmp_path / "saved"
        saving = ("--state", state, "--state-every", 0.1)
        gateway = start(*arguments, "--timeout", 2000, *saving)
        heard = [manager.recv(1000) for _ in range(20)]
        assert heard[0] == b"READY=1"
        assert heard.count(b"WATCHDOG=1") > 5
        with contextlib.closing(Control(shared_wire, database, 1.0)) as control:
            control.settle(WARM)
            until(lambda: control.cycle(WARM) and state.exists())
            assert main(["reference", str(state)]) == 0
            wanted = {"dX": 0.0, "valid": "valid"}
            until(lambda: wanted.items() <= control.cycle(WARM).items())
        # A kernel may keep as few as ten messages that nobody has read; more are lost.
        manager.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while manager.recv(1000):
                pass
        manager.settimeout(60.0)
        assert gateway.stop() == 0, gateway.text()
        while manager.recv(1000) != b"STOPPING=1":
            pass
