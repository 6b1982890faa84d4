"""The control's offsets, state files, the bus load, the tables, and what the commands refuse."""

import re
from math import nan

import can
import pytest

from gateway.busload import frame_bits
from gateway.codec import Sender
from gateway.control import OffsetFollower
from gateway.database import COMPENSATOR, MACHINE
from gateway.dbc import DBC
from gateway.machine import AnswerReceiver
from gateway.reception import Cycle
from gateway.state import StateFile
from gateway.unit import CompensatorUnit
from measurement.errors import BadInput
from scenarios.cli import main
from tests.gateway.bench import WARM
from tests.scenarios.tiny_fmus import COMPENSATOR as TINY_COMPENSATOR
from tests.scenarios.tiny_fmus import build_tiny

# The control's end


def answer(x: float, usable: bool = True) -> Cycle:
    return Cycle(usable, {"dX": x, "dY": 2.0, "dZ": 3.0}, None, {})


@pytest.mark.parametrize("bad", [None, answer(nan), answer(7.0, usable=False)])
def test_a_control_without_offsets_holds_then_gives_up(bad):
    follower = OffsetFollower(10.0)
    assert follower.follow(None, 1.0) == {"dX": 0.0, "dY": 0.0, "dZ": 0.0}
    assert follower.use == "none_yet"
    assert follower.follow(answer(5.0), 1.0)["dX"] == 5.0
    assert follower.use == "following"
    for _ in range(10):
        assert follower.follow(bad, 1.0)["dX"] == 5.0
        assert follower.use == "holding"
    assert follower.follow(bad, 1.0) == {"dX": 0.0, "dY": 0.0, "dZ": 0.0}
    assert follower.use == "returning_to_zero"
    assert follower.follow(answer(6.0), 1.0)["dX"] == 6.0
    for _ in range(10):
        assert follower.follow(bad, 1.0)["dX"] == 6.0


def test_an_answer_that_waited_in_a_queue_is_stale(database):
    """Intact and in sequence, but to readings of long ago: a control must not follow it."""
    sender, now = Sender(database, COMPENSATOR), 100.0
    queue: list[can.Message] = []
    for answered in (0.0, 1.0, 2.0):
        values = {"dX": 5.0, "dY": 0.0, "dZ": 0.0, "valid": "valid", "answered_time": answered}
        queue += sender.messages(values | {"gateway_state": "running"})

    class Waiting:
        def receive(self, timeout_s: float) -> can.Message | None:
            return queue.pop(0) if queue else None

    def ear() -> AnswerReceiver:
        heard = AnswerReceiver(database, lambda: now)
        while queue:
            heard.hear(Waiting(), now)
        return heard

    kept = list(queue)
    fresh = ear().taken(3.0, 3.5)
    assert fresh.usable
    assert fresh.values["dX"] == pytest.approx(5.0)
    for time_s in (6.0, 60.0, 67.5 + 65.536):
        queue[:] = kept
        assert ear().taken(time_s, 3.5) is None
    queue[:] = kept
    assert ear().taken(3.0 + 65.536, 3.5) is not None  # the count wraps


# State files


def test_a_state_comes_back(tmp_path, warm, new_unit):
    now = [5000.0]
    store = StateFile(tmp_path / "s.json", warm.unit.slave.sha256, lambda: now[0])
    assert store.read() == (None, "the file does not exist yet")
    store.write(now[0], warm.unit.time_s, 12.5, warm.unit.slave.saved())
    now[0] += 7.0
    saved, _ = store.read()
    assert (saved.time_s, saved.machine_time_s, saved.age_s) == (warm.unit.time_s, 12.5, 7.0)
    again: CompensatorUnit = new_unit()
    again.start(saved)
    sample = {**dict.fromkeys(again.inputs, 20.0), **WARM, "tool_length": 150.0}
    assert again.step(sample, 0.1) == warm.unit.step(sample, 0.1)
    assert again.outputs["dX"] != 0.0
    now[0] += 3600.0
    assert store.read() == (None, "it was saved 3607 s ago, allowed is 3600 s")
    now[0] = 5400.0
    assert store.read(10.0) == (None, "it was saved 400 s ago, allowed is 360 s")
    now[0] = 4990.0
    assert "10 s in the future" in store.read()[1]
    other = StateFile(tmp_path / "s.json", "another", lambda: 5001.0).read()
    assert other == (None, "it belongs to another FMU")


@pytest.mark.parametrize(
    "cut", [0, 1, 20, 60, -2, "saved", "time_s", "machine_time_s", "format", "state"]
)
def test_a_state_that_is_damaged_is_not_used(tmp_path, cut):
    store = StateFile(tmp_path / "s.json", "x", lambda: 100.0)
    store.write(100.0, 1.0, 2.0, b"state")
    text = store.path.read_text()
    assert store.read()[0] is not None
    if isinstance(cut, str):
        text = re.sub(rf'("{cut}": )("[^"]*"|[0-9.]+)', r"\1NaN", text)
    store.path.write_text(text if isinstance(cut, str) else text[:cut])
    found, why = store.read()
    assert found is None
    assert why.startswith("it is damaged: ")


@pytest.mark.parametrize("text", ["{}", "[]", '{"kind": 1}', "\x00", "my notes"])
def test_a_file_that_is_no_state_is_refused(tmp_path, text):
    path = tmp_path / "s.json"
    path.write_text(text)
    with pytest.raises(BadInput, match="is not a state of an FMU"):
        StateFile(path, "x").read()


# Bus load


def test_the_longest_frame_is_that_of_the_literature():
    """Davis et al. 2007, table 1 and eq. 1: 135 bits for 8 bytes, 55 for none, with the pause."""
    assert frame_bits(8) == 135
    assert frame_bits(0) == 55
    assert frame_bits(8, stuffed=False) == 111


# The tables


def test_the_table_names_every_frame_and_signal(database, capsys, tmp_path):
    other = tmp_path / "other.dbc"
    changed = DBC.read_text(encoding="utf-8").replace("(0.02,-650)", "(0.01,-300)")
    other.write_text(changed.replace("[-650|650]", "[-300|300]"), encoding="utf-8")
    assert main(["gateway", "--frames", "--dbc", str(other)]) == 0
    printed = capsys.readouterr().out
    for node in (MACHINE, COMPENSATOR):
        for frame, signal in database.signals(node):
            assert frame.name in printed
            assert signal.name in printed
    assert "-300 to 300" in printed
    assert "4.05 %" in printed


# What the commands refuse


def test_the_table_of_given_frames_is_checked_against_a_given_compensator(capsys, tmp_path):
    other, file = tmp_path / "other.dbc", "fmu_compensator/library/jig_borer.json"
    lines = DBC.read_text(encoding="utf-8").splitlines(keepends=True)
    other.write_text("".join(line for line in lines if " T5 " not in line), encoding="utf-8")
    assert main(["gateway", "--frames", "--dbc", str(other), "--compensator", file]) == 2
    said = capsys.readouterr()
    assert "T4" in said.out
    assert "T5: is missing: the compensator takes it" in said.err


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["gateway", "--interface", "nonsense"], "nonsense"),
        (["gateway", "--dbc", "none.dbc"], "none.dbc"),
        (["gateway", "--speed-up", "0"], "--speed-up"),
        (["gateway", "--timeout", "nan"], "--timeout"),
        (["gateway", "--compensator", "none.fmu"], "none.fmu"),
        (["gateway", "--compensator", "docs/examples/machine.toml"], "is no compensator"),
        (["gateway", "--interface", "virtual", "--log", "x.txt"], "x.txt"),
        (["gateway", "--interface", "virtual", "--option", "x"], "--option"),
        (["gateway", "--eds"], "--eds: needs --canopen"),
        (["gateway", "--canopen", "200", "--frames"], "1 to 127"),
        (["gateway", "--canopen", "5", "--map", "machine_builder"], "no --map"),
        (["machine", "--speed-up", "fast"], "fast"),
        (["machine", "--wait", "-1"], "--wait"),
        (["machine", "no_such_scenario"], "no_such_scenario"),
        (["machine", "step_speed", "--speed-up", "0.0001"], "step_s"),
        (["machine", "--speed-up", "max", "--set", "step_s=0.0015"], "step_s"),
        (["machine", "replay", "--speed-up", "max"], "--replay"),
        (["machine", "--replay", "none.log"], "none.log"),
        (["machine", "--replay", "x.log", "--out", "y.csv"], "--out"),
    ],
)
def test_bad_input_is_told_in_one_line(arguments, word, capsys, shipped):
    assert main([*arguments, "--fmu-dir", str(shipped)]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len([line for line in lines if "error" in line]) == 1
    assert word in lines[-1]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"degC"', '"K"', "T1: is in degC; the compensator has it in K"),
        ("T1", "oil_7", "oil_7: is missing: the compensator takes it; --dbc or --map names other"),
    ],
)
def test_an_fmu_whose_inputs_the_frames_do_not_carry_is_refused(capsys, tmp_path, old, new, told):
    other = build_tiny(TINY_COMPENSATOR.replace(old, new), "OtherCompensator", tmp_path)
    arguments = ["--interface", "virtual", "--channel", "refused", "--compensator", str(other)]
    assert main(["gateway", *arguments]) == 2
    assert told in capsys.readouterr().err


def test_an_ambient_temperature_that_the_compensator_does_not_take_is_refused(capsys, quick_fmu):
    arguments = ["--interface", "virtual", "--channel", "hall", "--compensator", str(quick_fmu)]
    for name in ("lufft", "tool_length"):
        assert main(["gateway", *arguments, "--ambient", name]) == 2
        assert f"--ambient: {name}: is not one of T1, T2, T3" in capsys.readouterr().err
