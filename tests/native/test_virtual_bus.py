"""A bus with the plant and two compensators: each hears the machine and leaves the other alone."""

import re
from collections.abc import Sequence
from heapq import heappop, heappush
from math import inf, nan
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi2 import FMU2Slave

import build_fmu
from gateway.busload import frame_bits
from gateway.codec import decode
from gateway.database import COMPENSATOR, MACHINE, Database
from gateway.dbc import DBC
from gateway.mapping import read_database
from tests.native.can_bus import TRANSMIT, BusNode, Machine, frame_of, operations, transmitted

SHIFT = 16  # between the identifiers of the two compensators
SPEED, TOOL_LENGTH_MM = 9000.0, 240.0
OFFSETS = ("dX", "dY", "dZ")


class Plant(Machine):
    """A machine whose readings are the plant's, and whose offsets are those heard."""

    def __init__(self, path: Path, folder: Path, database: Database) -> None:
        super().__init__(database, database.closing(MACHINE).cycle_s)
        description = fmpy.read_model_description(str(path))
        self.refs = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(path), str(folder)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="plant",
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.put({"tool_length": TOOL_LENGTH_MM})
        self.fmu.exitInitializationMode()
        self.offsets = dict.fromkeys(OFFSETS, nan)

    def put(self, values: dict[str, float]) -> None:
        self.fmu.setReal([self.refs[name] for name in values], list(values.values()))

    def get(self, name: str) -> float:
        return float(self.fmu.getReal([self.refs[name]])[0])

    def values(self, time_s: float) -> dict[str, float | str]:
        known = {name: value for name, value in self.offsets.items() if value == value}
        self.put({"speed": SPEED, **known})
        self.fmu.doStep(time_s - self.cycle_s, self.cycle_s)
        readings = {f"T{number}": self.get(f"T{number}") for number in range(1, 12)}
        told = {"speed": SPEED, "tool_length": TOOL_LENGTH_MM}
        return super().values(time_s) | readings | told

    def hear(self, values: dict[str, float]) -> None:
        self.offsets |= {name: values[name] for name in OFFSETS if name in values}
        if values.get("challenge", nan) == values.get("challenge"):
            self.heard = int(values["challenge"])


class Bus:
    """One frame at a time, the lowest identifier first; everybody but its sender hears it."""

    def __init__(self, machine: Plant, nodes: Sequence[BusNode], database: Database) -> None:
        self.machine, self.nodes, self.database = machine, nodes, database
        self.frame_s = frame_bits(8) / database.bit_rate
        self.waiting: list[tuple[int, bytes, int]] = []
        self.ends_s, self.cycles = inf, 1
        self.sent: list[list[dict[str, float]]] = [[] for _ in nodes]
        self.frames = {frame.frame_id: frame for frame in database.of(COMPENSATOR)}

    def run(self, until_s: float) -> None:
        while True:
            cycle_s = self.cycles * self.machine.cycle_s
            now_s = min(self.ends_s, cycle_s, *(node.due_s for node in self.nodes))
            if now_s > until_s:
                return
            if now_s == self.ends_s:
                self._deliver(now_s)
            elif now_s == cycle_s:
                self.cycles += 1
                for message in self.machine.cycle(now_s, {}):
                    heappush(self.waiting, (message.arbitration_id, bytes(message.data), -1))
            else:
                number = min(range(len(self.nodes)), key=lambda k: self.nodes[k].due_s)
                for code, content in operations(self.nodes[number].send()):
                    if code == TRANSMIT:
                        heappush(self.waiting, (*frame_of(content), number))
            if self.ends_s == inf and self.waiting:
                self.ends_s = now_s + self.frame_s

    def _deliver(self, now_s: float) -> None:
        frame_id, data, sender = heappop(self.waiting)
        for number, node in enumerate(self.nodes):
            if number != sender:
                node.receive(now_s, transmitted(frame_id, data))
        if sender >= 0:
            own = self.frames[frame_id - SHIFT * sender]
            values = {
                name: value for name, value in decode(own, data).values.items() if value == value
            }
            self.sent[sender].append(values)
            if sender == 0:
                self.machine.hear(values)
        self.ends_s = now_s + self.frame_s if self.waiting else inf


@pytest.mark.long
@pytest.mark.long
def test_two_compensators_and_the_plant_share_a_bus(shipped_in_c, tmp_path):
    text = DBC.read_text("utf-8")
    database = read_database(DBC)
    for frame in database.of(COMPENSATOR):
        text = re.sub(rf"\b{frame.frame_id}\b", str(frame.frame_id + SHIFT), text)
    (tmp_path / "second.dbc").write_text(text)
    options = ["--can", "--out", str(tmp_path)]
    assert build_fmu.main(options) == 0
    second = ["--dbc", str(tmp_path / "second.dbc"), "--name", "second"]
    assert build_fmu.main([*options, *second]) == 0
    nodes = [
        BusNode(next(tmp_path.glob(f"{name}*.fmu")), tmp_path / name)
        for name in ("compensator", "second")
    ]
    plant = Plant(shipped_in_c / "plant_native.fmu", tmp_path / "plant", database)
    bus = Bus(plant, nodes, database)
    bus.run(300.0)
    assert bus.sent[0] == bus.sent[1][: len(bus.sent[0])]
    assert len(bus.sent[0]) > 7 * 3000
    assert abs(plant.get("drift_Z")) > 2.0
    assert abs(plant.get("error_Z")) < 0.3 * abs(plant.get("drift_Z"))
