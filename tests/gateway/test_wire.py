"""The gateway on buses: the same tests on a bus in memory, over the network, and in the kernel."""

import contextlib
import socket
import time

from gateway.node import GatewaySettings
from scenarios.fmu import FmuError
from tests.gateway.bench import WARM
from tests.gateway.bus import Control, Listener, gateway_thread
from tests.gateway.conftest import new_wire

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
