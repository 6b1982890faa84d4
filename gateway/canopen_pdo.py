"""The gateway's CANopen objects and PDOs: one layout, as frames for the gateway and as an EDS.

Process values are INTEGER16 with one or two decimal digits, like the analogue inputs of CiA 404
(objects 7130h, 6131h, 6132h). Received values and the node's states are manufacturer-specific
objects.
"""

from __future__ import annotations

import io
from collections.abc import Mapping as Table
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import canopen
import cantools
from canopen import objectdictionary as od
from canopen.objectdictionary.eds import export_eds
from cantools.database.can import Database as CanDatabase

from gateway.database import COMPENSATOR, Frame
from gateway.database import OFFSETS as DRIFTS
from gateway.mapcheck import inputs_of, limits_of
from gateway.mapfile import MapFile
from gateway.mapped_signals import named
from gateway.mapping import Mapping, mapping_of, read_database
from measurement.errors import BadInput, checked
from measurement.files import sha256_of

NO_READING = -32768
"""Sent for an unknown process value: the lowest INTEGER16, given by CiA 301."""
MOST_TEMPERATURES = 12
"""Given by the PDOs: three with four values each."""
PROFILE = 404
"""Measuring devices and closed-loop controllers: given by CiA 404."""
OFFSETS, UNITS, DIGITS = 0x7130, 0x6131, 0x6132
TEMPERATURES, SPEED, TOOL_LENGTH, STATE, THERMAL = 0x2100, 0x2101, 0x2102, 0x2103, 0x2104
VALID, STATUS, SENSOR, GATEWAY, FAULT, TRUSTED = 0x2200, 0x2201, 0x2202, 0x2203, 0x2204, 0x2205
UNCERTAINTY, LIMITS, HASH = 0x2210, 0x2300, 0x2301
"""Objects: the profile's own are given by CiA 404, the others lie in the range that CiA 301 leaves
to manufacturers."""
MICROMETRE = 0xFA010000
"""The unit, prefix then unit: given by CiA 303-2."""
REVISION = 1
"""Revision of the data sheet: given by this version."""
FILE = {
    "FileName": "spindle_drift.eds",
    "FileVersion": "1",
    "FileRevision": "0",
    "EDSVersion": "4.0",
    "Description": "Compensator of thermal drift",
    # The sheet is generated on every request, so its date is that of its layout.
    "CreationTime": "12:00PM",
    "CreationDate": "11-23-2026",
    "CreatedBy": "spindle-drift",
    "ModificationTime": "12:00PM",
    "ModificationDate": "11-23-2026",
    "ModifiedBy": "spindle-drift",
}
"""The data sheet's information about itself."""
KINDS = {"i16": (od.INTEGER16, 16), "i32": (od.INTEGER32, 32), "u8": (od.UNSIGNED8, 8)}
RECEIVE, SEND = "inputs", "outputs"
LIMIT_NAMES = ("offset_um", "slew_um_per_s", "hold_s", "recover_s")


@dataclass(frozen=True)
class Entry:
    """A mapped object: the gateway's name for it, its index, type, scale and unit."""

    name: str
    index: int
    sub: int
    kind: str
    scale: float = 1.0
    unit: str = ""

    @property
    def bits(self) -> int:
        """The object's length [bit]."""
        return KINDS[self.kind][1]


@dataclass(frozen=True)
class Pdo:
    """A PDO: its number from 1, whether the node receives or sends it, and its objects."""

    number: int
    way: str
    entries: tuple[Entry, ...]

    @property
    def size(self) -> int:
        """The PDO's length [byte]."""
        return sum(entry.bits for entry in self.entries) // 8

    def cob_id(self, node_id: int) -> int:
        """Return the identifier from the predefined connection set."""
        return (0x100 if self.way == RECEIVE else 0x80) + 0x100 * self.number + node_id

    @property
    def name(self) -> str:
        """The frame's name."""
        return f"{'R' if self.way == RECEIVE else 'T'}PDO{self.number}"


def layout(temperatures: Sequence[str]) -> list[Pdo]:
    """Return the PDOs for a compensator's temperatures.

    Raises
    ------
    BadInput
        If there are too many for the predefined PDOs.
    """
    if len(temperatures) > MOST_TEMPERATURES:
        problem = f"{len(temperatures)} temperatures: three PDOs hold {MOST_TEMPERATURES}"
        raise BadInput("--canopen", "", problem)
    readings = _array(temperatures, TEMPERATURES, 0.01, "degC")
    control = (
        Entry("speed", SPEED, 0, "i16", 1.0, "rpm"),
        Entry("tool_length", TOOL_LENGTH, 0, "i32", 0.001, "mm"),
        *_bytes(machine_state=STATE, thermal_state=THERMAL),
    )
    offsets = _array(DRIFTS, OFFSETS, 0.1, "um")
    widths = _array([f"{name}_uncertainty" for name in DRIFTS], UNCERTAINTY, 0.1, "um")
    fours = enumerate(range(0, len(readings), 4), 1)
    return [
        *(Pdo(number, RECEIVE, readings[first : first + 4]) for number, first in fours),
        Pdo(4, RECEIVE, control),
        Pdo(1, SEND, (*offsets, *_bytes(valid=VALID, status=STATUS))),
        Pdo(2, SEND, (*widths, *_bytes(gateway_state=GATEWAY, trust=TRUSTED))),
        Pdo(3, SEND, _bytes(status_sensor=SENSOR, bus_fault=FAULT)),
    ]


def _array(names: Sequence[str], index: int, scale: float, unit: str) -> tuple[Entry, ...]:
    """Return an object's process values."""
    return tuple(Entry(name, index, sub, "i16", scale, unit) for sub, name in enumerate(names, 1))


def _bytes(**indices: int) -> tuple[Entry, ...]:
    return tuple(Entry(name, index, 0, "u8") for name, index in indices.items())


@cache
def usual() -> Frame:
    """Return the gateway's own heartbeat, whose period and timeout also apply to the PDOs."""
    return read_database().closing(COMPENSATOR)


def heartbeat_ms() -> int:
    """Return the default heartbeat period [ms]."""
    return round(1e3 * usual().timeout_s)


def _pdos_of(fmu: Path) -> list[Pdo]:
    """Return a compensator's PDOs; an input that is neither speed nor length is a temperature."""
    return layout([name for name in inputs_of(fmu) if name not in ("speed", "tool_length")])


def node_mapping(node_id: int, fmu: Path) -> Mapping:
    """Return the PDOs as frames of the gateway, for a compensator.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.

    Raises
    ------
    BadInput
        If its inputs do not fit.
    """
    if not 1 <= node_id <= 127:
        raise BadInput("--canopen", "", f"{node_id} is not allowed: 1 to 127")
    pdos = _pdos_of(fmu)
    dbc = cantools.database.load_string(_dbc(node_id, pdos), database_format="dbc")
    assert isinstance(dbc, CanDatabase)
    source = Path(f"CANopen node {node_id}")
    table: dict[str, object] = {
        "format": 1,
        "dbc": source.name,
        "cycle": {"frames": "sampled", "every_ms": 1e3 * usual().cycle_s},
        "frames": {
            p.name: {"protection": "none", "late_after_ms": 1e3 * usual().timeout_s} for p in pdos
        },
    }
    for way in (RECEIVE, SEND):
        table[way] = {
            entry.name: {
                "signal": f"{pdo.name}.{entry.name}",
                "missing_raw": NO_READING if entry.kind == "i16" else None,
                "values": named(entry.name) or None,
            }
            for pdo in pdos
            if pdo.way == way
            for entry in pdo.entries
        }
    mapping = mapping_of(source, checked(MapFile, table, source), dbc, source)
    if mapping.problems:
        raise mapping.problems[0]
    # CiA 301: if an RPDO is longer than its mapping, its first bytes are used.
    frames = tuple(replace(frame, longer=True) for frame in mapping.database.frames)
    mapping.database = replace(mapping.database, frames=frames)
    return mapping


def _dbc(node_id: int, pdos: Sequence[Pdo]) -> str:
    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", "BU_: MASTER GATEWAY", ""]
    for pdo in pdos:
        sender = "MASTER" if pdo.way == RECEIVE else "GATEWAY"
        lines.append(f"BO_ {pdo.cob_id(node_id)} {pdo.name}: {pdo.size} {sender}")
        start = 0
        for entry in pdo.entries:
            sign = "+" if entry.kind == "u8" else "-"
            place = f"{start}|{entry.bits}@1{sign} ({entry.scale:g},0) [0|0]"
            lines.append(f' SG_ {entry.name} : {place} "{entry.unit}" Vector__XXX')
            start += entry.bits
        lines.append("")
    return "\n".join(lines)


# The object dictionary


def node_dictionary(node_id: int, fmu: Path) -> canopen.ObjectDictionary:
    """Return the node's object dictionary.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.
    """
    dictionary = canopen.ObjectDictionary()
    dictionary.node_id = node_id
    information = dictionary.device_information
    information.vendor_name = information.product_name = "spindle-drift"
    information.vendor_number = information.product_number = 0
    information.revision_number, information.order_code = REVISION, "spindle-drift"
    information.simple_boot_up_master = information.simple_boot_up_slave = False
    information.granularity = information.dynamic_channels_supported = 0
    information.group_messaging = information.LSS_supported = False
    pdos = _pdos_of(fmu)
    information.nr_of_RXPDO = sum(pdo.way == RECEIVE for pdo in pdos)
    information.nr_of_TXPDO = sum(pdo.way == SEND for pdo in pdos)
    information.allowed_baudrates = {125_000, 250_000, 500_000, 1_000_000}
    objects = [
        _made("Device type", 0x1000, 0, od.UNSIGNED32, PROFILE),
        _made("Error register", 0x1001, 0, od.UNSIGNED8, 0),
        _made("Manufacturer device name", 0x1008, 0, od.VISIBLE_STRING, "spindle-drift"),
        _of_node(_made("COB-ID EMCY", 0x1014, 0, od.UNSIGNED32, 0x80 + node_id), node_id),
        _made("Producer heartbeat time", 0x1017, 0, od.UNSIGNED16, heartbeat_ms(), access="rw"),
    ]
    numbers = {"Vendor-ID": 0, "Product code": 0, "Revision number": REVISION, "Serial number": 0}
    objects += [_record("Identity object", 0x1018, od.UNSIGNED32, numbers)]
    channels = {"cob_client": 0x600 + node_id, "cob_server": 0x580 + node_id}
    objects += [_record("SDO server parameter", 0x1200, od.UNSIGNED32, channels)]
    for sub in (1, 2):
        _of_node(objects[-1][sub], node_id)
    for pdo in pdos:
        objects += _pdo(pdo, node_id)
    entries = [entry for pdo in pdos for entry in pdo.entries]
    groups = {OFFSETS: "AI input PV", TEMPERATURES: "Temperatures", UNCERTAINTY: "Uncertainty"}
    for index, title in groups.items():
        names = dict.fromkeys((entry.name for entry in entries if entry.index == index), NO_READING)
        if names:
            objects += [_record(title, index, od.INTEGER16, names, mappable=True)]
    for entry in entries:
        if entry.index not in groups:
            kind = KINDS[entry.kind][0]
            objects += [_made(entry.name, entry.index, 0, kind, 0, mappable=True)]
    limits = limits_of(fmu)
    shown = {key: limits.get(key, float("nan")) for key in LIMIT_NAMES}
    compensator = {"Name": fmu.name, "SHA-256": sha256_of(fmu)}
    objects += [
        _record("AI physical unit PV", UNITS, od.UNSIGNED32, dict.fromkeys(DRIFTS, MICROMETRE)),
        _record("AI decimal digits PV", DIGITS, od.UNSIGNED8, dict.fromkeys(DRIFTS, 1)),
        _record("Limits of the compensator", LIMITS, od.REAL32, shown),
        _record("Compensator", HASH, od.VISIBLE_STRING, compensator),
    ]
    for made in objects:
        dictionary.add_object(made)
    return dictionary


def node_eds(node_id: int, fmu: Path) -> str:
    """Return the node's electronic data sheet (CiA 306-1).

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.
    """
    text, dictionary = io.StringIO(), node_dictionary(node_id, fmu)
    dictionary.__edsFileInfo = {}  # otherwise the library adds its own version
    export_eds(dictionary, text, dict(FILE))
    # CiA 306-1 requires this key, which the library does not know: no PDO maps bits.
    eds = text.getvalue().replace("GroupMessaging=", "CompactPDO=0\nGroupMessaging=", 1)
    return eds.replace(f"0x{NO_READING:X}", str(NO_READING))  # nor negative numbers


def _of_node(variable: od.ODVariable, node_id: int) -> od.ODVariable:
    """Make an identifier depend on the node's number."""
    variable.default_raw = f"$NODEID+0x{variable.default - node_id:X}"
    return variable


def _made(
    name: str,
    index: int,
    sub: int,
    kind: int,
    value: object,
    *,
    access: str = "ro",
    mappable: bool = False,
) -> od.ODVariable:
    variable = od.ODVariable(name, index, sub)
    variable.data_type, variable.access_type = kind, access
    variable.pdo_mappable, variable.default = mappable, value
    return variable


def _record(
    name: str, index: int, kind: int, members: Table[str, object], *, mappable: bool = False
) -> od.ODRecord:
    record = od.ODRecord(name, index)
    record.add_member(_made("Number of entries", index, 0, od.UNSIGNED8, len(members)))
    for sub, (member, value) in enumerate(members.items(), 1):
        record.add_member(_made(member, index, sub, kind, value, mappable=mappable))
    return record


def _pdo(pdo: Pdo, node_id: int) -> list[od.ODRecord]:
    index = (0x1400 if pdo.way == RECEIVE else 0x1800) + pdo.number - 1
    communication = od.ODRecord(f"{pdo.name} communication parameter", index)
    for sub, name, kind, value in (
        (0, "Highest sub-index supported", od.UNSIGNED8, 2),
        (1, "COB-ID", od.UNSIGNED32, pdo.cob_id(node_id)),
        (2, "Transmission type", od.UNSIGNED8, 255),
    ):
        communication.add_member(_made(name, index, sub, kind, value))
    _of_node(communication[1], node_id)
    mapped = {entry.name: entry.index << 16 | entry.sub << 8 | entry.bits for entry in pdo.entries}
    what = f"{pdo.name} mapping parameter"
    return [communication, _record(what, index + 0x200, od.UNSIGNED32, mapped)]
