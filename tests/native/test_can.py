"""The compensator with a CAN terminal: its frames beside those of the gateway."""

import re
import struct
from pathlib import Path
from random import Random
from xml.etree import ElementTree as ET
from zipfile import ZipFile

import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from gateway.database import COMPENSATOR, EXTENDED
from gateway.dbc import DBC
from gateway.mapping import read_database
from gateway.native.generate import node_data
from measurement.errors import BadInput
from tests.conftest import built
from tests.masters.conftest import needs
from tests.native import can_bus


@pytest.fixture
def bench(by_hand: Path, tmp_path: Path) -> can_bus.Bench:
    node = can_bus.BusNode(by_hand / "compensator_can.fmu", tmp_path)
    return can_bus.Bench(node, by_hand / "compensator_native.fmu")


def test_a_run_sends_the_gateway_s_frames(bench):
    bench.run(300)
    assert bench.frames == 8 * bench.answers >= 8 * 300
    assert abs(bench.node.value("dZ")) > 0.1
    assert bench.node.value("T3") == pytest.approx(bench.machine.values(30.0)["T3"], abs=0.006)


def test_under_faults_it_sends_the_gateway_s_frames(bench):
    random = Random(1)
    faults = {}
    for count in range(20, 1000):
        if random.random() < 0.1:
            kind = random.choice(can_bus.FAULTS)
            for further in range(random.randint(1, 8) if kind in ("silence", "stopped") else 1):
                faults[count + further] = kind
    bench.run(1000, faults)
    assert len({fault for _, fault in bench.seen}) > 10


@pytest.mark.long
def test_with_a_network_of_its_own_it_sends_that_gateway_s_frames(by_hand, tmp_path):
    text, network = DBC.read_text("utf-8"), tmp_path / "second.dbc"
    for frame in read_database(DBC).of(COMPENSATOR):
        text = re.sub(rf"\b{frame.frame_id}\b", str(frame.frame_id + 16), text)
    # Words that a table lacks are sent as its other.
    text = text.replace(' 5 "repeated"', "").replace('22 "not_fresh"', '22 "other"')
    text = text.replace('0 "ok" 1 "waiting" 2 "untrained"', '7 "ok" 8 "waiting" 60 "other"')
    network.write_text(text)
    model = ("--only", "compensator", "--model", str(by_hand / "by_hand.json"))
    built(tmp_path / "dist", "--can", *model, "--dbc", str(network), "--name", "second")
    (fmu,) = (tmp_path / "dist").glob("*.fmu")
    bench = can_bus.Bench(
        can_bus.BusNode(fmu, tmp_path / "fmu"), by_hand / "compensator_native.fmu", network
    )
    bench.run(100, dict.fromkeys(range(40, 60), "again") | dict.fromkeys(range(70, 80), "value"))
    assert bench.frames >= 8 * 100


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (r"(MachineTemperatures4): 8", r"\1: 6", "MachineTemperatures4: must have 8 bytes"),
        (r"(answered_time : .*)@1\+", r"\1@1-", "answered_time: must be unsigned"),
        (
            r"\b(39[89]|40\d|52[789]|53\d)\b",
            lambda found: str(int(found[0]) | EXTENDED),
            "an identifier of 11 bits",
        ),
    ],
)
def test_frames_that_the_c_code_cannot_carry_are_refused(tmp_path, old, new, told):
    network = tmp_path / "second.dbc"
    network.write_text(re.sub(old, new, DBC.read_text("utf-8")), "utf-8")
    with pytest.raises(BadInput, match=told):
        node_data(read_database(network), [])


def test_without_a_machine_it_says_so(bench):
    while bench.node.due_s < 12.0:
        bench.tick()
    assert {state for state, _ in bench.seen} == {0.0, 4.0}


def test_a_state_goes_on_with_the_same_frames(by_hand, bench, tmp_path):
    bench.run(50)
    fmu = bench.node.fmu
    data = fmu.serializeFMUState(fmu.getFMUState())
    other = can_bus.BusNode(by_hand / "compensator_can.fmu", tmp_path / "other")
    other.fmu.setFMUState(other.fmu.deserializeFMUState(data))
    other.time_s, other.due_s = bench.node.time_s, bench.node.due_s
    assert other.send() == bench.node.send() != b""


def test_the_bus_learns_the_bit_rate_first(bench):
    first = next(can_bus.operations(bench.node.send()))
    assert first == (can_bus.CONFIGURATION, struct.pack("<BI", 1, 500_000))


OTHERS = [
    struct.pack("<III", can_bus.CONFIRM, 12, 0x190),
    struct.pack("<III", 0x30, 12, 0x190),
    struct.pack("<IIIBBB", 0x31, 15, 0x190, 1, 1, 0),
    struct.pack("<IIBI", can_bus.CONFIGURATION, 13, 1, 250_000),
    struct.pack("<IIBB", can_bus.CONFIGURATION, 10, 4, 1),
    struct.pack("<IIB", 0x41, 9, 1),
    struct.pack("<II", 0x42, 8),
    struct.pack("<IIIBBBH", 0x11, 19, 0x210, 0, 0, 0, 2) + bytes(2),
    struct.pack("<IIH", can_bus.FORMAT_ERROR, 12, 2) + bytes(2),
]
"""What CAN has besides frames; the code in 4 bytes, then the length in 4, all of it counted."""
NONE = [
    struct.pack("<III", can_bus.CONFIRM, 12, 0x190)[:-4],
    struct.pack("<IIB", 0x77, 9, 0),
    struct.pack("<IIBB", 0x41, 10, 1, 0),
    can_bus.transmitted(0x210, bytes(8))[:20],
]
"""Cut off, unknown, too long, cut off; the last must end what is received."""


def test_other_operations_change_nothing_and_what_is_none_comes_back(bench):
    bench.run(20)
    node = bench.node
    for wrong in NONE:
        node.receive(node.time_s, b"".join(OTHERS) + wrong)
    sent = list(can_bus.operations(node.send()))
    found = [content for code, content in sent if code != can_bus.TRANSMIT]
    assert found == [struct.pack("<H", len(wrong)) + wrong for wrong in NONE]
    assert {code for code, _ in sent} == {can_bus.TRANSMIT, can_bus.FORMAT_ERROR}


@needs("fmu-manipulation-toolbox")
def test_another_tool_links_two_by_their_terminals(by_hand, tmp_path):
    fmu = by_hand / "compensator_can.fmu"
    log = pd.read_csv(can_bus.log_of_two(fmu, tmp_path, "CAN", "CAN"), dtype=str)
    alone = can_bus.BusNode(fmu, tmp_path / "alone")
    wanted = []
    while alone.due_s < 2.0:
        wanted.append(alone.send().hex().upper())
    for name in ("a", "b"):
        sent = log[f"{name}.CAN.Tx_Data"].dropna()
        assert list(sent[sent != sent.shift()])[: len(wanted)] == wanted


def test_the_description_is_that_of_the_layered_standard(by_hand):
    path = by_hand / "compensator_can.fmu"
    assert validate_fmu(str(path)) == []
    with ZipFile(path) as archive:
        model, icons, manifest = (
            ET.fromstring(archive.read(name))
            for name in (
                "modelDescription.xml",
                "terminalsAndIcons/terminalsAndIcons.xml",
                "extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml",
            )
        )
    assert manifest.get("isBusSimulationFMU") == "false"
    simulation = model.find("CoSimulation")
    assert simulation.get("hasEventMode") == "true"
    terminal = next(t for t in icons.iter("Terminal") if t.get("name") == "CAN")
    assert terminal.get("terminalKind") == "org.fmi-ls-bus.network-terminal"
    listed = {variable.get("name"): variable for variable in model.iter()}
    members = {
        m.get("memberName"): listed[m.get("variableName")]
        for m in terminal.iter()
        if m.get("memberName")
    }
    assert {name: entry.tag for name, entry in members.items()} == {
        "Rx_Data": "Binary",
        "Tx_Data": "Binary",
        "Rx_Clock": "Clock",
        "Tx_Clock": "Clock",
        "BusNotifications": "Boolean",
    }
    for side in ("Rx", "Tx"):
        assert members[f"{side}_Data"].get("clocks") == members[f"{side}_Clock"].get(
            "valueReference"
        )
    assert not [v for v in model.iter("Float64") if v.get("causality") == "input"]
