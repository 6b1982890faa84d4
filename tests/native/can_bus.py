"""A host for a compensator with a CAN terminal: a machine's frames, and a bus that delivers them.

Beside the FMU runs the gateway's own node with the same compensator and the same frames at the same
times; what the two send must be the same bytes.
"""

import json
import shutil
import struct
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import accumulate, repeat
from math import exp, inf, nan, sin
from pathlib import Path
from typing import Any

import can
import fmpy
from fmpy.fmi3 import FMU3Slave, fmi3Float64, fmi3IntervalQualifier, fmi3ValueReference

from gateway.codec import Sender, decode
from gateway.database import COMPENSATOR, MACHINE, Database
from gateway.dbc import DBC
from gateway.mapping import read_database
from gateway.node import GatewayNode, GatewaySettings
from gateway.proof import LARGEST_ECHO
from gateway.unit import CompensatorUnit
from tests.gateway.bench import told_by_machine
from tests.masters.conftest import run

TRANSMIT, CONFIRM, FORMAT_ERROR, CONFIGURATION = 0x10, 0x20, 0x01, 0x40
CHANGED = 2
Operation = tuple[int, bytes]
"""Code and content."""
NESTED = """
from fmpy import simulate_fmu
from fmu_manipulation_toolbox.cli.fmucontainer import fmucontainer
fmucontainer()
simulate_fmu("bus.fmu", stop_time=2.0, output_interval=0.5)
"""


def transmitted(frame_id: int, data: bytes) -> bytes:
    content = struct.pack("<IBBH", frame_id, 0, 0, len(data)) + data
    return struct.pack("<II", TRANSMIT, 8 + len(content)) + content


def operations(data: bytes) -> Iterator[Operation]:
    while data:
        code, length = struct.unpack_from("<II", data)
        yield code, data[8:length]
        data = data[length:]


def frame_of(content: bytes) -> tuple[int, bytes]:
    frame_id, extended, remote, length = struct.unpack_from("<IBBH", content)
    assert (extended, remote, length) == (0, 0, len(content) - 8)
    return frame_id, content[8:]


def opened(path: Path, folder: Path) -> tuple[Any, FMU3Slave]:
    """Return an FMU's description, and an instance in its first event mode."""
    description = fmpy.read_model_description(str(path))
    fmu = FMU3Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(path), str(folder)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="node",
    )
    fmu.instantiate(eventModeUsed=True, loggingOn=True)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return description, fmu


def log_of_two(fmu: Path, folder: Path, *link: str) -> Path:
    """Let another tool link an FMU with itself, by two names, and simulate both; return its log."""
    for name in ("a.fmu", "b.fmu"):
        shutil.copy(fmu, folder / name)
    start, end = link
    nested = {
        "name": "bus.fmu",
        "fmu": ["a.fmu", "b.fmu"],
        "step_size": 0.01,
        "link": [["a.fmu", start, "b.fmu", end]],
        "auto_output": False,
        "output": [["a.fmu", "status", "status"]],
    }
    (folder / "bus.json").write_text(json.dumps(nested))
    options = ("-container", "bus.json", "-fmi", "3", "-datalog")
    done = run(sys.executable, "-c", NESTED, *options, folder=folder)
    assert done.returncode == 0, done.stderr
    return folder / "bus-datalog.csv"


class BusNode:
    """The FMU: bus operations in and out, at any time."""

    def __init__(self, path: Path, folder: Path) -> None:
        description, self.fmu = opened(path, folder)
        self.refs = {v.name: v.valueReference for v in description.modelVariables}
        self.time_s, self.due_s = 0.0, inf
        self._ask()
        self.fmu.enterStepMode()

    def __getattr__(self, name: str) -> int:
        return self.refs[f"CAN.{name}"]

    def _ask(self) -> None:
        interval, qualifier = (fmi3Float64 * 1)(), (fmi3IntervalQualifier * 1)()
        self.fmu.getIntervalDecimal((fmi3ValueReference * 1)(self.Tx_Clock), interval, qualifier)
        if qualifier[0] == CHANGED:
            assert interval[0] > 0.0
            self.due_s = self.time_s + interval[0]

    def _go_to(self, time_s: float) -> None:
        if time_s > self.time_s:
            self.fmu.doStep(self.time_s, time_s - self.time_s)
        self.time_s = time_s
        self.fmu.enterEventMode()

    def receive(self, time_s: float, data: bytes) -> None:
        self._go_to(time_s)
        self.fmu.setClock([self.Rx_Clock], [True])
        self.fmu.setBinary([self.Rx_Data], [data])
        self._end()

    def send(self) -> bytes:
        self._go_to(self.due_s)
        self.fmu.setClock([self.Tx_Clock], [True])
        (data,) = self.fmu.getBinary([self.Tx_Data])
        self._end()
        return bytes(data)

    def _end(self) -> None:
        self.fmu.updateDiscreteStates()
        self._ask()
        self.fmu.enterStepMode()

    def value(self, name: str) -> float:
        return float(self.fmu.getFloat64([self.refs[name]])[0])

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


def challenges() -> Callable[[], int]:
    """Return what draws the FMU's challenges, one after the other."""
    drawn = accumulate(repeat(1), lambda last, _: (last * 1664525 + 1013904223) & 0xFFFFFFFF)
    next(drawn)
    return filter(lambda one: one & 0xFFFF <= LARGEST_ECHO, drawn).__next__


WRONG_VALUES: dict[str, dict[str, float | str]] = {
    "value": {"T1": nan, "T2": inf},
    "stopped": {"machine_state": "stopping"},
    "jump": {"machine_time": 5000.0},
    "stands": {"machine_step": 0.0},
}
FOREIGN = can.Message(arbitration_id=0x1A0, data=bytes(8), is_extended_id=False)
DAMAGE: dict[str, Callable[[list[can.Message]], object]] = {
    "silence": list.clear,
    "lost": lambda messages: messages.pop(2),
    "lost closing": list.pop,
    "again": lambda messages: messages.insert(2, messages[1]),
    "foreign": lambda messages: messages.insert(2, FOREIGN),
}
FAULTS = (*WRONG_VALUES, *DAMAGE, "stale", "damaged", "short", "old")


def spoil(messages: list[can.Message], before: list[can.Message], fault: str) -> None:
    """Do to a cycle's frames what a fault does; *before* are those of the cycle before."""
    DAMAGE.get(fault, list.copy)(messages)
    if fault == "damaged":
        messages[3].data[4] ^= 0x10
    elif fault == "short":
        messages[3].data, messages[3].dlc = messages[3].data[:6], 6
    elif fault == "old":
        messages[1:2] = before[1:2]


@dataclass
class Machine:
    """A control that warms up, and that answers challenges."""

    database: Database
    cycle_s: float
    heard: int | None = None
    sender: Sender = field(init=False)

    def __post_init__(self) -> None:
        self.sender = Sender(self.database, MACHINE)

    def values(self, time_s: float) -> dict[str, float | str]:
        warm = 1.0 - exp(-time_s / 900.0)
        rises = {f"T{n}": 20.0 + n * warm + 0.3 * sin(time_s / 40.0 + n) for n in range(1, 12)}
        return told_by_machine("running", time_s, self.cycle_s) | {
            **rises,
            "speed": 6000.0 if time_s > 2.0 else 0.0,
            "tool_length": 150.0 + 50.0 * (time_s % 60.0 > 30.0),
            "thermal_state": "cold" if time_s < 1.0 else "warm",
        }

    def cycle(self, time_s: float, changed: Mapping[str, float | str]) -> list[can.Message]:
        return self.sender.messages({**self.values(time_s), **changed}, self.heard)


class Gateway:
    """The gateway's own node with an FMU's compensator, and the machine that both hear."""

    def __init__(self, database: Database, compensator: Path) -> None:
        self.database, self.unit = database, CompensatorUnit(compensator)
        self.unit.start()
        self.cycle_s = database.closing(MACHINE).cycle_s
        self.machine = Machine(database, self.cycle_s)
        self.expected: list[can.Message] = []
        settings = GatewaySettings(machine_clock=True)
        self.gateway = GatewayNode(database, self.unit, self.expected.extend, settings, 0.0)
        self.gateway._challenges._new = challenges()


class Bench(Gateway):
    """The FMU and the gateway on one bus with a machine."""

    def __init__(self, node: BusNode, compensator: Path, dbc: Path = DBC) -> None:
        super().__init__(read_database(dbc), compensator)
        self.node = node
        self._names = {frame.frame_id: frame for frame in self.database.of(COMPENSATOR)}
        self.frames, self.answers = 0, 0
        self.seen: set[tuple[float, float]] = set()

    def deliver(self, time_s: float, messages: Iterable[can.Message]) -> None:
        """Bring frames to both at a time; what is due before is sent first."""
        while self.node.due_s < time_s:
            self.tick()
        data = b""
        for message in messages:
            data += transmitted(message.arbitration_id, bytes(message.data))
            self.gateway.handle(message, time_s)
        self.node.receive(time_s, data)

    def tick(self) -> None:
        """Let the FMU send, and hold it against what the gateway sends."""
        at_s = self.node.due_s
        if not self.expected:
            # The FMU's first tick, too, comes after a time: no interval is nought.
            late_s = at_s - self.gateway.deadline()
            assert abs(late_s) < 1e-9 or (at_s < 0.001 and late_s > 0.0), late_s
            self.gateway.tick(at_s)
        sent = [entry for entry in operations(self.node.send()) if entry[0] == TRANSMIT]
        found = [frame_of(content) for _, content in sent]
        assert found == [(m.arbitration_id, bytes(m.data)) for m in self.expected], at_s
        self.expected.clear()
        self.frames, self.answers = self.frames + len(found), self.answers + 1
        told = {}
        for frame_id, data in found:
            told |= decode(self._names[frame_id], data).values
        if told["challenge"] == told["challenge"]:
            self.machine.heard = int(told["challenge"])
        self.seen.add((told["gateway_state"], told["bus_fault"]))

    def run(self, cycles: int, faults: Mapping[int, str] | None = None) -> None:
        """Run cycles of the machine, with a fault in some."""
        before: list[can.Message] = []
        for count in range(1, cycles + 1):
            time_s = count * self.cycle_s
            fault = (faults or {}).get(count, "")
            if fault == "stale":
                self.machine.heard = 12345
            messages = self.machine.cycle(time_s, WRONG_VALUES.get(fault, {}))
            spoil(messages, before, fault)
            before = messages
            if messages:
                self.deliver(time_s, messages)
        while self.expected:
            self.tick()
