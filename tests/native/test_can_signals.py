"""The compensator with its signals as variables: beside the gateway, and beside the plain FMU."""

from collections.abc import Mapping
from math import isnan
from pathlib import Path
from xml.etree import ElementTree as ET
from zipfile import ZipFile

import fmpy
import pandas as pd
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from gateway.codec import Value, decode
from gateway.database import COMPENSATOR, MACHINE
from gateway.dbc import DBC
from gateway.mapping import read_database
from tests.masters.conftest import needs
from tests.native.can_bus import Gateway, log_of_two, opened

BUS = "spindle_drift"
ALL = read_database(DBC)
FRAMES = ALL.unproven()
"""Those that are judged: signals need not prove that they are fresh."""
CYCLE_S = FRAMES.closing(MACHINE).cycle_s
DOWN = "CompensatorHeartbeat"


class SignalNode:
    """A host with event mode: sets signals and their clocks, and reads those that tick."""

    def __init__(self, path: Path, folder: Path) -> None:
        description, self.fmu = opened(path, folder)
        self.refs = {v.name: v.valueReference for v in description.modelVariables}
        self.sent_frames = {
            v.name: [s.name for s in description.modelVariables if s.clocks == [v]]
            for v in description.modelVariables
            if v.type == "Clock" and v.causality == "output"
        }
        self.time_s, self.due_s, self.needed = 0.0, 0.0, False
        self.sent = self.events()

    def step_to(self, time_s: float) -> None:
        if time_s > self.time_s:
            self.needed = self.fmu.doStep(self.time_s, time_s - self.time_s)[0]
        self.time_s = time_s

    def receive(
        self, time_s: float, frames: Mapping[str, Mapping[str, float]]
    ) -> list[dict[str, float]]:
        """Bring frames at a time; return what is sent at once, by names without the frame."""
        self.step_to(time_s)
        self.fmu.enterEventMode()
        for frame, values in frames.items():
            self.fmu.setClock([self.refs[f"{BUS}.{frame}_Clock"]], [True])
            refs = [self.refs[f"{BUS}.{frame}.{frame}.{name}"] for name in values]
            self.fmu.setFloat64(refs, list(values.values()))
        return self.events()

    def events(self) -> list[dict[str, float]]:
        sent, again = [], True
        while again:
            again, *_, known, next_s = self.fmu.updateDiscreteStates()
            ticked = {
                clock: bool(self.fmu.getClock([self.refs[clock]])[0]) for clock in self.sent_frames
            }
            assert set(ticked.values()) == {again}
            if again:
                names = [name for names in self.sent_frames.values() for name in names]
                values = self.fmu.getFloat64([self.refs[name] for name in names])
                sent.append(dict(zip(names, values, strict=True)))
        assert known
        self.due_s = next_s
        self.fmu.enterStepMode()
        return sent

    def value(self, name: str) -> float:
        return float(self.fmu.getFloat64([self.refs[name]])[0])


class Bench(Gateway):
    """The FMU beside the gateway; what they send must be the same."""

    def __init__(self, folder: Path, extracted: Path) -> None:
        super().__init__(FRAMES, folder / "compensator_native.fmu")
        self.node = SignalNode(folder / "compensator_can_high.fmu", extracted)
        self.faults: set[float] = set()
        self.gateway.tick(0.0)
        self.compare(self.node.sent)

    def compare(self, sent: list[dict[str, float]]) -> None:
        names = {frame.frame_id: frame for frame in FRAMES.of(COMPENSATOR)}
        wanted: list[dict[str, float]] = []
        for message in self.expected:
            frame = names[message.arbitration_id]
            if frame is FRAMES.of(COMPENSATOR)[0]:
                wanted.append({})
            content = decode(frame, bytes(message.data))
            own = {"crc": float(message.data[0]), "counter": float(message.data[1] & 0x0F)}
            for name, value in {**content.values, **own, "cycle": float(content.cycle)}.items():
                wanted[-1][f"{BUS}.{frame.name}.{frame.name}.{name}"] = value
        assert sent == [pytest.approx(one, abs=1e-9, nan_ok=True) for one in wanted]
        self.expected.clear()
        self.faults |= {one[f"{BUS}.{DOWN}.{DOWN}.bus_fault"] for one in sent}

    def cycle(self, count: int, lost: str = "", **changed: Value) -> None:
        """One of the machine, without a frame or with other values."""
        time_s = count * CYCLE_S
        values = {**self.machine.values(time_s), **changed}
        messages = self.machine.sender.messages(values)
        numbers = {
            name: float(signal.codes[value]) if isinstance(value, str) else value
            for name, value in values.items()
            for signal in [FRAMES.signal(name)]
        }
        frames = {frame.name: frame for frame in FRAMES.of(MACHINE) if frame.name != lost}
        self.wait(time_s)
        for message in messages:
            if message.arbitration_id in {frame.frame_id for frame in frames.values()}:
                self.gateway.handle(message, time_s)
        if self.gateway.deadline() < time_s + 1e-6:
            self.gateway.tick(time_s)
        self.compare(
            self.node.receive(
                time_s,
                {name: {s: numbers[s] for s in frame.signals} for name, frame in frames.items()},
            )
        )

    def wait(self, time_s: float) -> None:
        while self.node.due_s < time_s - 1e-6:
            due_s = self.node.due_s
            assert due_s == pytest.approx(self.gateway.deadline())
            self.gateway.tick(due_s)
            self.compare(self.node.receive(due_s, {}))


@pytest.fixture
def bench(by_hand: Path, tmp_path: Path) -> Bench:
    return Bench(by_hand, tmp_path)


def test_it_sends_what_the_gateway_sends_also_of_what_is_missing_out_of_range_or_late(bench):
    for count in range(1, 200):
        bench.cycle(count)
        offsets = {name: bench.node.value(name) for name in ("dX", "dY", "dZ")}
        assert offsets.items() <= bench.unit.outputs.items()
    assert abs(offsets["dZ"]) > 0.1
    bench.cycle(200, T1=float("nan"), T2=1e6)
    bench.cycle(201, lost="MachineTemperatures2")
    bench.cycle(202)
    bench.cycle(203, machine_step=0.0)
    bench.cycle(204, machine_state="stopping")
    bench.cycle(205)
    bench.wait(22.0)
    for count in range(221, 260):
        bench.cycle(count)
    assert len(bench.faults) > 5


@needs("fmu-manipulation-toolbox")
def test_another_tool_asks_for_its_clocks(by_hand, tmp_path):
    clocks = (f"{BUS}.{DOWN}_Clock", f"{BUS}.MachineHeartbeat_Clock")
    log = pd.read_csv(log_of_two(by_hand / "compensator_can_high.fmu", tmp_path, *clocks))
    ticks = log["time"][log[f"a.{BUS}.{DOWN}_Clock"] == 1]
    assert list(ticks) == pytest.approx([CYCLE_S * count for count in range(len(ticks))], abs=0.011)
    assert len(ticks) >= 20


def test_a_host_that_steps_on_is_told(bench):
    node = bench.node
    node.step_to(node.due_s / 2)
    assert not node.needed
    node.step_to(node.due_s + 1.0)
    assert node.needed
    assert len(node.receive(node.time_s, {})) == 1


def test_a_state_goes_on_with_the_same_signals(by_hand, bench, tmp_path):
    for count in range(1, 50):
        bench.cycle(count)
    data = bench.node.fmu.serializeFMUState(bench.node.fmu.getFMUState())
    other = SignalNode(by_hand / "compensator_can_high.fmu", tmp_path / "other")
    other.fmu.setFMUState(other.fmu.deserializeFMUState(data))
    other.time_s = bench.node.time_s
    (sent,), (wanted,) = (node.receive(bench.node.due_s, {}) for node in (other, bench.node))
    assert sent == pytest.approx(wanted, nan_ok=True)


def test_what_belongs_to_a_clock_is_set_with_it(bench):
    node, frame = bench.node, "MachineTemperatures1"
    with pytest.raises(FMICallException):
        node.fmu.setFloat64([node.refs[f"{BUS}.{frame}.{frame}.T1"]], [30.0])
    node.fmu.enterEventMode()
    node.fmu.setFloat64([node.refs[f"{BUS}.{frame}.{frame}.T1"]], [30.0])
    for name in (f"{BUS}.{DOWN}.{DOWN}.status", "T1"):
        with pytest.raises(FMICallException):
            node.fmu.setFloat64([node.refs[name]], [1.0])
    with pytest.raises(FMICallException):
        node.fmu.setClock([node.refs[f"{BUS}.{DOWN}_Clock"]], [True])
    with pytest.raises(FMICallException):
        node.fmu.getBinary([node.refs[f"{BUS}.{DOWN}_Clock"] + 1])


def test_the_description_is_that_of_the_layered_standard(by_hand):
    path = by_hand / "compensator_can_high.fmu"
    assert validate_fmu(str(path)) == []
    with ZipFile(path) as archive:
        network = archive.read(f"extra/org.fmi-standard.fmi-ls-bus/{BUS}.dbc")
        icons = ET.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    assert network == DBC.read_bytes()
    known = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    bus = next(t for t in icons.iter("Terminal") if t.get("name") == BUS)
    assert bus.get("terminalKind") == "org.fmi-ls-bus.network-terminal"
    assert [note.get("type") for note in bus.iter("Annotation")] == [COMPENSATOR]
    listed = {}
    for outer in bus.findall("Terminal"):
        (clock,) = outer.findall("TerminalMemberVariable")
        (inner,) = outer.findall("Terminal")
        assert outer.get("name") == inner.get("name")
        members = inner.findall("TerminalMemberVariable")
        listed[outer.get("name")] = {member.get("memberName") for member in members}
        ticking = known[clock.get("variableName")]
        for member in members:
            variable = known[member.get("variableName")]
            assert variable.clocks == [ticking]
            assert variable.causality == ticking.causality
    assert listed == {f.name: {s.name for s in f.message.signals} for f in ALL.frames}
    heard = known[f"{BUS}.MachineTemperatures1.MachineTemperatures1.T1"]
    assert (heard.unit, float(heard.min), float(heard.max)) == ("degC", -60.0, 400.0)
    assert isnan(float(heard.start))
