"""The log beside the loop: appended to, turned over, reopened, and never a reason to stop."""

import os
import signal
import threading
import time
from pathlib import Path

import can
import numpy as np
import pytest

from gateway import background, framelog
from gateway.background import Background
from gateway.framelog import FrameLog
from tests.gateway.bus import SERVER
from tests.patience import until

ENDINGS = [".log", ".asc", ".blf"]


def frame(number: int) -> can.Message:
    return can.Message(
        arbitration_id=0x210,
        data=number.to_bytes(8, "little"),
        is_extended_id=False,
        timestamp=1e9 + number,
        channel="vcan0",
    )


def numbers(path: Path) -> list[int]:
    with can.LogReader(str(path)) as reader:
        return [int.from_bytes(message.data, "little") for message in reader]


def logged(path: Path, *messages: can.Message, **options: float) -> None:
    log = FrameLog(path, **options)
    for message in messages:
        log.write(message)
    log.close()


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_log_is_appended_to(tmp_path, ending):
    path = tmp_path / f"frames{ending}"
    for start in (0, 10):
        logged(path, *map(frame, range(start, start + 10)))
    older = tmp_path / f"frames.1{ending}"
    found = (numbers(older) if ending == ".asc" else []) + numbers(path)
    assert found == list(range(20))


def log_and_die(paths: list[Path]) -> None:
    logs = [FrameLog(path) for path in paths]
    for number in range(400):
        if number == 300:
            time.sleep(2.5)
        for log in logs:
            log.write(frame(number))
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.long
def test_a_log_survives_a_kill_but_for_its_last_second(tmp_path):
    paths = [tmp_path / f"frames{ending}" for ending in ENDINGS]
    killed = SERVER.Process(target=log_and_die, args=(paths,))
    killed.start()
    killed.join()
    assert killed.exitcode == -signal.SIGKILL
    for path in paths:
        assert numbers(path)[:300] == list(range(300))
        logged(path, frame(1000))
        assert numbers(path)[-1] == 1000


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_channel_may_have_any_name(tmp_path, ending):
    path = tmp_path / f"frames{ending}"
    channels = ("bus-4711", "a1b2c3d4e5f60718293a4b5c6d7e8f90", "can0", 3)
    messages = [frame(number) for number in range(len(channels))]
    for message, channel in zip(messages, channels, strict=True):
        message.channel = channel
    logged(path, *messages)
    assert numbers(path) == [0, 1, 2, 3]


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_frame_older_than_the_first_keeps_its_day(tmp_path, ending):
    path = tmp_path / f"frames{ending}"
    # The kernel stamped one before this process sent its first.
    logged(path, *map(frame, (1, 0, 2)))
    with can.LogReader(str(path)) as reader:
        times = [message.timestamp for message in reader]
    assert np.diff(times) == pytest.approx([0.0, 1.0])


def test_half_a_line_at_the_end_is_cut_off(tmp_path):
    path = tmp_path / "frames.log"
    path.write_text("(1.0) vcan0 210#0100000000000000 R\n(1.1) vcan0 21")
    logged(path, frame(2))
    assert numbers(path) == [1, 2]


@pytest.mark.parametrize("told", [True, False])
def test_a_renamed_log_is_begun_anew(tmp_path, told):
    path, away = tmp_path / "frames.log", tmp_path / "away.log"
    log = FrameLog(path)
    log.write(frame(1))
    until(lambda: path.stat().st_size > 0)
    path.rename(away)
    if told:
        log.reopen()
    until(path.exists)
    log.write(frame(2))
    log.close()
    assert (numbers(away), numbers(path)) == ([1], [2])


@pytest.mark.long
@pytest.mark.parametrize("ending", ENDINGS)
def test_a_large_log_is_turned_over(tmp_path, ending, monkeypatch):
    monkeypatch.setattr(framelog, "LOOK_S", 0.0)
    monkeypatch.setattr(background, "LAST_S", 30.0)
    path = tmp_path / f"frames{ending}"
    logged(path, *map(frame, range(200)), largest_mb=0.0004)
    parts = sorted(tmp_path.iterdir())
    assert 2 < len(parts) <= framelog.KEPT_LOGS + 1
    assert numbers(path) == [] or numbers(path)[-1] == 199
    kept = sorted(number for part in parts for number in numbers(part))
    assert kept == list(range(kept[0], 200))


def test_a_full_disk_is_told_and_survived(tmp_path, monkeypatch):
    monkeypatch.setattr(framelog, "LOOK_S", 0.0)
    said: list[str] = []
    path = tmp_path / "frames.log"
    path.symlink_to("/dev/full")
    log = FrameLog(path, said.append)
    for number in range(50):
        log.write(frame(number))
    until(lambda: len(said) > 0)
    for _ in range(40):
        log.write(frame(50))
        time.sleep(0.01)
    assert ["No space left" in line for line in said] == [True]
    path.unlink()
    for number in range(50, 150):
        log.write(frame(number))
        time.sleep(0.005)
    log.close()
    assert numbers(path)[-1] == 149
    assert any("written again" in line for line in said)


def test_a_disk_that_takes_no_log_does_not_keep_the_gateway_from_starting(tmp_path, monkeypatch):
    monkeypatch.setattr(framelog, "LOOK_S", 0.05)
    folder, said = tmp_path / "logs", list[str]()
    folder.write_text("no folder yet")
    log = FrameLog(folder / "frames.log", said.append)
    assert "cannot be written" in said[0]
    log.write(frame(1))
    tried = threading.Event()
    log._thread.do(tried.set)  # after frame 1, however busy the machine is
    assert tried.wait(60.0)
    folder.unlink()
    time.sleep(0.1)
    until(lambda: bool(log.write(frame(2)) or (folder / "frames.log").exists()))
    log.close()
    assert set(numbers(folder / "frames.log")) == {2}
    assert any("written again" in line for line in said)


def test_a_job_that_fails_does_not_keep_others_from_being_done(capsys):
    done: list[int] = []
    worker = Background(5)
    worker.do(lambda: [].pop())
    worker.do(lambda: done.append(1))
    assert worker.close()
    assert (done, worker.dropped) == ([1], 1)
    assert "IndexError" in capsys.readouterr().err


def test_a_disk_that_hangs_keeps_nobody_waiting(monkeypatch):
    done, gate = [], threading.Event()
    worker = Background(3)
    worker.do(gate.wait)
    begun = time.monotonic()
    for number in range(100):
        worker.do(lambda number=number: done.append(number))
    assert time.monotonic() - begun < 1.0
    assert worker.dropped >= 96
    monkeypatch.setattr(background, "LAST_S", 0.2)
    assert not worker.close()
    gate.set()
    until(lambda: done == [0, 1, 2] or done == [0, 1])
