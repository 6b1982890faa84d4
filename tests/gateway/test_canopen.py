"""The gateway as a CANopen node, with the canopen library as the master."""

import configparser
import contextlib
import io
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import can
import pytest

from gateway.database import MACHINE
from gateway.mapcheck import problems_of
from gateway.node import GatewaySettings
from gateway.serving import Service
from measurement.errors import BadInput
from tests.gateway.bus import gateway_thread
from tests.gateway.conftest import Wire, new_wire
from tests.patience import PATIENCE_S, until

canopen = pytest.importorskip("canopen")
from canopen.sdo import SdoAbortedError  # noqa: E402

from gateway.canopen_node import CanOpenNode  # noqa: E402
from gateway.canopen_pdo import node_dictionary, node_eds, node_mapping  # noqa: E402

# How long a network goes on listening once it is left.
canopen.Network.NOTIFIER_CYCLE = 0.05
NODE = 5
# CiA 306-1, sections 4.3 and 4.4.
FILE_INFO = """FileName FileVersion FileRevision EDSVersion Description CreationTime CreationDate
CreatedBy ModificationTime ModificationDate ModifiedBy"""
DEVICE_INFO = """VendorName VendorNumber ProductName ProductNumber RevisionNumber OrderCode
BaudRate_10 BaudRate_20 BaudRate_50 BaudRate_125 BaudRate_250 BaudRate_500 BaudRate_800
BaudRate_1000 SimpleBootUpMaster SimpleBootUpSlave Granularity DynamicChannelsSupported CompactPDO
GroupMessaging NrOfRXPDO NrOfTXPDO LSS_Supported"""
MILD = 20.4
OFFSETS = tuple(f"AI input PV.d{axis}" for axis in "XYZ")


def dictionary_of(eds: str) -> Any:
    """Return a data sheet as a master reads it."""
    data_sheet = io.StringIO(eds)
    data_sheet.name = "gateway.eds"
    return canopen.import_od(data_sheet, NODE)


class Master:
    """A CANopen master that knows the gateway by its data sheet alone."""

    def __init__(self, wire: Wire, eds: str) -> None:
        self.network = canopen.Network()
        self.network.connect(interface=wire.interface, channel=wire.channel, **wire.options)
        self.node = canopen.RemoteNode(NODE, dictionary_of(eds))
        self.network.add_node(self.node)
        self.node.sdo.RESPONSE_TIMEOUT = 5.0
        self.heard: dict[str, float] = {}

    def start(self) -> None:
        """Read the PDOs of the node and start it."""
        self.node.nmt.wait_for_heartbeat(PATIENCE_S)
        self.node.tpdo.read()
        self.node.rpdo.read()
        for number in (1, 2, 3):
            self.node.tpdo[number].add_callback(self._take)
        self.node.nmt.state = "OPERATIONAL"

    def _take(self, pdo: Any) -> None:
        self.heard |= {variable.name: variable.raw for variable in pdo}

    def send(self, temperature: float, thermal: int = 1, state: int = 2) -> None:
        """Send one of each PDO."""
        for number in (1, 2, 3, 4):
            pdo = self.node.rpdo[number]
            for variable in pdo:
                if variable.name.startswith("Temperatures."):
                    variable.raw = round(temperature * 100)
            if number == 4:
                values = {"speed": 3000, "tool_length": 150_000}
                for name, raw in (
                    values | {"machine_state": state, "thermal_state": thermal}
                ).items():
                    pdo[name].raw = raw
            pdo.transmit()

    def until(self, wanted: Callable[[], bool], temperature: float = 20.0, **more: int) -> None:
        """Send until something is as wanted."""

        def sent() -> bool:
            self.send(temperature, **more)
            time.sleep(0.05)
            return wanted()

        until(sent)

    def until_valid(self) -> None:
        """Send until the offsets are valid."""
        self.until(lambda: self.heard.get("valid") == 1)

    def close(self) -> None:
        """Leave the bus."""
        self.network.disconnect()


@contextlib.contextmanager
def pair(wire: Wire, fmu: Path) -> Iterator[tuple[Master, Service]]:
    """A gateway as a node, and its master."""
    mapping = node_mapping(NODE, fmu)
    with contextlib.ExitStack() as stack:
        bus = {"interface": wire.interface, "channel": wire.channel, **wire.options}
        node = CanOpenNode(NODE, node_dictionary(NODE, fmu), mapping.database, bus, listen_s=0.1)
        stack.callback(node.close)
        service = stack.enter_context(
            gateway_thread(wire, mapping.database, fmu, GatewaySettings(), participants=[node])
        )
        until(lambda: service.node is not None)
        master = stack.enter_context(contextlib.closing(Master(wire, node_eds(NODE, fmu))))
        yield master, service


@contextlib.contextmanager
def at_work(wire: Wire, fmu: Path) -> Iterator[tuple[Master, Service]]:
    """The same, once the offsets are valid."""
    with pair(wire, fmu) as (master, service):
        master.start()
        master.until_valid()
        yield master, service


def test_a_master_starts_it_and_gets_offsets(wire, quick_fmu):
    with pair(wire, quick_fmu) as (master, service):
        master.node.nmt.wait_for_heartbeat(PATIENCE_S)
        assert master.node.nmt.state == "PRE-OPERATIONAL"
        assert not master.heard
        master.start()
        master.until_valid()
        master.until(
            lambda: (
                master.heard[OFFSETS[2]] != 0
                and abs(master.heard[OFFSETS[2]] / 10.0 - service.unit.outputs["dZ"]) <= 0.06
                and service.unit.outputs["status"] == 0.0
                and [master.heard[name] for name in ("valid", "status", "trust")] == [1, 0, 0]
            ),
            MILD,
        )
        for axis, name in zip("XY", OFFSETS, strict=False):
            found = master.heard[name] / 10.0
            assert found == pytest.approx(service.unit.outputs[f"d{axis}"], abs=0.3)
        # By SDO, as by PDO; a frame of these may get lost.
        temperature = master.node.sdo["Temperatures"]["T4"]
        master.until(lambda: temperature.raw == round(MILD * 100), MILD)
        assert master.node.sdo["AI decimal digits PV"]["dX"].raw == 1
        assert master.node.sdo["AI physical unit PV"]["dX"].raw == 0xFA010000
        # Nothing is sent to a node that was stopped.
        master.node.nmt.state = "PRE-OPERATIONAL"
        time.sleep(0.5)
        master.heard.clear()
        time.sleep(0.5)
        assert not master.heard


def test_emergencies_say_what_the_status_says(wire, quick_fmu):
    with pair(wire, quick_fmu) as (master, _):
        master.start()
        log = master.node.emcy.log
        # The reference is not known.
        master.until(lambda: any(error.code == 0xFF00 + 50 for error in log), thermal=2)
        assert [master.heard[name] for name in ("valid", "status")] == [0, 50]
        assert master.heard["Uncertainty.dX_uncertainty"] == -32768
        master.until_valid()
        first = len(log)
        # Silence: the inputs are missing.
        until(lambda: len(log) > first and log[-1].code & 0xFF)
        error = log[-1]
        assert error.code & 0xFF00 == 0xFF00
        assert error.register == 0x81
        assert error.data[0] == error.code & 0xFF
        assert error.data[0] // 10 in (1, 2, 3)
        master.until_valid()
        until(lambda: log[-1].code == 0)


def test_limits_and_hash_are_read_and_nothing_is_written(wire, quick_fmu):
    with pair(wire, quick_fmu) as (master, service):
        master.node.nmt.wait_for_heartbeat(PATIENCE_S)
        sdo = master.node.sdo
        assert sdo["Compensator"]["SHA-256"].raw == service.unit.slave.sha256
        assert sdo["Compensator"]["Name"].raw == quick_fmu.name
        assert sdo["Limits of the compensator"]["slew_um_per_s"].raw == pytest.approx(10.0)
        assert sdo["Limits of the compensator"]["hold_s"].raw == pytest.approx(2.0)
        assert sdo["Device type"].raw & 0xFFFF == 404
        for index in (0x2300, 0x7130, 0x1A00):
            with pytest.raises(SdoAbortedError):
                sdo.download(index, 1, b"\0\0\0\0")


def frame(cob_id: int, data: bytes) -> can.Message:
    return can.Message(arbitration_id=cob_id, data=data, is_extended_id=False)


def answers(wire: Wire, request: bytes) -> list[bytes]:
    """Send a request to the SDO server as it stands and return what it answers at once."""
    with wire.open() as bus:
        bus.send(frame(0x600 + NODE, request))
        found: list[bytes] = []
        while (message := bus.recv(5.0 if not found else 0.1)) is not None:
            if message.arbitration_id == 0x580 + NODE:
                found.append(bytes(message.data))
        return found


REFUSED = {
    "e0 00 00 00 00 00 00 00": "000000",  # no such command
    "60 00 00 00 00 00 00 00": "000000",  # a segment up without initiate
    "01 00 00 00 00 00 00 00": "000000",  # a segment down without initiate
    "a0 01 23 02 7f 00 00 00": "012302",  # a block upload, no other way allowed
    "a0 01 23 02 7f 05 00 00": "012302",  # a block upload, larger than allowed
    "a3 00 00 00 00 00 00 00": "000000",  # a block upload that goes on, none begun
    "c0 01 23 02 00 00 00 00": "012302",  # a block download
}


def test_what_the_sdo_server_cannot_do_it_aborts_or_does_in_segments(quick_fmu):
    wire = new_wire("virtual")
    with pair(wire, quick_fmu):
        for request, place in REFUSED.items():
            (answer,) = answers(wire, bytes.fromhex(request))
            aborted = b"\x80" + bytes.fromhex(place) + (0x05040001).to_bytes(4, "little")
            assert answer == aborted, request
        (answer,) = answers(wire, bytes.fromhex("a0 01 23 02 7f 40 00 00"))
        assert answer == bytes.fromhex("41 01 23 02 40 00 00 00")
        (segment,) = answers(wire, bytes.fromhex("60 00 00 00 00 00 00 00"))
    assert segment[0] == 0


def test_a_variable_has_no_sub_index_but_0(quick_fmu):
    wire = new_wire("virtual")
    with pair(wire, quick_fmu):
        for request in map(bytes.fromhex, ("40 00 10 05", "40 17 10 01", "2b 17 10 03 64 00")):
            aborted = b"\x80" + request[1:4] + (0x06090011).to_bytes(4, "little")
            assert answers(wire, request.ljust(8, b"\0")) == [aborted]


def test_an_aborted_transfer_does_not_go_on(quick_fmu):
    wire = new_wire("virtual")
    with pair(wire, quick_fmu):
        for request, answer in (("40 01 23 02", 0x41), ("70", 0x80), ("60", 0x80)):
            assert answers(wire, bytes.fromhex(request).ljust(8, b"\0"))[0][0] == answer


def test_a_stopped_node_beats_and_answers_nothing(quick_fmu):
    wire = new_wire("virtual")
    with pair(wire, quick_fmu) as (master, service), wire.open() as bus:
        master.node.nmt.state = "STOPPED"
        for data in (b"\x40\x17\x10\0\0\0\0\0", b"\x40"):
            bus.send(frame(0x600 + NODE, data))
        # Not CANopen: an identifier of 29 bits with the same number as a heartbeat's.
        bus.send(can.Message(arbitration_id=0x700 + NODE, data=b"\x05"))
        beats = 0
        while beats < 3:
            message = bus.recv(PATIENCE_S)
            assert message.arbitration_id != 0x580 + NODE
            beats += message.arbitration_id == 0x700 + NODE and message.data[0] == 4
        master.node.nmt.state = "OPERATIONAL"
        until(lambda: service.participants[0].operational)


def test_an_rpdo_of_another_length_is_told_and_a_longer_one_is_used(quick_fmu):
    wire = new_wire("virtual")
    with at_work(wire, quick_fmu) as (master, service), wire.open() as bus:
        pdo = next(pdo for pdo in service.database.of(MACHINE) if pdo.size < 8)
        counts = service.node.reception.counts
        for more, code in ((-1, 0x8210), (1, 0x8220)):
            data = bytes([0x20, 0x08] * 6)[: pdo.size + more]
            good, wrong = counts["good"], counts["wrong_length"]
            for _ in range(20):
                bus.send(frame(pdo.frame_id, data))
                time.sleep(0.02)
            until(lambda code=code: code in {e.code for e in master.node.emcy.log})
            assert master.node.sdo["Error register"].raw & 0x11 == 0x11
            assert (counts["good"] - good >= 20) == (more > 0)
            assert (counts["wrong_length"] - wrong >= 20) == (more < 0)


def test_a_second_node_of_the_same_number_is_noticed(quick_fmu):
    wire = new_wire("virtual")
    with at_work(wire, quick_fmu) as (master, service), wire.open() as bus:
        mapping = node_mapping(NODE, quick_fmu)
        other = {"interface": wire.interface, "channel": wire.channel}
        with pytest.raises(BadInput, match="another node"):
            CanOpenNode(
                *(NODE, node_dictionary(NODE, quick_fmu), mapping.database, other),
                listen_s=PATIENCE_S,
            )
        bus.send(frame(0x700 + NODE, b"\x05"))
        until(lambda: not service.participants[0].operational)
        until(lambda: 0x8150 in {error.code for error in master.node.emcy.log})


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_master_is_heard_again_after_the_bus_was_lost(quick_fmu):
    def down(timeout):
        raise can.CanOperationError("Network is down")

    with at_work(new_wire("virtual"), quick_fmu) as (master, service):
        node = service.participants[0]
        until(lambda: node.operational)
        node._network.bus.recv = down
        until(lambda: node._network.bus is not None and node._network.bus.recv != down)
        master.node.nmt.state = "STOPPED"
        until(lambda: not node.operational)


def test_the_data_sheet_has_what_cia_306_asks_for(quick_fmu):
    sheet = configparser.RawConfigParser()
    sheet.optionxform = str
    sheet.read_string(node_eds(NODE, quick_fmu))
    assert set(FILE_INFO.split()) <= set(sheet["FileInfo"])
    assert set(DEVICE_INFO.split()) <= set(sheet["DeviceInfo"])
    assert sheet["DeviceInfo"]["RevisionNumber"] == str(int(sheet["1018sub3"]["DefaultValue"], 0))
    for number, way in (("NrOfRXPDO", "14"), ("NrOfTXPDO", "18")):
        there = [name for name in sheet.sections() if re.fullmatch(f"{way}0[0-9]", name)]
        assert sheet["DeviceInfo"][number] == str(len(there))
    cobs = [name for name in sheet.sections() if re.fullmatch("1[48]0.sub1|1200sub[12]|1014", name)]
    assert len(cobs) >= 6
    assert all(sheet[name]["DefaultValue"].startswith("$NODEID+0x") for name in cobs)
    assert node_eds(NODE + 1, quick_fmu) == node_eds(NODE, quick_fmu)


@pytest.mark.long
def test_the_heartbeat_is_the_gateways_own(wire, quick_fmu):
    """It follows its object, and a gateway whose loop stands sends none."""
    with pair(wire, quick_fmu) as (master, service):
        master.node.nmt.wait_for_heartbeat(PATIENCE_S)
        master.node.sdo["Producer heartbeat time"].raw = 100
        beats = _beats(master, 1.0)
        assert beats >= 3
        tick = service.node.tick
        service.node.tick = lambda *args: (time.sleep(1.0), tick(*args))[1]
        time.sleep(0.5)
        assert _beats(master, 1.0) <= 2
        service.node.tick = tick
        master.node.nmt.send_command(0x81)
        until(lambda: master.node.nmt.state == "PRE-OPERATIONAL")
        assert master.node.sdo["Producer heartbeat time"].raw == 500


def _beats(master: Master, seconds: float) -> int:
    count = 0
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        with contextlib.suppress(canopen.nmt.NmtError):
            master.node.nmt.wait_for_heartbeat(0.3)
            count += 1
    return count


def test_the_data_sheet_is_that_of_the_pdos(quick_fmu):
    dictionary = dictionary_of(node_eds(NODE, quick_fmu))
    database = node_mapping(NODE, quick_fmu).database
    assert problems_of(node_mapping(NODE, quick_fmu), quick_fmu) == []
    for frame in database.frames:
        base = 0x1600 if frame.name[0] == "R" else 0x1A00
        number = int(frame.name[-1]) - 1
        assert dictionary[base - 0x200 + number][1].default == frame.frame_id
        places = dictionary[base + number]
        mapped = [places[sub].default for sub in range(1, 9) if sub in places]
        assert sum(value & 0xFF for value in mapped) == 8 * frame.size
        assert len(mapped) == len(frame.signals)
        for value in mapped:
            entry = dictionary[value >> 16]
            variable = entry if value >> 8 & 0xFF == 0 else entry[value >> 8 & 0xFF]
            assert len(variable) == value & 0xFF
            assert variable.pdo_mappable
            assert variable.default == (-32768 if value >> 16 in (0x2100, 0x2210, 0x7130) else 0)
