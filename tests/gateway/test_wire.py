"""The gateway on buses: the same tests on a bus in memory, over the network, and in the kernel."""

import contextlib
import socket
import time

import can
import numpy as np

from gateway.database import MACHINE
from gateway.link import Link
from gateway.node import GatewaySettings
from scenarios.fmu import FmuError
from tests.gateway.bench import WARM
from tests.gateway.bus import Control, Listener, gateway_thread
from tests.gateway.conftest import SLEW_UM_PER_S, new_wire

STEP_S = 1.0
CLOCK = GatewaySettings(machine_clock=True, timeout_s=2.0)  # a busy computer is no fault


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
        heard = control.ear.challenge
        control.ear.close()  # its own socket is no better off
        control.ear = Listener(wire)
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
        for name in ("dX", "dY", "dZ"):
            values = np.array([answer[name] for answer in control.answers], dtype=float)
            # A lost cycle is made up for in the next answer.
            assert np.abs(np.diff(values)).max() <= 2.0 * SLEW_UM_PER_S * STEP_S + 0.02
        statuses = {str(answer["status"]) for answer in control.answers[first:]}
        # One random frame in 256 has a good CRC by chance; then the loop holds for a moment.
        assert statuses <= {"ok", "holding_missing", "recovering"}
        valid = [answer["valid"] == "valid" for answer in control.answers[first:]]
        assert sum(valid) > 0.9 * len(valid)
        assert control.answers[-1]["dX"] == held["dX"]
    assert service.unit.outputs


def test_a_node_knows_its_own_frames_whatever_their_number():
    wire = new_wire("udp_multicast")
    own, other = (Link(wire.interface, wire.channel, [1], options=wire.options) for _ in range(2))
    numbers = [number.to_bytes(8, "big") for number in range(1000)]  # the kernel keeps fewer
    frames = [can.Message(arbitration_id=1, data=data, is_extended_id=False) for data in numbers]
    with contextlib.closing(own), contextlib.closing(other):
        own.open()
        other.open()
        assert own.send(frames)
        assert not any(own.receive(0.0) for _ in frames)
        assert other.send(frames[:1])
        assert own.receive(1.0)
