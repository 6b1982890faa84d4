"""Maps: any control's frames under the gateway's own names, and what is wrong with a map."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path

import can
import cantools
import numpy as np
import pytest

from fmu_compensator.runtime.modelfile import model_text
from gateway.busload import bus_load, frame_bits
from gateway.codec import Encoder, Sender, Value, decode
from gateway.database import COMPENSATOR, MACHINE, Database, key_of
from gateway.mapcheck import limits_of, problems_of
from gateway.mapfile import MAPS
from gateway.mapped_signals import conversion
from gateway.mapping import read_mapping
from gateway.node import GatewaySettings
from gateway.page import load_text
from gateway.reception import Reception
from gateway.reference import Proof
from measurement.errors import BadInput
from measurement.runs import read_run
from scenarios.cli import main
from scenarios.fmu_files import build_compensator
from tests.fmus.models import five_point_table
from tests.gateway.bus import gateway_thread
from tests.gateway.conftest import new_wire

COLD = GatewaySettings(proof=Proof(said=True))
BUILDER = MAPS / "machine_builder.toml"


@pytest.fixture
def edited(tmp_path: Path) -> Callable[..., Path]:
    """Makes a copy of the builder's map with some text in place of other text."""
    shutil.copy(MAPS / "machine_builder.dbc", tmp_path)

    def edit(*changes: tuple[str, str]) -> Path:
        text = BUILDER.read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "map.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return edit


# The shipped layout as a map


def facts(database: Database) -> list[tuple[object, ...]]:
    """Return all of a database's frames and signals that a bus shows."""
    return [
        (
            *(frame.name, frame.key, frame.data_id, frame.cycle_s, frame.timeout_s, frame.cycles),
            {s.name: (s.scale, s.offset, s.low, s.unit) for s in frame.signals.values()},
        )
        for frame in database.frames
    ]


def test_the_shipped_map_has_every_frame_and_signal(database):
    by_map = read_mapping(MAPS / "spindle_drift.toml").database
    assert by_map.trust == database.trust == "protected"
    assert facts(by_map) == facts(database)


# A machine-tool builder's frames


class Builder:
    """A control that knows only its own DBC file and cantools."""

    def __init__(self) -> None:
        self.dbc = cantools.database.load_file(MAPS / "machine_builder.dbc")

    def message(self, name: str, **values: float) -> can.Message:
        """Return a frame of that name."""
        frame = self.dbc.get_message_by_name(name)
        return can.Message(
            arbitration_id=frame.frame_id,
            is_extended_id=frame.is_extended_frame,
            data=frame.encode(values, strict=False),
        )

    def messages(
        self, temperature: float = 20.0, mode: int = 2, **more: float
    ) -> list[can.Message]:
        """Return all pages of temperatures, the status and the tool."""
        found = []
        for page in range(4):
            names = [f"Tmp{n:02d}" for n in range(3 * page + 1, min(3 * page + 4, 12))]
            readings = {name: more.get(name, temperature) for name in names}
            found.append(self.message("SPN_TEMP", TmpPage=page, **readings))
        status = {"SpnSpeed": -3000.0, "SpnLoad": 0.0, "OpMode": mode}
        found.append(self.message("SPN_STATUS", **status))
        return [*found, self.message("TOOL_DATA", ToolLength=150.0, ToolNumber=1)]

    def read(self, message: can.Message) -> dict[str, float]:
        """Return what a frame holds."""
        frame = self.dbc.get_message_by_frame_id(message.arbitration_id)
        content = frame.decode(bytes(message.data), decode_choices=False)
        return {name: float(value) for name, value in content.items()}


WARMED = {"Tmp01": 24.0, "Tmp04": 26.0}
"""As `bench.WARM`."""


def test_the_builders_signals_are_those_of_its_dbc_file(builder):
    control = Builder()
    reception = Reception(builder.of(MACHINE), together=False)
    for message in control.messages(21.5, Tmp05=-7.3, Tmp11=-3276.8):
        reception.take(key_of(message), message.data, 1.0)
    look = reception.look(1.0)
    assert look.usable
    assert look.values["T1"] == pytest.approx(21.5)
    assert look.values["T5"] == pytest.approx(-7.3)
    assert np.isnan(look.values["T11"])
    assert look.finding.fault == "not_available_value"
    assert look.values["speed"] == -3000.0
    assert look.values["tool_length"] == pytest.approx(150.0)
    sent = Sender(builder, COMPENSATOR).messages({"dX": 12.34, "dZ": -56.7, "valid": "valid"})
    assert [m.is_extended_id for m in sent] == [True, True]
    offsets = control.read(sent[0])
    # In millimetres, with the opposite sign, in steps of 0.1 um.
    assert offsets["OfsX"] == pytest.approx(-0.0123)
    assert offsets["OfsZ"] == pytest.approx(0.0567)
    assert offsets["OfsY"] == pytest.approx(-3.2768)
    assert offsets["OfsOk"] == 1.0


def test_the_pages_that_the_gateway_sends_are_the_builders(builder):
    control = Builder()
    values: dict[str, Value] = {f"T{n}": 20.0 + n for n in range(1, 12)}
    messages = Sender(builder, MACHINE).messages(values | {"machine_state": "running"})
    found: dict[str, float] = {}
    for message in messages:
        found |= control.read(message)
    assert {found[f"Tmp{n:02d}"] for n in range(1, 12)} == {20.0 + n for n in range(1, 12)}
    assert found["OpMode"] == 2


def test_all_pages_that_the_gateway_sends_load_the_bus(builder):
    """A control's cycle time is that of its frame, which brings one page or another."""
    heard = next(frame for frame in builder.of(MACHINE) if frame.multiplexer)
    for frame, count in ((heard, 4), (replace(heard, sender=COMPENSATOR), 16)):
        alone = replace(builder, frames=(frame,))
        assert f"{count} a second" in load_text(alone)
        assert bus_load(alone) * builder.bit_rate == count * frame_bits(7)


def test_a_frame_whose_period_no_file_gives_is_missing_from_the_load(builder):
    assert load_text(builder).endswith("with none.")
    unknown = replace(builder.frames[0], cycle_s=inf)
    text = load_text(replace(builder, frames=(unknown, *builder.frames[1:])))
    assert text.endswith(f"with none. Without {unknown.name}, of unknown period.")


def test_a_page_that_does_not_come_is_told_by_its_number(builder):
    frame = next(frame for frame in builder.of(MACHINE) if frame.multiplexer)
    reception = Reception([frame], together=False)
    *messages, _ = Encoder(frame).messages({})
    for message in messages:
        reception.take(frame.key, message.data, 0.0)
    assert f"page {frame.pages[-1]} has not been seen yet" in reception.look(0.1).finding.text


def test_the_limits_of_a_compensator_are_known_in_either_form(shipped_in_c):
    limits = limits_of(shipped_in_c / "compensator.fmu")
    assert limits["offset_um"] > 0.0
    assert limits_of(shipped_in_c / "compensator_native.fmu") == limits


def test_a_speed_that_cannot_reach_the_training_is_told(edited, shipped_in_c):
    signal = '{ signal = "SPN_STATUS.SpnSpeed", factor = 0.1 }'
    narrow = read_mapping(edited(('"SPN_STATUS.SpnSpeed"', signal)))
    (problem,) = problems_of(narrow, shipped_in_c / "compensator.fmu")
    assert "inputs.speed: carries up to 3276.8 rpm; the compensator was tr" in str(problem)
    assert not problems_of(read_mapping(BUILDER), shipped_in_c / "compensator.fmu")


def test_a_builders_machine_is_compensated(wire, builder, quick_fmu):
    """The same offsets as by the shipped frames, to the resolution of these."""
    control = Builder()
    with gateway_thread(wire, builder, quick_fmu, COLD) as service, wire.open() as bus:
        assert _until(bus, control, lambda o, s: o["OfsOk"] == 1.0, control.messages())
        rising = control.messages(Tmp01=20.4, Tmp04=20.4)
        offsets, status = _until(
            bus, control, lambda o, s: o["OfsOk"] == 1.0 and s["CmpState"] == 0, rising
        )
        assert status["CmpTrust"] == 0
        outputs = service.unit.outputs
        for axis in "XYZ":
            assert offsets[f"Ofs{axis}"] * -1e3 == pytest.approx(outputs[f"d{axis}"], abs=0.6)
        # A page that comes no more is noticed, though the others do.
        less = [m for m in control.messages(**WARMED) if m.data[0] != 1 or m.arbitration_id != 801]
        assert _until(bus, control, lambda o, s: o["OfsOk"] == 0 and s["CmpFault"] == 3, less)
        # And so is a machine that does not run.
        setup = control.messages(mode=3, **WARMED)
        assert _until(bus, control, lambda o, s: s["CmpFault"] in (9, 15), setup)


def _until(
    bus: can.BusABC,
    control: Builder,
    wanted: Callable[[dict[str, float], dict[str, float]], bool],
    messages: list[can.Message],
) -> tuple[dict[str, float], dict[str, float]]:
    """Send the same frames every 50 ms until the answer is as wanted; fail if it never is."""
    offsets: dict[str, float] = {}
    for _ in range(150):
        for message in messages:
            bus.send(message)
        while (message := bus.recv(0.05)) is not None:
            if not message.is_extended_id:
                continue
            content = control.read(message)
            offsets |= content
            if "CmpState" in content and "OfsOk" in offsets and wanted(offsets, content):
                return offsets, content
    raise AssertionError(f"not seen; the last answer is {offsets}")


def test_both_ends_run_by_a_map(builder, shipped, tmp_path, quick_fmu):
    wire, run, said = new_wire("virtual"), tmp_path / "run.csv", list[str]()
    settings = GatewaySettings(proof=Proof(said=True), speed_up=10.0)
    with gateway_thread(wire, builder, quick_fmu, settings, said=said):
        command = ["machine", "step_speed", *wire.arguments(), "--fmu-dir", str(shipped)]
        command += ["--map", "machine_builder", "--speed-up", "10", "--out", str(run)]
        assert main([*command, "--set", "duration_s=40", "--set", "signals.speed=9000"]) == 0
    table = read_run(run).frame
    assert table["valid_1"].mean() > 0.5
    assert abs(table["dZ_um"].iloc[-1]) > 0.1


def test_a_machine_sends_no_reading_that_its_plant_lacks(edited, shipped, capsys):
    """A signal's start value, 0 degC, would pass for one if no raw value means missing."""
    rule = 'T11 = { signal = "SPN_TEMP.Tmp11", unit = "degC", missing_raw = -32768 }'
    command = ["machine", "step_speed", *new_wire("virtual").arguments(), "--wait", "0"]
    command += ["--fmu-dir", str(shipped), "--set", "duration_s=1", "--map"]
    path = edited((rule, 'Halle = { signal = "SPN_TEMP.Tmp11", unit = "degC" }'))
    assert main([*command, str(path)]) == 2
    assert "plant.fmu: has no Halle, and its frames cannot say so" in capsys.readouterr().err
    assert main([*command, str(edited((rule, rule.replace("T11", "Halle"))))]) == 0


@pytest.mark.parametrize(
    ("unit", "wanted", "factor", "offset"),
    [
        *(("C", "degC", 1.0, 0.0), ("K", "degC", 1.0, -273.15), ("0.5 degC", "degC", 0.5, 0.0)),
        *(("mm", "um", 1e3, 0.0), ("0.1 um", "mm", 1e-4, 0.0), ("m", "mm", 1e3, 0.0)),
        *(("U/min", "rpm", 1.0, 0.0), ("Hz", "rpm", 60.0, 0.0), ("ms", "s", 1e-3, 0.0)),
    ],
)
def test_units_of_a_dbc_file_are_converted(unit, wanted, factor, offset):
    assert conversion(unit, wanted) == (factor, offset)


# What is wrong with a map

WRONG = [
    ("SPN_STATUS.SpnSpeed", "SPN_STATUS.Speed", "inputs.speed: SPN_STATUS has no signal Speed"),
    ("SPN_STATUS.SpnSpeed", "SPINDLE.Speed", "machine_builder.dbc has no frame SPINDLE"),
    ('Tmp03", unit = "degC"', 'Tmp03", unit = "V"', "inputs.T3: V: cannot be converted to degC"),
    ("SPN_TEMP.Tmp02", "SPN_TEMP.Tmp01", "SPN_TEMP.Tmp01 is inputs.T1 already"),
    ('"SPN_STATUS.SpnSpeed"', '["SPN_STATUS.SpnSpeed", "SPN_STATUS.SpnLoad"]', "has two signals"),
    ('speed = "SPN_STATUS.SpnSpeed"\n', "", "inputs.speed: is missing: the compensator takes it"),
    ('OfsZ", factor = -1', 'OfsZ", factor = -1, unit = "nm"', "outputs.dZ: carries -0.00327"),
    ("factor = -1, missing_raw = -32768", "missing_raw = 99999", "outside the raw values"),
    ('TOOL_DATA = { protection = "none", late_after_ms = 2500 }\n', "", "TOOL_DATA: is missing"),
    ('"none", late_after_ms = 500 }', '"none" }', "late_after_ms: is missing"),
    (
        '"none", late_after_ms = 500 }',
        '"none", late_after_ms = "nie" }',
        "late_after_ms: 'nie' is not allowed: input should be a valid number or 'never'",
    ),
    ("CMP_STATUS.CmpTrust", "SPN_STATUS.SpnLoad", "outputs.trust: SPN_STATUS holds inputs and"),
    ("[inputs]", '[frames.DRV_CURRENT]\nprotection = "none"\n[inputs]', "CURRENT: is not needed"),
    ("running = 2", "run = 2", "inputs.machine_state: values: run is none of"),
    ("running = 2", "stopping = 2", "inputs.machine_state: values: has no running"),
    (", values = { off = 0, starting = 1, running = 2 }", "", "_state: values: has no running"),
    ('"none", late_after_ms = 3000', '"crc8_autosar", late_after_ms = 3000', "no signal crc"),
    (
        '"none", late_after_ms = 3000',
        '"crc8_autosar", check = "TmpPage", counter = "no", counter_values = 4, late_after_ms = 9',
        "frames.SPN_TEMP: counter: there is no signal no",
    ),
    (
        'SPN_STATUS = { protection = "none"',
        'SPN_STATUS = { protection = "crc8_autosar", check = "SpnLoad"',
        "frames.SPN_STATUS: check: SpnLoad must fill 1 whole bytes",
    ),
    (
        'SPN_STATUS = { protection = "none"',
        'SPN_STATUS = { protection = "crc8_autosar", check = "SpnLoad", counter = "SpnLoad", '
        "counter_values = 4",
        "frames.SPN_STATUS: counter: SpnLoad is already the check value",
    ),
    (
        'SPN_STATUS = { protection = "none"',
        'SPN_STATUS = { protection = "counter", counter = "SpnLoad", counter_values = 65536',
        "frames.SPN_STATUS: counter_values: 65536 do not fit into SpnLoad",
    ),
    ('frames = "sampled"', 'frames = "together"', 'map.toml: cycle: frames = "sam'),
    ("valid = {", "fresh = {", "outputs.dX, outputs.dY, outputs.dZ: needs when_invalid"),
    (
        'status = "CMP_STATUS.CmpState"',
        'status = { signal = "CMP_STATUS.CmpState", values = { ok = 0 } }',
        "outputs.status: values: lacks waiting, or a value named other",
    ),
    ("starting = 1", "starting = 2", "are both 2"),
    ("dX = {", "dW = {", "outputs.dX: is missing: the compensator sends it; see axes"),
    ("[cycle]", 'axes = ["X", "Y"]\n[cycle]', "outputs.dZ: is sent, and axes has no Z"),
    (
        'CMP_OFFSET = { protection = "none" }',
        'CMP_OFFSET = { protection = "none", fill = { OfsReserve = 256 } }',
        "frames.CMP_OFFSET: fill.OfsReserve: 256 is not allowed: 0 to 255",
    ),
    ('OfsX", factor', 'OfsX", when_invalid = 4000, factor', "4000 is not allowed: -3276.7 to"),
    (
        'signal = "CMP_OFFSET.OfsX", factor = -1, missing_raw = -32768',
        'signal = ["CMP_OFFSET.OfsX", "CMP_STATUS.CmpTrust"], unit = "mm"',
        "outputs.dX: carries",
    ),
    ('OfsX", factor = -1', 'OfsX", factor = -2e-4', "outputs.dX: has steps of 500 um"),
    ("valid = 1 }", "valid = 0 }", "outputs.valid: values: invalid and valid are all 0"),
    (
        'signal = "TOOL_DATA.ToolLength", when_missing = "hold", hold_s = 60',
        "constant = -5e8",
        "inputs.tool_length: -5e+08 is not allowed: -2000 to 2000 mm",
    ),
    ('"SPN_STATUS.SpnSpeed"', "{ constant = nan }", "nan is not allowed: input should be a finite"),
    ("trust = ", "sunshine = ", "outputs.sunshine: is not an output of the compensator or"),
]


@pytest.mark.parametrize(("old", "new", "told"), WRONG, ids=[told[:40] for *_, told in WRONG])
def test_what_is_wrong_with_a_map_is_told_in_a_line(edited, quick_fmu, old, new, told):
    path = edited((old, new))
    try:
        lines = [str(problem) for problem in problems_of(read_mapping(path), quick_fmu)]
    except BadInput as error:
        lines = [str(error)]
    assert lines
    assert all("\n" not in line and line.startswith(str(path)) for line in lines)
    assert any(told in line for line in lines), lines


def test_a_thermometer_of_any_name_needs_a_unit(edited, tmp_path):
    """Raw tenths of a degree Fahrenheit would pass for degC."""
    table = five_point_table()
    table["sensors"][1]["name"] = "Motor"
    (tmp_path / "own.json").write_text(model_text(table), encoding="utf-8")
    fmu = build_compensator(tmp_path / "own.json", tmp_path)
    rule = 'T2 = { signal = "SPN_TEMP.Tmp02", unit = "degC"'
    path, dbc = (
        edited((rule, 'Motor = { signal = "SPN_TEMP.Tmp02"')),
        tmp_path / "machine_builder.dbc",
    )
    dbc.write_text(dbc.read_text(encoding="utf-8").replace('"C"', '"F"'), encoding="utf-8")
    assert problems_of(read_mapping(path), fmu) == []
    dbc.write_text(dbc.read_text(encoding="utf-8").replace('"F"', '""'), encoding="utf-8")
    told = "inputs.Motor: has no unit; the compensator has it in degC"
    assert [str(problem) for problem in problems_of(read_mapping(path), fmu)] == [f"{path}: {told}"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_a_dbc_file_of_any_encoding(encoding, edited, tmp_path):
    path, dbc = edited((', unit = "degC"', "")), tmp_path / "machine_builder.dbc"
    dbc.write_text(dbc.read_text(encoding="utf-8").replace('"C"', '"°F"'), encoding=encoding)
    mapping = read_mapping(path)
    assert mapping.problems == []
    assert mapping.database.signal("T1").scale == pytest.approx(0.1 / 1.8)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (" 802 ", " 801 ", "has the same identifier as"),
        (" DRV_CURRENT:", " SPN_STATUS:", "SPN_STATUS: is the name of two frames"),
    ],
)
def test_two_frames_that_cannot_be_told_apart_are_refused(edited, tmp_path, old, new, told):
    path, dbc = edited(), tmp_path / "machine_builder.dbc"
    dbc.write_text(dbc.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    try:
        lines = [str(problem) for problem in read_mapping(path).problems]
    except BadInput as error:
        lines = [str(error)]
    assert any(told in line for line in lines), lines


def test_a_frame_of_pages_is_sent_with_one_that_the_dbc_file_knows(edited, tmp_path):
    dbc = tmp_path / "machine_builder.dbc"
    path = edited()
    plain = " SG_ OfsReserve : 63|8"
    paged = ' SG_ OfsMore m5 : 55|4@0+ (1,0) [0|0] "" PLC\n SG_ OfsReserve M : 63|8'
    dbc.write_text(dbc.read_text(encoding="utf-8").replace(plain, paged), encoding="utf-8")
    sent = Sender(read_mapping(path).database, COMPENSATOR).messages({"dX": 1.0})
    assert sent[0].data[7] == 5
    changed = '"none", fill = { OfsReserve = 6 } }\nCMP_STATUS'
    path = edited(('"none" }\nCMP_STATUS', changed))
    told = [str(problem) for problem in read_mapping(path).problems]
    assert any("fill.OfsReserve: 6 is not allowed: 5" in line for line in told), told


def test_all_problems_are_told_before_anything_is_sent(edited, quick_fmu, capsys):
    path = edited(
        ("SPN_STATUS.SpnSpeed", "SPN_STATUS.Speed"),
        ("SPN_TEMP.Tmp02", "SPN_TEMP.Tmp01"),
        ("CMP_OFFSET.OfsY", "CMP_OFFSET.OfsQ"),
    )
    for more in (["--frames"], []):
        command = ["gateway", "--map", str(path), "--compensator", str(quick_fmu), *more]
        assert main([*command, "--interface", "virtual", "--channel", "nobody"]) == 2
        printed = capsys.readouterr()
        assert len(printed.err.splitlines()) == 3, printed.err
        assert ("SPN_TEMP" in printed.out) == bool(more)


def test_one_reason_is_one_line_however_many_signals_it_concerns(edited):
    lines = [str(one) for one in read_mapping(edited(("SPN_TEMP.", "SPN_TEMPS."))).problems]
    assert [line.count("inputs.T") for line in lines if "no frame SPN_TEMPS" in line] == [11]


def test_a_machine_without_an_axis_says_so(edited, quick_fmu):
    path = edited(
        ("[cycle]", 'axes = ["X", "Z"]\n[cycle]'),
        ('dY = { signal = "CMP_OFFSET.OfsY", factor = -1, missing_raw = -32768 }\n', ""),
    )
    assert problems_of(read_mapping(path), quick_fmu) == []


@pytest.mark.parametrize("name", ["machine_builder", "spindle_drift"])
def test_a_shipped_map_fits_the_shipped_compensator(name, shipped):
    mapping = read_mapping(MAPS / f"{name}.toml")
    assert problems_of(mapping, shipped / "compensator.fmu") == []


def test_an_answer_says_how_far_its_inputs_are_protected(builder):
    mapping = read_mapping(MAPS / "machine_builder.toml")
    assert builder.trust == "none"
    assert len(mapping.unprotected()) == 3


@pytest.mark.parametrize("bits", [40, 56, 64])
@pytest.mark.parametrize("sign", "+-")
def test_long_raw_values_are_read_and_sent_to_the_last_bit(edited, bits, sign):
    most = 2 ** (bits - (sign == "-")) - 1
    wanted = 'signal = "TOOL_DATA.ToolLength", missing_raw'
    path = edited(('signal = "TOOL_DATA.ToolLength"', f"{wanted} = {most}"))
    dbc = path.with_name("machine_builder.dbc")
    text = dbc.read_text(encoding="utf-8").replace("TOOL_DATA: 6", "TOOL_DATA: 8")
    lines = text.replace("7|32@0-", f"7|{bits}@0{sign}").splitlines()
    dbc.write_text("\n".join(line for line in lines if "SG_ ToolNumber" not in line) + "\n")
    (frame,) = (f for f in read_mapping(path).database.frames if f.name == "TOOL_DATA")
    missing = bytes(Encoder(frame).message({"tool_length": float("nan")}).data)
    assert missing == most.to_bytes(bits // 8, "big").ljust(8, b"\0")
    assert np.isnan(decode(frame, missing).values["tool_length"])
    assert decode(frame, bytes(8)).values["tool_length"] == 0.0
    if bits == 40:  # more than a float holds is no longer a length
        signal = frame.signals["tool_length"]
        assert signal.allowed_raw == (-(most + 1) if sign == "-" else 0, most)
