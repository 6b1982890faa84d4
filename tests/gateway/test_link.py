"""The bus that goes and comes: back-off, error frames, queues that are full, logs."""

import contextlib
import errno
from copy import copy
from typing import Any

import can
import pytest

from gateway import link as module
from gateway.codec import Sender
from gateway.database import MACHINE
from gateway.framelog import FrameLog
from gateway.link import FIRST_WAIT_S, LONGEST_WAIT_S, Link
from gateway.replay import recorded
from measurement.errors import BadInput

MESSAGE = can.Message(arbitration_id=0x210, data=bytes(8), is_extended_id=False)


class FakeBus:
    """A bus that fails on demand."""

    def __init__(self) -> None:
        self.incoming: list[can.Message | Exception] = []
        self.sending: Exception | None = None
        self.sent: list[can.Message] = []
        self.shut = False

    def recv(self, timeout: float) -> can.Message | None:
        if not self.incoming:
            return None
        found = self.incoming.pop(0)
        if isinstance(found, Exception):
            raise found
        return found

    def send(self, message: can.Message) -> None:
        if self.sending is not None:
            raise self.sending
        self.sent.append(message)

    def shutdown(self) -> None:
        self.shut = True


class Garage:
    """Opens fake buses, or refuses to."""

    def __init__(self) -> None:
        self.now, self.refusals, self.slept = 0.0, 0, []
        self.opened: list[FakeBus] = []
        self.attempts: list[float] = []

    def open(self, **settings: Any) -> FakeBus:
        self.attempts.append(self.now)
        if self.refusals:
            self.refusals -= 1
            raise OSError(errno.ENODEV, "No such device")
        self.opened.append(FakeBus())
        return self.opened[-1]

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


@pytest.fixture
def garage(monkeypatch: pytest.MonkeyPatch) -> Garage:
    found = Garage()
    monkeypatch.setattr(module.can, "Bus", found.open)
    monkeypatch.setattr(module.time, "sleep", found.sleep)
    return found


def new_link(garage: Garage, said: list[str] | None = None) -> Link:
    lines = [] if said is None else said
    made = Link("fake", "one", [0x210], None, lines.append, lambda: garage.now)
    made.open()
    return made


def listen(link: Link, garage: Garage, seconds: float) -> None:
    """Receive for a while as the gateway does; the fake clock moves while the link sleeps."""
    until = garage.now + seconds
    while garage.now < until:
        before = garage.now
        link.receive(0.1)
        if garage.now == before:
            garage.now += 0.1


def test_a_lost_bus_is_opened_again_with_longer_and_longer_waits(garage):
    said: list[str] = []
    link = new_link(garage, said)
    garage.refusals = 7
    garage.opened[0].incoming.append(can.CanOperationError("Network is down"))
    listen(link, garage, 60.0)
    assert garage.opened[0].shut
    assert not link.lost
    tries = garage.attempts[1:]
    waits = [b - a for a, b in zip([0.0, *tries], tries, strict=False)]
    expected = [FIRST_WAIT_S]
    while len(expected) < 8:
        expected.append(min(2.0 * expected[-1], LONGEST_WAIT_S))
    assert waits == pytest.approx(expected, abs=0.11)
    assert "Network is down" in said[0]
    assert said[-1].endswith("back")


def test_a_bus_that_opens_and_does_not_work_is_tried_less_and_less(garage, monkeypatch):
    """As an interface that is down."""

    def down(bus, timeout):
        raise can.CanOperationError("Network is down")

    link = new_link(garage, said := [])
    monkeypatch.setattr(FakeBus, "recv", down)
    listen(link, garage, 60.0)
    assert (len(garage.attempts) < 12, len(said) < 24) == (True, True)


def test_a_bus_that_works_again_starts_with_the_shortest_wait(garage):
    link = new_link(garage)
    garage.refusals = 4
    garage.opened[0].incoming.append(OSError(errno.ENETDOWN, "Network is down"))
    listen(link, garage, 30.0)
    link.trust()
    garage.opened[-1].incoming.append(OSError(errno.ENETDOWN, "Network is down"))
    lost_at = garage.now
    listen(link, garage, 2.0)
    assert garage.attempts[-1] - lost_at == pytest.approx(FIRST_WAIT_S, abs=0.11)


def test_bus_off_is_a_loss_and_other_error_frames_are_not(garage):
    link = new_link(garage)
    for error_class, lost in ((0x4, ""), (0x100, ""), (0x40, "bus_off")):
        frame = can.Message(arbitration_id=error_class, is_error_frame=True, data=bytes(8))
        garage.opened[0].incoming.append(frame)
        assert link.receive(0.1) is None
        assert link.lost == lost


def test_nothing_is_sent_on_a_lost_bus(garage):
    link = new_link(garage)
    garage.opened[0].incoming.append(OSError("gone"))
    link.receive(0.1)
    assert link.lost == "interface_lost"
    assert not link.send([MESSAGE])
    assert garage.opened[0].sent == []


def test_a_full_queue_is_borne_for_a_while(garage):
    link = new_link(garage)
    bus = garage.opened[0]
    bus.sending = can.CanOperationError("No buffer space available")
    for _ in range(4):
        assert not link.send([MESSAGE])
        garage.now += FIRST_WAIT_S / 5.0
    assert not link.lost
    bus.sending = None
    assert link.send([MESSAGE])
    bus.sending = OSError(errno.ENOBUFS, "No buffer space available")
    for _ in range(2):
        link.send([MESSAGE])
        garage.now += FIRST_WAIT_S
    assert link.lost == "interface_lost"


def test_what_comes_and_goes_is_logged(garage, tmp_path):
    log = FrameLog(tmp_path / "frames.log")
    with contextlib.closing(Link("fake", "one", [0x210], log)) as link:
        link.open()
        garage.opened[0].incoming.append(copy(MESSAGE))
        link.receive(0.1)
        link.send([copy(MESSAGE)])
    with can.LogReader(tmp_path / "frames.log") as reader:
        assert [message.is_rx for message in reader] == [True, False]


def test_an_interface_that_appears_late_is_waited_for(garage):
    garage.refusals = 3
    link = Link("fake", "one", [], None, clock=lambda: garage.now)
    link.open(10.0)
    assert not link.lost
    assert len(garage.attempts) == 4


def test_an_interface_that_never_appears_is_refused(garage):
    garage.refusals = 10**6
    link = Link("fake", "one", [], None, clock=lambda: garage.now)
    with pytest.raises(BadInput, match="fake:one: cannot be opened"):
        link.open(3.0)
    assert garage.now == pytest.approx(3.0)


@pytest.mark.parametrize(
    "message",
    [
        can.Message(arbitration_id=0x210, data=bytes(8), is_extended_id=True),
        can.Message(arbitration_id=0x210, is_remote_frame=True, dlc=8, is_extended_id=False),
        can.Message(arbitration_id=0x210, data=bytes(8), is_fd=True, is_extended_id=False),
    ],
    ids=["extended", "remote", "fd"],
)
def test_frames_of_another_kind_are_not_ours(garage, message):
    link = new_link(garage)
    garage.opened[0].incoming += [message, MESSAGE]
    assert link.receive(0.1) is None
    assert link.receive(0.1) is MESSAGE


def test_the_time_of_day_may_be_set_while_frames_wait(garage, monkeypatch):
    """A frame cannot have arrived before the one that came before it."""
    monkeypatch.setattr(module, "WALL_CLOCK", ("fake",))
    monkeypatch.setattr(module.time, "time", lambda: 1e9 + garage.now + set_s)
    link, set_s, waited = new_link(garage), 0.0, []
    for came_at, set_s, read_at in ((1.0, 0.0, 1.01), (1.1, 3600.0, 1.12), (1.2, 3600.0, 3.2)):
        before = set_s if came_at > 1.1 else 0.0
        stamped = can.Message(arbitration_id=0x210, timestamp=1e9 + came_at + before)
        stamped.is_extended_id = False
        garage.opened[0].incoming.append(stamped)
        garage.now = read_at
        link.receive(0.1)
        waited.append(link.waited_s)
    assert waited == pytest.approx([0.01, 0.12, 2.0])


@pytest.mark.parametrize("content", ["", "hello\n", "(1.0) vcan0 7FF#00\n", "(x) vcan0 210#00\n"])
def test_a_log_without_our_frames_is_refused(tmp_path, content, database):
    path = tmp_path / "frames.log"
    path.write_text(content)
    with pytest.raises(BadInput) as caught:
        recorded(path, database)
    assert "\n" not in str(caught.value)


def test_a_log_of_two_buses_is_refused(tmp_path, database):
    path = tmp_path / "frames.log"
    path.write_text("(1.0) can0 210#00\n(1.0) can1 7FF#00\n")
    assert len(recorded(path, database)) == 1
    path.write_text("(1.0) can0 210#00\n(1.0) can1 210#00\n")
    with pytest.raises(BadInput, match=r"frames\.log: .* on channels can0, can1: keep one$"):
        recorded(path, database)


def test_the_probes_of_a_log_are_played(tmp_path, database):
    path = tmp_path / "frames.log"
    ids = [frame.frame_id for frame in database.events(MACHINE)]
    path.write_text("".join(f"(1.0) vcan0 {number:03X}#00\n" for number in ids))
    assert [message.arbitration_id for message in recorded(path, database)] == ids


@pytest.mark.parametrize("ending", [".trc", ".mf4"])
def test_a_log_that_only_others_write_is_read(ending, tmp_path, database):
    if ending == ".mf4":
        pytest.importorskip("asammdf")
    path = tmp_path / f"frames{ending}"
    sent = Sender(database, MACHINE).messages({"machine_state": "running"})
    with can.Logger(str(path)) as log:
        for number, message in enumerate(sent):
            message.timestamp = 1e9 + 0.001 * number
            log.on_message_received(message)
    found = recorded(path, database)
    assert [(m.arbitration_id, m.data) for m in found] == [(m.arbitration_id, m.data) for m in sent]
