"""What only the kernel's bus has: its filters, its tools, error frames, an interface that goes."""

import contextlib
import os
import subprocess
import time
from pathlib import Path

import pytest

from gateway.database import MACHINE
from gateway.node import GatewaySettings
from tests.gateway.bench import WARM
from tests.gateway.bus import Control, gateway_thread
from tests.gateway.conftest import Wire
from tests.patience import until

pytestmark = pytest.mark.vcan
CLOCK = GatewaySettings(machine_clock=True)


def hears(kind: str, frame_id: str, channel: str = "vcan0") -> bool:
    """Return whether the kernel lists a receiver of an identifier on a channel."""
    lines = Path(f"/proc/net/can/rcvlist_{kind}").read_text().lower().splitlines()
    return any(line.split()[:2] == [channel, frame_id] for line in lines)


def test_the_kernel_drops_foreign_frames(vcan, database, quick_fmu):
    with gateway_thread(vcan, database, quick_fmu, CLOCK) as service:
        for frame in database.of(MACHINE):
            assert hears("fil", f"{frame.frame_id:03x}")
        subprocess.run(["cangen", "vcan0", "-g", "0", "-I", "100", "-n", "500"], check=True)
        subprocess.run(["cansend", "vcan0", "210#0011223344556677"], check=True)
        node = service.node
        until(lambda: node.reception.counts["bad_crc"] == 1)
        assert node.reception.counts["foreign"] == 0


def test_bus_off_is_told_and_survived(vcan, database, quick_fmu):
    said: list[str] = []
    with (
        gateway_thread(vcan, database, quick_fmu, CLOCK, said=said),
        contextlib.closing(Control(vcan, database, 1.0)) as control,
    ):
        held = control.settle(WARM)
        # An error frame of the class "bus off", as a controller's driver would give it.
        subprocess.run(["cansend", "vcan0", "20000040#0000000000000000"], check=True)
        until(lambda: any("bus off" in line for line in said))
        until(lambda: any("back" in line for line in said))
        first = len(control.answers)
        control.cycle(WARM)
        assert control.answers[first]["valid"] == "invalid"
        assert control.until_valid(WARM)["dX"] == held["dX"]


@pytest.mark.skipif(os.geteuid() != 0, reason="taking an interface down needs root")
def test_an_interface_that_goes_and_comes_back(vcan, database, quick_fmu):
    name = "vcan9"
    subprocess.run(["ip", "link", "add", "dev", name, "type", "vcan"], check=True)
    try:
        subprocess.run(["ip", "link", "set", name, "up"], check=True)
        wire = Wire(vcan.interface, name)
        with gateway_thread(wire, database, quick_fmu, CLOCK) as service:
            with contextlib.closing(Control(wire, database, 1.0)) as control:
                held = control.settle(WARM)
            subprocess.run(["ip", "link", "set", name, "down"], check=True)
            until(lambda: service.link.lost == "interface_lost")
            assert not service.unit.outputs["valid"] or service.link.lost
            time.sleep(0.8)
            subprocess.run(["ip", "link", "set", name, "up"], check=True)
            until(lambda: not service.link.lost)
            with contextlib.closing(Control(wire, database, 1.0)) as control:
                found = control.ear.until(lambda answer: True, 5.0)
                assert found[0]["valid"] == "invalid"
                for _ in range(10):
                    control.cycle(WARM, state="starting")
                assert control.until_valid(WARM)["dX"] == held["dX"]
    finally:
        subprocess.run(["ip", "link", "delete", name], check=True)
