"""Gateways and controls on a real bus, for tests."""

import contextlib
import multiprocessing
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import cantools

from gateway.codec import Sender, Value
from gateway.database import COMPENSATOR, MACHINE, Database
from gateway.dbc import DBC
from gateway.framelog import FrameLog
from gateway.link import Link
from gateway.node import GatewaySettings
from gateway.protocols.base import Participant
from gateway.serving import Service
from gateway.unit import CompensatorUnit
from scenarios.cli import main
from tests.gateway.bench import decoded, proven, told_by_machine

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 60.0
SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload(["pytest", __name__, "gateway.commands.gateway"])
Answer = dict[str, float | str]


@dataclass(frozen=True)
class Wire:
    """A bus to test on: python-can's names for it."""

    interface: str
    channel: str
    options: dict[str, Any] = field(default_factory=dict)

    def arguments(self) -> list[str]:
        """Return it as arguments of the command line."""
        found = ["--interface", self.interface, "--channel", self.channel]
        for name, value in self.options.items():
            found += ["--option", f"{name}={value}"]
        return found

    def open(self, **more: Any) -> can.BusABC:
        """Return a node of its own on this bus."""
        return can.Bus(interface=self.interface, channel=self.channel, **(self.options | more))


class Listener:
    """A third node that decodes by the DBC file and cantools alone."""

    def __init__(self, wire: Wire) -> None:
        self.bus = wire.open()
        self.dbc = cantools.database.load_file(DBC)
        self.known = {message.frame_id: message for message in self.dbc.messages}
        self.challenge: int | None = None
        self.parts: Answer = {}

    def next(self, timeout_s: float = PATIENCE_S) -> tuple[can.Message, Answer] | None:
        """Return the next of our frames and its content; None if none comes."""
        until = time.monotonic() + timeout_s
        while True:
            message = self.bus.recv(max(until - time.monotonic(), 0.0))
            if message is None:
                return None
            if message.arbitration_id in self.known:
                if message.is_error_frame or message.is_extended_id or len(message.data) != 8:
                    continue
                plain = decoded(self.known[message.arbitration_id], message)
                self.challenge = plain.get("challenge", self.challenge)
                return message, plain

    def until(
        self, wanted: Callable[[Answer], bool], timeout_s: float = PATIENCE_S
    ) -> list[Answer]:
        """Gather the gateway's answers until one is as wanted; fail if none comes in time."""
        until = time.monotonic() + timeout_s
        found: list[Answer] = []
        while (left := until - time.monotonic()) > 0.0:
            got = self.next(left)
            if got is None:
                break
            found += self._whole(*got)
            if found and wanted(found[-1]):
                return found
        shown = found[-1] if found else "nothing"
        raise AssertionError(f"not seen in {timeout_s:g} s; the last answer is {shown}")

    def _whole(self, message: can.Message, content: Answer) -> list[Answer]:
        """Return the answer that a frame ends; one whose beginning was not heard is left out."""
        if self.known[message.arbitration_id].senders != [COMPENSATOR]:
            return []
        self.parts |= content
        if "gateway_state" not in content:
            return []
        whole, self.parts = self.parts, {}
        return [whole] if "dX" in whole else []

    def waiting(self) -> list[Answer]:
        """Return the answers that wait to be read; the newest challenge is known then."""
        found: list[Answer] = []
        while (got := self.next(0.0)) is not None:
            found += self._whole(*got)
        return found

    def close(self) -> None:
        """Leave the bus."""
        self.bus.shutdown()


class Control:
    """A control in the test's hands: sends cycles, and takes in the answers."""

    def __init__(self, wire: Wire, database: Database, step_s: float) -> None:
        self.ear = Listener(wire)
        self.sender, self.database = Sender(database, MACHINE), database
        self.time_s, self.step_s = 0.0, step_s
        self.answers: list[Answer] = []

    def messages(self, values: Mapping[str, Value], state: str = "running") -> list[can.Message]:
        """Return the messages of the next cycle."""
        step_s = self.step_s if state == "running" else 0.0
        told = told_by_machine(state, self.time_s, step_s) | dict(values)
        self.time_s = round(self.time_s + step_s, 3)
        return self.sender.messages(told, self.ear.challenge)

    def send(self, messages: list[can.Message]) -> None:
        """Send messages as they are."""
        for message in messages:
            self.ear.bus.send(message)

    def cycle(
        self,
        values: Mapping[str, Value],
        change: Callable[[list[can.Message]], list[can.Message]] = lambda messages: messages,
        state: str = "running",
        timeout_s: float = PATIENCE_S,
    ) -> Answer:
        """Run one cycle and return the answer to it, or to the silence that it was."""
        self.answers += self.ear.waiting()
        messages = change(self.messages(values, state))
        if getattr(change, "by_sender", False):
            messages = proven(self.database, messages, self.ear.challenge)
        self.send(messages)
        self.answers += self.ear.until(lambda answer: True, timeout_s)
        return self.answers[-1]

    def settle(self, values: Mapping[str, Value], cycles: int = 60) -> Answer:
        """Begin, and go on until the offsets are valid."""
        for _ in range(50):
            if self.cycle({}, state="starting")["bus_fault"] == "machine_not_running":
                break
        # What the gateway said before it was in touch is still waiting to be read.
        until = time.monotonic() + 0.3
        while (left := until - time.monotonic()) > 0.0:
            self.ear.bus.recv(left)
        for _ in range(3):
            self.cycle({})  # the first may come late, after this pause
        for _ in range(cycles):
            answer = self.cycle(values)
            if answer["status"] == "ok" and answer["dX"] == self.answers[-2]["dX"] != 0.0:
                return answer
        raise AssertionError(f"not valid after {cycles} cycles: {self.answers[-1]}")

    def until_valid(self, values: Mapping[str, Value]) -> Answer:
        """Go on until the offsets are valid again."""
        for _ in range(100):
            if self.cycle(values)["valid"] == "valid":
                return self.answers[-1]
        raise AssertionError(f"not valid again: {self.answers[-1]}")

    def close(self) -> None:
        """Leave the bus."""
        self.ear.close()


@contextlib.contextmanager
def gateway_thread(
    wire: Wire,
    database: Database,
    fmu: Path,
    settings: GatewaySettings,
    *,
    log: Path | None = None,
    said: list[str] | None = None,
    ends_with: type[Exception] | None = None,
    participants: Sequence[Participant] = (),
) -> Iterator[Service]:
    """A gateway on the bus in a thread of this process; what it says goes into *said*."""
    lines = [] if said is None else said
    ids = [frame.frame_id for frame in database.frames]
    frames = log and FrameLog(log, lines.append)
    link = Link(wire.interface, wire.channel, ids, frames, lines.append, options=dict(wire.options))
    link.open()
    unit = CompensatorUnit(fmu)
    done, problems = threading.Event(), []
    service = Service(database, fmu, unit, link, settings, stopped=done.is_set, say=lines.append)
    service.participants.extend(participants)

    def run() -> None:
        try:
            service.run()
        except BaseException as error:
            problems.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield service
    finally:
        done.set()
        thread.join(PATIENCE_S)
        link.close()
        unit.close()
    assert not thread.is_alive()
    if ends_with is not None:
        assert [type(problem) for problem in problems] == [ends_with]
    elif problems:
        raise problems[0]


def _command(arguments: list[str], output: Path, environment: dict[str, str]) -> None:
    """Run a command as the main program of a process does."""
    os.environ.update(environment)
    os.chdir(ROOT)
    for number, place in enumerate((os.devnull, output, output)):
        os.dup2(os.open(place, os.O_RDWR | os.O_APPEND), number)
    sys.exit(main(arguments))


class Program:
    """A command of spindle-drift as a process of its own.

    The process is a fork of one that has imported what a command needs, which takes two seconds.
    """

    def __init__(self, folder: Path, *arguments: object) -> None:
        self.arguments = [str(argument) for argument in arguments]
        self._output = folder / f"{self.arguments[0]}-{time.monotonic_ns()}.txt"
        self._output.touch()
        given = (self.arguments, self._output, dict(os.environ))
        self._process = SERVER.Process(target=_command, args=given)
        self._process.start()

    @property
    def pid(self) -> int:
        """Its process."""
        assert self._process.pid
        return self._process.pid

    def text(self) -> str:
        """Return what it has printed so far."""
        return self._output.read_text("utf-8")

    def kill(self) -> None:
        """End it without a chance to clean up, as kill -9 does."""
        self._process.kill()
        self.wait(PATIENCE_S)

    def stop(self) -> int:
        """Ask it to end and return its exit code."""
        self._process.terminate()
        return self.wait(PATIENCE_S)

    def wait(self, timeout_s: float = 120.0) -> int:
        """Wait for its end and return its exit code."""
        self._process.join(timeout_s)
        assert self._process.exitcode is not None
        return self._process.exitcode

    def close(self) -> None:
        """Make sure that it is gone."""
        if self._process.is_alive():
            self.kill()
