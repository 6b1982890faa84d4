"""The gateway on buses: the same tests on a bus in memory, over the network, and in the kernel."""

import contextlib
import socket
import time

import can
import numpy as np

from gateway.database import MACHINE
from gateway.node import GatewaySettings
from scenarios.fmu import FmuError
from tests.gateway.bench import WARM
from tests.gateway.bus import Control, Listener, gateway_thread, wait_for
from tests.gateway.conftest import HOLD_S, SLEW_UM_PER_S, new_wire
from tests.gateway.faults import Messages, corrupted

STEP_S = 1.0
MILD = {"T1": 20.4, "T4": 20.4}
"""A change that no sensor check takes for a jump."""
CLOCK = GatewaySettings(machine_clock=True, timeout_s=2.0)  # a busy computer is no fault


def test_a_fault_on_the_bus_is_survived(wire, database, quick_fmu):
    change = corrupted(1)(database)
    with (
        gateway_thread(wire, database, quick_fmu, CLOCK),
        contextlib.closing(Control(wire, database, STEP_S)) as control,
    ):
        held = control.settle(WARM)
        first = len(control.answers)
        for _ in range(round(HOLD_S / STEP_S) + 5):
            control.cycle(WARM, change)
        answers = control.answers[first:]
        assert all(answer["valid"] == "invalid" for answer in answers)
        assert answers[0]["bus_fault"] == "bad_crc"
        assert answers[0]["status"] == "holding_missing"
        assert answers[0]["dX"] == held["dX"]
        assert answers[-1]["status"] == "zero_missing"
        assert answers[-1]["dX"] == 0.0
        back = control.cycle(WARM)
        for _ in range(20):
            if back["valid"] == "valid":
                break
            back = control.cycle(WARM)
        assert back["valid"] == "valid"
        assert back["dX"] == held["dX"]
        assert_no_step(control)


def assert_no_step(control: Control) -> None:
    for name in ("dX", "dY", "dZ"):
        values = np.array([answer[name] for answer in control.answers], dtype=float)
        # A lost cycle is made up for in the next answer.
        assert np.abs(np.diff(values)).max() <= 2.0 * SLEW_UM_PER_S * STEP_S + 0.02


def test_a_log_holds_every_frame(wire, database, quick_fmu, tmp_path):
    path = tmp_path / "frames.log"
    with (
        gateway_thread(wire, database, quick_fmu, CLOCK, log=path) as service,
        contextlib.closing(Control(wire, database, STEP_S)) as control,
    ):
        sent: Messages = []

        def keep(messages: Messages) -> Messages:
            sent.extend(messages)
            return messages

        for _ in range(5):
            control.cycle({}, keep, state="starting")
        for _ in range(10):
            control.cycle(WARM, keep)
        # An answer may be to the silence before a cycle: the last one is not answered yet.
        sent_s = control.time_s - STEP_S
        wait_for(lambda: service.node is not None and service.node.machine_time_s >= sent_s)
    with can.LogReader(str(path)) as reader:
        logged = list(reader)
    machine = [bytes(m.data) for m in logged if m.arbitration_id >= 0x200]
    given = [bytes(message.data) for message in sent]
    assert machine == given
    heartbeats = [m for m in logged if m.arbitration_id == 0x195]
    assert len(heartbeats) >= 15
    # Received frames carry the kernel's time, sent ones this process's: each is in order.
    for is_received in (True, False):
        some = [m.timestamp for m in logged if (m.arbitration_id >= 0x200) == is_received]
        assert np.diff(some).min() >= 0.0


def test_an_fmu_that_fails_is_told_on_the_bus(wire, database, quick_fmu):
    def fail(values: object, step_s: float) -> None:
        raise FmuError("compensator FMU at 1 s: out of order")

    with (
        contextlib.closing(Control(wire, database, STEP_S)) as control,
        gateway_thread(wire, database, quick_fmu, CLOCK, ends_with=FmuError) as service,
    ):
        control.settle(WARM)
        service.unit.step = fail
        control.send(control.messages(WARM))
        last = control.ear.until(lambda answer: answer["gateway_state"] == "error")[-1]
        assert last["valid"] == "invalid"
        assert last["dX"] == "not_available"


def test_datagrams_that_are_no_frames_are_survived(database, quick_fmu):
    wire = new_wire("udp_multicast")
    with (
        gateway_thread(wire, database, quick_fmu, CLOCK) as service,
        contextlib.closing(Control(wire, database, STEP_S)) as control,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        held = control.settle(WARM)
        for junk in (b"", b"hello", b"\x80", bytes(100)):
            stranger.sendto(junk, (wire.channel, wire.options["port"]))
            time.sleep(0.05)
        control.ear.close()
        heard, control.ear = (
            control.ear.challenge,
            Listener(wire),
        )  # its own socket is no better off
        control.ear.challenge = heard
        assert control.cycle(WARM)["valid"] == "valid"
        assert service.link.junk >= 3
        assert control.answers[-1]["dX"] == held["dX"]


def test_a_flood_of_foreign_frames_does_not_stop_the_loop(wire, database, quick_fmu):
    """Foreign frames and frames with our identifiers and a bad CRC, thousands of them."""
    generator = np.random.default_rng(11)
    own = [frame.frame_id for frame in database.of(MACHINE)]

    def junk() -> can.Message:
        data = bytearray(generator.bytes(int(generator.integers(0, 9))))
        foreign = int(generator.integers(0, 0x800))
        frame_id = int(generator.choice(own)) if generator.random() < 0.05 else foreign
        if frame_id in own and len(data) == 8:
            data[0] = 0  # whatever comes out here is judged by its CRC
        return can.Message(arbitration_id=frame_id, data=bytes(data), is_extended_id=False)

    with (
        gateway_thread(wire, database, quick_fmu, CLOCK) as service,
        contextlib.closing(Control(wire, database, STEP_S)) as control,
        wire.open() as flooder,
    ):
        held = control.settle(WARM)
        first = len(control.answers)
        for _ in range(100):
            for _ in range(30):
                flooder.send(junk())
            control.cycle(WARM)
        assert_no_step(control)
        statuses = {str(answer["status"]) for answer in control.answers[first:]}
        # One random frame in 256 has a good CRC by chance; then the loop holds for a moment.
        assert statuses <= {"ok", "holding_missing", "recovering"}
        valid = [answer["valid"] == "valid" for answer in control.answers[first:]]
        assert sum(valid) > 0.9 * len(valid)
        assert control.answers[-1]["dX"] == held["dX"]
    assert service.unit.outputs
