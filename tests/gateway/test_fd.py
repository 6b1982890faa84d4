"""CAN FD: a whole cycle of each node in one frame, by a map."""

import contextlib
from pathlib import Path

import pytest

from gateway.codec import Sender
from gateway.database import MACHINE, Database
from gateway.link import Link
from gateway.mapping import read_mapping
from gateway.node import GatewaySettings
from gateway.reference import Proof
from tests.gateway.bench import WARM, Bench

TEMPERATURES = [f"T{n}" for n in range(1, 12)]
MACHINE_FRAME = [
    *((name, 16, 0.01, "degC") for name in TEMPERATURES),
    *(("speed", 16, 1, "rpm"), ("tool_length", 16, 0.1, "mm"), ("machine_time", 32, 0.001, "s")),
    *(("machine_step", 16, 0.001, "s"), ("machine_state", 8, 1, ""), ("thermal_state", 8, 1, "")),
]
ANSWER = [
    *((name, -16, 0.01, "um") for name in ("dX", "dY", "dZ")),
    *((name, 8, 1, "") for name in ("valid", "gateway_state", "status", "status_sensor")),
    *(("bus_fault", 8, 1, ""), ("bus_fault_frame", 8, 1, ""), ("answered_time", 16, 0.001, "s")),
]
Row = tuple[str, int, float, str]


def _frame(number: int, name: str, sender: str, rows: list[Row]) -> str:
    lines = [f"BO_ {number} {name}: 64 {sender}"]
    lines += [' SG_ crc : 0|16@1+ (1,0) [0|65535] "" Vector__XXX']
    lines += [' SG_ counter : 16|4@1+ (1,0) [0|14] "" Vector__XXX']
    lines += [' SG_ cycle : 20|4@1+ (1,0) [0|15] "" Vector__XXX']
    start = 24
    for signal, bits, scale, unit in rows:
        place = f"{start}|{abs(bits)}@1{'-' if bits < 0 else '+'} ({scale:g},0) [0|0]"
        lines.append(f' SG_ {signal} : {place} "{unit}" Vector__XXX')
        start += abs(bits)
    return "\n".join([*lines, ""])


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A map of two frames with 64 bytes."""
    dbc = ['VERSION ""', "", "NS_ :", "", "BS_:", "", "BU_: CONTROL GATEWAY", ""]
    dbc += [_frame(0x300, "Cycle", "CONTROL", MACHINE_FRAME)]
    dbc += [_frame(0x200, "Answer", "GATEWAY", ANSWER)]
    dbc += ['VAL_ 768 machine_state 0 "off" 1 "starting" 2 "running" 3 "stopping" ;']
    dbc += ['VAL_ 768 thermal_state 0 "unknown" 1 "cold" 2 "warm" ;']
    dbc += ['BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;', 'BA_DEF_DEF_ "GenMsgCycleTime" 100;']
    (tmp_path / "fd.dbc").write_text("\n".join([*dbc, ""]))
    frame = (
        '{ protection = "crc16_ccitt_false", counter = "counter", counter_values = 15, '
        "late_after_ms = 250 }"
    )
    lines = ["format = 1", 'dbc = "fd.dbc"', "data_bit_rate = 2000000", "[cycle]"]
    lines += ['frames = "together"', "[frames]", f"Cycle = {frame}", f"Answer = {frame}"]
    lines += ["[inputs]", *(f'{row[0]} = "Cycle.{row[0]}"' for row in MACHINE_FRAME)]
    lines += ["[outputs]", *(f'{row[0]} = "Answer.{row[0]}"' for row in ANSWER)]
    file = tmp_path / "map.toml"
    file.write_text("\n".join(lines))
    return file


@pytest.fixture
def frames(path: Path) -> Database:
    """These frames."""
    mapping = read_mapping(path)
    assert [str(problem) for problem in mapping.problems] == []
    return mapping.database


def test_a_cycle_in_one_frame_is_answered_in_one(frames, unit):
    bench = Bench(frames, unit, GatewaySettings(proof=Proof(said=True)))
    (message,) = bench.frames()
    assert (message.is_fd, message.bitrate_switch, len(message.data)) == (True, True, 64)
    for values in [{}] * 4 + [WARM] * 90:
        bench.cycle(values)
    assert bench.last["valid"] == 1
    assert any(bench.offsets)


@pytest.mark.parametrize("wire", ["udp_multicast"], indirect=True)
def test_long_frames_cross_a_bus_that_carries_them(wire, frames):
    keys = [frame.key for frame in frames.frames]
    options = {**wire.options, "fd": True}
    sender, hearer = (Link(wire.interface, wire.channel, keys, options=options) for _ in range(2))
    with contextlib.closing(sender), contextlib.closing(hearer):
        sender.open()
        hearer.open()
        (sent,) = Sender(frames, MACHINE).messages({"machine_state": "running"})
        assert sender.send([sent])
        got = None
        for _ in range(100):
            got = got or hearer.receive(0.1)
        assert (bytes(got.data), got.is_fd) == (bytes(sent.data), True)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("data_bit_rate = 2000000", "", "64 bytes: a frame of CAN FD needs data_bit_rate"),
        (": 64 CONTROL", ": 50 CONTROL", "50 bytes: is not a length that frames can have"),
    ],
)
def test_what_cannot_be_on_the_bus_is_refused(path, old, new, problem):
    file = path if old in path.read_text() else path.with_name("fd.dbc")
    file.write_text(file.read_text().replace(old, new))
    assert problem in " ".join(str(one) for one in read_mapping(path).problems)


def test_a_proof_needs_a_frame_of_its_own(path):
    text = path.read_text().replace("[outputs]", '[outputs]\nchallenge = "Answer.challenge"')
    path.write_text(
        text.replace("[inputs]", '[inputs]\necho = "Cycle.echo"\nproof = "Cycle.proof"')
    )
    dbc = path.with_name("fd.dbc")
    more = ' SG_ echo : 400|16@1+ (1,0) [0|0] "" Vector__XXX\n'
    more += ' SG_ proof : 416|32@1+ (1,0) [0|0] "" Vector__XXX\n'
    told = ' SG_ challenge : 400|32@1+ (1,0) [0|0] "" Vector__XXX\n'
    text = dbc.read_text().replace(": 64 CONTROL\n", f": 64 CONTROL\n{more}")
    dbc.write_text(text.replace(": 64 GATEWAY\n", f": 64 GATEWAY\n{told}"))
    problems = [str(problem) for problem in read_mapping(path).problems]
    assert "must hold echo and proof alone" in " ".join(problems)
