"""What the gateway's tests share: the frames, FMUs, and buses of several kinds."""

import contextlib
import os
import socket
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import pytest

from fmu_compensator.runtime.modelfile import model_text
from gateway.database import Database
from gateway.mapfile import MAPS
from gateway.mapping import read_database, read_mapping
from gateway.unit import CompensatorUnit
from scenarios.fmu_files import build_compensator
from tests.conftest import once
from tests.fmus.models import five_point_table
from tests.gateway.bench import WARM, Bench
from tests.gateway.bus import Program, Wire
from tests.running import cannot_run

HOLD_S, RECOVER_S, SLEW_UM_PER_S = 2.0, 0.5, 10.0
GROUP = "239.74.163.2"


def vcan_problem(channel: str = "vcan0") -> str:
    """Return why there is no virtual bus of the kernel; empty if there is one."""
    if not hasattr(socket, "AF_CAN"):
        return "this system has no SocketCAN"
    try:
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
            probe.bind((channel,))
    except OSError as error:
        return f"no {channel}: {error.strerror}"
    return ""


def multicast_problem(port: int) -> str:
    """Return why there is no multicast on this system; empty if there is."""
    try:
        wire = Wire("udp_multicast", GROUP, {"port": port})
        with wire.open() as first, wire.open() as second:
            first.send(can.Message(arbitration_id=1, data=b"x", is_extended_id=False))
            return "" if second.recv(1.0) else "multicast frames do not arrive"
    except (OSError, can.CanError) as error:
        return f"no multicast: {error}"


def new_wire(kind: str) -> Wire:
    """Return a bus of a kind, or skip the test; under CI a missing vcan is a failure."""
    if kind == "virtual":
        return Wire("virtual", uuid.uuid4().hex)
    if kind == "vcan":
        if problem := vcan_problem():
            cannot_run(f"{problem}; run python tests/gateway/on_vcan.py")
        return Wire("socketcan", "vcan0")
    # One port for each test process, so that tests side by side do not hear each other.
    port = 43000 + os.getpid() % 2000
    problem = multicast_problem(port)
    if problem:
        pytest.skip(problem)
    return Wire("udp_multicast", GROUP, {"port": port})


VCAN = pytest.param("vcan", marks=pytest.mark.vcan)


@pytest.fixture(params=["virtual", VCAN])
def wire(request: pytest.FixtureRequest) -> Wire:
    """A bus in memory, and the kernel's."""
    return new_wire(request.param)


@pytest.fixture(params=["udp_multicast", VCAN])
def shared_wire(request: pytest.FixtureRequest) -> Wire:
    """A bus of each kind that reaches other processes."""
    return new_wire(request.param)


@pytest.fixture
def vcan() -> Wire:
    """The virtual bus of the kernel; for tests marked vcan."""
    return new_wire("vcan")


@pytest.fixture(scope="session")
def database() -> Database:
    """The shipped frames."""
    return read_database()


@pytest.fixture(scope="session")
def builder() -> Database:
    """The machine-tool builder's frames."""
    mapping = read_mapping(MAPS / "machine_builder.toml")
    assert not mapping.problems
    return mapping.database


@pytest.fixture(scope="session")
def quick_fmu(shared: Path) -> Path:
    """A compensator that uses T1 and T4, and whose safe state takes seconds."""

    def make(new: Path) -> None:
        new.mkdir()
        table = five_point_table()
        table["limits"] |= {"hold_s": HOLD_S, "recover_s": RECOVER_S}
        table["limits"] |= {"slew_um_per_s": SLEW_UM_PER_S, "share": 0.8}
        (new / "quick.json").write_text(model_text(table), encoding="utf-8")
        build_compensator(new / "quick.json", new)

    return once(shared / "quick", make) / "compensator.fmu"


@pytest.fixture
def unit(quick_fmu: Path) -> Iterator[CompensatorUnit]:
    """The quick compensator, loaded."""
    loaded = CompensatorUnit(quick_fmu)
    with contextlib.closing(loaded):
        yield loaded


@pytest.fixture
def bench(database: Database, unit: CompensatorUnit) -> Bench:
    """A gateway without a bus."""
    return Bench(database, unit)


@pytest.fixture
def warm(bench: Bench) -> Bench:
    """The same, whose offsets follow those of a warm machine."""
    bench.settle(WARM)
    return bench


@pytest.fixture
def new_unit(quick_fmu: Path) -> Iterator[Callable[[], CompensatorUnit]]:
    """Makes more compensators."""
    with contextlib.ExitStack() as stack:
        yield lambda: stack.enter_context(contextlib.closing(CompensatorUnit(quick_fmu)))


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Program]]:
    """Starts commands in processes, and ends those that are left."""
    with contextlib.ExitStack() as stack:
        yield lambda *arguments: stack.enter_context(
            contextlib.closing(Program(tmp_path, *arguments))
        )
