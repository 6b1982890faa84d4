"""What other controls take: each adapter against an emulator that enforces its manual's rules."""

import argparse
import errno
import io
import json
import sys
from collections.abc import Callable, Mapping
from math import isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.database import OFFSETS
from gateway.mapfile import CONTROLS, read_form
from gateway.protocols.base import Report
from gateway.protocols.registers import Control, RegisterLines, Registers
from measurement.rig import AXES
from scenarios.cli import main

CYCLE_S = 0.1


class Emulator:
    """A control as its manual describes it; `um` is what it has added to an axis."""

    def __init__(self) -> None:
        self.um = dict.fromkeys(AXES, 0.0)
        self.registers: dict[str, float | int | bool] = {}

    def take(self, line: str) -> None:
        for address, value in json.loads(line).items():
            self.check(address, value, self.registers.get(address, 0))
            self.registers[address] = value

    def check(self, address: str, value: float, before: float) -> None:
        """Raise what would be an alarm."""

    def pass_time(self, seconds: float) -> None:
        raise NotImplementedError


class SinumerikEmulator(Emulator):
    """MD32750: bit 0 for SD43900 [mm], bit 1 for slope and reference; MD32760 spreads a step."""

    most_um_per_s = 0.01 * 250_000.0 / 60.0

    def check(self, address: str, value: float, before: float) -> None:
        name = address.split()[0]
        assert name in ("SD43900", "SD43910", "SD43920", "MD32750")
        assert name == "MD32750" or isinstance(value, float)

    def pass_time(self, seconds: float) -> None:
        at_mm = 437.0  # where the axes stand: a slope would show
        for axis in AXES:
            kind = int(self.registers[f"MD32750 $MA_TEMP_COMP_TYPE[{axis}]"])
            slope = self.registers[f"SD43910 $SA_TEMP_COMP_SLOPE[{axis}]"]
            origin = self.registers[f"SD43920 $SA_TEMP_COMP_REF_POSITION[{axis}]"]
            wanted = self.registers[f"SD43900 $SA_TEMP_COMP_ABS_VALUE[{axis}]"] if kind & 1 else 0.0
            wanted += slope * (at_mm - origin) if kind & 2 else 0.0
            most = self.most_um_per_s * seconds
            self.um[axis] += min(max(1e3 * wanted - self.um[axis], -most), most)


class TwinCatEmulator(Emulator):
    """offset_0 is a whole number of 0.1 um in 32 bits; it counts once compensation is active."""

    def check(self, address: str, value: float, before: float) -> None:
        assert address.startswith("ads:551 0x120300 ")
        if "offset_0" in address:
            assert isinstance(value, int)
            assert -(2**31) <= value < 2**31

    def pass_time(self, seconds: float) -> None:
        for number, axis in enumerate(AXES, 1):
            place = "ads:551 0x120300"
            active = self.registers[f"{place} 0x{number}0041 TEMPC::activated[{axis}]"]
            offset = self.registers[f"{place} TEMPC::offset_0[{axis}]"]
            assert self.registers[f"{place} TEMPC::coefficient[{axis}]"] == 0.0
            self.um[axis] = 0.1 * offset if active else 0.0


class FanucEmulator(Emulator):
    """A word of 16 bits an axis, applied at once; a change of 9999 is an alarm."""

    def check(self, address: str, value: float, before: float) -> None:
        assert isinstance(value, int)
        assert -32_768 <= value <= 32_767
        assert abs(value - before) < 9999, "alarm: the shift is too large"

    def pass_time(self, seconds: float) -> None:
        for axis in AXES:
            self.um[axis] = float(self.registers.get(f"shift[{axis}]", 0))


class TncEmulator(Emulator):
    """Words of 16 bits in micrometres, at even addresses, followed at 1 um/s."""

    words: Mapping[str, str] = {"W576": "X", "W578": "Y", "W580": "Z"}

    def check(self, address: str, value: float, before: float) -> None:
        assert address in self.words
        assert isinstance(value, int)
        assert -32_768 <= value <= 32_767

    def pass_time(self, seconds: float) -> None:
        for word, axis in self.words.items():
            left = self.registers.get(word, 0) - self.um[axis]
            self.um[axis] += min(max(left, -seconds), seconds)


EMULATORS: dict[str, Callable[[], Emulator]] = {
    "sinumerik": SinumerikEmulator,
    "twincat": TwinCatEmulator,
    "fanuc": FanucEmulator,
    "tnc": TncEmulator,
}
"""By the control's name."""
NAMES = sorted(path.stem for path in CONTROLS.glob("*.toml"))


def control_of(name: str) -> Control:
    return read_form(Control, CONTROLS / f"{name}.toml")


def tell(lines: RegisterLines, *answer: float) -> None:
    told = dict(zip(OFFSETS, answer, strict=True))
    lines.update(0.0, lambda: Report(told, {}, {}, {}))


def test_every_control_has_an_emulator():
    assert sorted(EMULATORS) == NAMES


@pytest.mark.parametrize("name", NAMES)
@given(
    st.lists(
        st.tuples(*[st.one_of(st.floats(-650.0, 650.0), st.just(nan))] * 3), min_size=1, max_size=8
    )
)
def test_an_axis_is_given_what_the_answer_says_and_no_rule_is_broken(name, answers):
    control, emulator = control_of(name), EMULATORS[name]()
    lines = RegisterLines(control, emulator.take)
    last = dict.fromkeys(AXES, 0.0)
    for answer in answers:
        last |= {axis: um for axis, um in zip(AXES, answer, strict=True) if isfinite(um)}
        for _ in range(3):
            tell(lines, *answer)
            emulator.pass_time(CYCLE_S)
    emulator.pass_time(2000.0)
    for axis in AXES:
        assert emulator.um[axis] == pytest.approx(last[axis], abs=control.step_um / 2 + 1e-6)


def test_a_step_that_would_be_an_alarm_is_made_in_two():
    emulator = FanucEmulator()
    lines = RegisterLines(control_of("fanuc"), emulator.take)
    for _ in range(2):
        tell(lines, 15_000.0, 0.0, 0.0)
    emulator.pass_time(CYCLE_S)
    assert emulator.um["X"] == 15_000.0


def test_the_gateway_prints_the_registers_that_change():
    lines: list[str] = []
    control = RegisterLines(control_of("tnc"), lines.append)
    for told in ((nan, nan, nan), (1.2, -3.4, 0.2), (1.4, nan, 0.6)):
        tell(control, *told)
    assert lines == ['{"W576": 1, "W578": -3, "W580": 0}', '{"W580": 1}']


@pytest.mark.parametrize("name", NAMES)
def test_what_the_control_still_holds_is_written_over(name):
    control, emulator = control_of(name), EMULATORS[name]()
    emulator.registers |= dict.fromkeys(control.registers.values(), 7)
    outputs = dict.fromkeys(OFFSETS, 0.0)
    RegisterLines(control, emulator.take).update(0.0, lambda: Report({}, {}, outputs, {}))
    assert {emulator.registers[register] for register in control.registers.values()} == {0}


def test_a_restarted_gateway_takes_up_the_registers_with_its_state():
    emulator = SinumerikEmulator()
    lines = RegisterLines(control_of("sinumerik"), emulator.take)
    lines.update(0.0, lambda: Report({}, {}, {"dX": 1.5, "dY": 0.0, "dZ": -40.0}, {}))
    emulator.pass_time(2000.0)
    assert emulator.um == {"X": 1.5, "Y": 0.0, "Z": -40.0}


def test_nothing_but_registers_is_on_standard_output(quick_fmu, capsys):
    bus = ["--interface", "virtual", "--channel", "registers", "--duration", "0.2"]
    assert main(["gateway", "--compensator", str(quick_fmu), "--registers", "tnc", *bus]) == 0
    assert json.loads(capsys.readouterr().out) == {"W576": 0, "W578": 0, "W580": 0}


def test_millimetres_have_no_more_digits_than_the_register():
    lines: list[str] = []
    tell(RegisterLines(control_of("sinumerik"), lines.append), 0.03, 0.0, 0.14)
    assert {"0.0", "-3e-05", "3e-05", "0.00014"} >= set(map(str, json.loads(lines[-1]).values()))


def test_a_reader_of_registers_that_is_gone_is_told_once(monkeypatch):
    class Gone(io.StringIO):
        def write(self, text):
            raise BrokenPipeError(errno.EPIPE, "Broken pipe")

    adapter, said = Registers(argparse.Namespace(registers="tnc")), []
    adapter.check()
    monkeypatch.setattr(sys, "stdout", Gone())
    lines = adapter.join(None, None, None, said.append)
    for offset in (5.0, 9.0):
        tell(lines, offset, 0.0, 0.0)
    lines.close()
    assert [("Broken pipe" in line) for line in said] == [True]


def test_a_control_of_ones_own_is_a_file(tmp_path, capsys):
    own = tmp_path / "own.toml"
    for wrong in ("step_um = 0", "step_um = 1\nmost_um = -5", "step_um = 1\nmost_um = nan"):
        own.write_text(f'title = "T"\nsource = "S"\n{wrong}\n[registers]\nX = "R1"\n')
        assert main(["gateway", "--registers", str(own)]) == 2
        assert f"own.toml: {wrong.split()[-3]}: " in capsys.readouterr().err
    assert main(["gateway", "--registers", "none"]) == 2
    assert "fanuc, sinumerik, tnc, twincat" in capsys.readouterr().err
