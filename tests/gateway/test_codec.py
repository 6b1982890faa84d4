"""Values to frames and back, for every signal of the DBC file."""

import struct
from collections.abc import Sequence
from math import inf, isnan, nan

import cantools
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.codec import Encoder, Finding, decode, name_of, raw_of
from gateway.database import COMPENSATOR, ERROR, MACHINE, NOT_AVAILABLE, Frame
from gateway.dbc import DBC
from gateway.mapfile import InputMap, OutputMap
from gateway.mapped_signals import mapped_signal
from gateway.mapping import read_database
from measurement.errors import BadInput

DATABASE = read_database()
ALL = [(frame, signal) for frame in DATABASE.frames for signal in frame.signals.values()]
IDS = [f"{frame.name}.{signal.name}" for frame, signal in ALL]
UNCODED = {"answered_time", "challenge", "proof", "probe_time", "probes_taken"}
"""Every raw value of these counts: there is none to spare for a special code."""
CODED = [(f, s) for f, s in ALL if s.name not in UNCODED]
each_signal = pytest.mark.parametrize(("frame", "signal"), ALL, ids=IDS)


def read(frame: Frame, data: bytes | bytearray) -> tuple[dict[str, float], Sequence[Finding]]:
    content = decode(frame, data)
    return content.values, content.problems


@each_signal
@given(data=st.data())
def test_a_value_comes_back_to_half_a_digit(frame, signal, data):
    if signal.is_enumeration:
        name = data.draw(st.sampled_from(list(signal.named)))
        message = Encoder(frame).message({signal.name: name})
        values, problems = read(frame, message.data)
        assert name_of(signal, values[signal.name]) == name
    else:
        value = data.draw(st.floats(signal.low, signal.high))
        message = Encoder(frame).message({signal.name: value})
        values, problems = read(frame, message.data)
        assert values[signal.name] == pytest.approx(value, abs=signal.scale * 0.5001)
        assert signal.low - 1e-9 <= values[signal.name] <= signal.high + 1e-9
    assert signal.name not in [problem.signal for problem in problems]


@pytest.mark.parametrize(("frame", "signal"), CODED)
@pytest.mark.parametrize(
    ("value", "code", "fault"),
    [(nan, NOT_AVAILABLE, "not_available_value"), (inf, ERROR, "error_value")],
)
def test_what_is_not_there_or_cannot_be_carried_is_marked(frame, signal, value, code, fault):
    message = Encoder(frame).message({signal.name: value})
    by_cantools = frame.message.decode(bytes(message.data))
    assert str(by_cantools[signal.name]) == code
    values, problems = read(frame, message.data)
    assert isnan(values[signal.name])
    assert fault in [problem.fault for problem in problems if problem.signal == signal.name]
    too_much = signal.high + max(1.0, 2.0 * signal.scale)
    if not signal.is_enumeration:
        assert raw_of(signal, too_much) == signal.codes[ERROR]


def test_what_cannot_be_carried_is_missing_without_a_code_for_errors():
    dbc = cantools.database.load_string(
        'BU_: C\nBO_ 1 F: 1 C\n SG_ W : 0|8@1+ (1,0) [0|0] "um" C\n'
    )
    spec = OutputMap(signal="F.W", missing_raw=255)
    signal = mapped_signal("dX_uncertainty", spec, dbc.messages[0].signals[0])
    assert [raw_of(signal, value) for value in (254.0, 300.0, inf, nan)] == [254, 255, 255, 255]


@pytest.mark.parametrize("span", ["-200|200", "-1e400|1e400"])
def test_a_range_of_more_than_the_bits_hold_is_what_they_hold(span):
    dbc = cantools.database.load_string(
        f'BU_: C\nBO_ 1 F: 1 C\n SG_ W : 0|8@1- (1,0) [{span}] "um" C\n'
    )
    spec = OutputMap(signal="F.W", missing_raw=-128)
    signal = mapped_signal("dX", spec, dbc.messages[0].signals[0])
    assert [raw_of(signal, value) for value in (127.0, 150.0, -150.0)] == [127, -128, -128]
    assert (signal.low, signal.high) == (-128.0, 127.0)


@pytest.mark.parametrize("sign", ["+", "-"])
@pytest.mark.parametrize("bits", [53, 56, 64])
def test_the_ends_of_a_long_signal_are_sent_and_read_though_a_float_holds_53_bits(bits, sign):
    dbc = cantools.database.load_string(
        f'BU_: C\nBO_ 1 F: 8 C\n SG_ W : 0|{bits}@1{sign} (1,0) [0|0] "um" C\n'
    )
    signal = mapped_signal("dX", OutputMap(signal="F.W"), dbc.messages[0].signals[0])
    for end in signal.allowed_raw:
        raw = raw_of(signal, float(end))
        assert raw == end
        sent = dbc.messages[0].encode({"W": raw}, scaling=False)
        assert dbc.messages[0].decode(sent, scaling=False) == {"W": raw}


@given(st.sampled_from(DATABASE.frames), st.binary(min_size=8, max_size=8))
def test_any_bytes_give_a_value_in_range_or_a_problem(frame, data):
    values, problems = read(frame, data)
    wrong = [problem.signal for problem in problems]
    for name, signal in frame.signals.items():
        assert (name in wrong) == isnan(values[name])
        if name not in wrong:
            assert signal.low - 1e-9 <= values[name] <= signal.high + 1e-9


def test_a_float_of_a_fraction_is_in_range_up_to_its_end():
    """As a tool length in metres; 0.4 in single precision is a little more than 0.4."""
    dbc = cantools.database.load_string(
        'BU_: PLC\nBO_ 1 F: 4 PLC\n SG_ L : 7|32@0- (1,0) [0|0.4] "m" PLC\nSIG_VALTYPE_ 1 L : 1;'
    )
    signal = mapped_signal("tool_length", InputMap(signal="F.L"), dbc.messages[0].signals[0])
    lengths = [0.15, struct.unpack("f", struct.pack("f", 0.4))[0], 0.401]
    low, high = signal.allowed_raw
    assert [low <= one <= high for one in lengths] == [True, True, False]


def test_signals_have_the_names_and_units_of_the_fmus(database, unit):
    machine = {signal.name: signal.unit for _, signal in database.signals(MACHINE)}
    sent = {signal.name: signal.unit for _, signal in database.signals(COMPENSATOR)}
    assert {f"T{n}" for n in range(1, 12)} < set(machine)
    for name in unit.inputs:
        assert machine[name] == unit.unit_of(name)
    for name in unit.outputs:
        assert sent[name] == unit.unit_of(name)


def test_every_frame_and_signal_says_what_it_is():
    for message in cantools.database.load_file(DBC).messages:
        assert message.comment
        for signal in message.signals:
            assert signal.comment, f"{message.name}.{signal.name}"


def test_the_start_values_are_safe(database):
    signals = [signal for frame in database.frames for signal in frame.signals.values()]
    start = {s.name: name_of(s, s.start) for s in signals if s.is_enumeration}
    safe = {"valid": "invalid", "freshness": "not_proven", "status": "waiting"}
    safe |= {"thermal_state": "unknown", "machine_state": "off"}
    assert safe.items() <= start.items()
    for _, signal in database.signals(MACHINE):
        if signal.unit in ("degC", "mm", "rpm"):
            assert signal.start == signal.codes[NOT_AVAILABLE]


def test_every_fault_of_the_dbc_is_one_that_the_gateway_finds(database):
    """A name of the table that nothing uses would be a promise not kept."""
    source = "".join(path.read_text(encoding="utf-8") for path in sorted(DBC.parent.glob("*.py")))
    named = database.signal("bus_fault").named
    assert [name for name in named if f'"{name}"' not in source] == []


GOOD = DBC.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("BO_ 528 ", "BO_ 2147484176 ", "DBC"),
        (' SG_ crc : 0|8@1+ (1,0) [0|255] "" COMPENSATOR\n', "", "crc"),
        ("Temperatures1: 8 MACHINE", "Temperatures1: 8 Vector__XXX", "sent by"),
        ('BA_ "E2EDataId" BO_ 529 53777;', 'BA_ "E2EDataId" BO_ 529 53776;', "E2EDataId"),
        ('BA_ "E2ETimeout" BO_ 533 250;', 'BA_ "E2ETimeout" BO_ 533 90;', "E2ETimeout"),
        ('BA_ "GenMsgCycleTime" BO_ 528 100;', 'BA_ "GenMsgCycleTime" BO_ 528 50;', "cycle"),
        ("machine_time", "machine_tine", "machine_time"),
        ("T1 : 16|16@1+ (0.01,", "T1 : 16|16@1+ (0,", "MachineTemperatures1.T1: has the factor 0"),
        ("dX : 16|16@1+ (0.02,", "dX : 16|16@1+ (0,", "CompensatorOffsets.dX: has the factor 0"),
        (" dX ", " eX ", "COMPENSATOR: sends no signal dX"),
        ("BO_ 528 MachineTemperatures1: 8", "BO_ 528 MachineTemperatures1: 7", ""),
    ],
)
def test_a_dbc_file_that_will_not_do_is_refused(tmp_path, old, new, word):
    assert old in GOOD
    path = tmp_path / "other.dbc"
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        read_database(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)
    assert word in str(caught.value)


def test_a_file_that_is_no_text_is_refused_in_a_line_that_a_terminal_can_take(tmp_path):
    path = tmp_path / "binary.dbc"
    path.write_bytes(b'VERSION ""\n\x1b[2J\x1b]0;owned\x07\x08' + bytes(range(256)) * 20)
    with pytest.raises(BadInput) as caught:
        read_database(path)
    assert str(caught.value).isprintable()
    assert len(caught.value.problem) < 400


@given(st.data())
def test_a_mangled_dbc_file_is_read_or_refused_in_one_line(tmp_path, data):
    at = data.draw(st.integers(0, len(GOOD) - 1))
    length = data.draw(st.integers(0, 40))
    path = tmp_path / "mangled.dbc"
    text = GOOD[:at] + data.draw(st.text(max_size=5)) + GOOD[at + length :]
    path.write_text(text, encoding="utf-8", errors="replace")
    told = ""
    try:
        read_database(path)
    except BadInput as error:
        told = str(error)
    assert "\n" not in told
