"""The status for the hall, read by a real OPC UA client."""

import asyncio
import contextlib
import os
import signal
import socket
import time
from collections.abc import Callable, Coroutine, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import pytest

from gateway.database import Database
from gateway.node import GatewaySettings
from gateway.protocols.base import Report
from gateway.protocols.opcua import HallStatus, Security, checked_url, security_of
from gateway.serving import Service
from measurement.errors import BadInput
from tests.gateway.bus import Control, gateway_thread
from tests.gateway.conftest import new_wire
from tests.patience import until

asyncua = pytest.importorskip("asyncua")
from asyncua import Client  # noqa: E402
from asyncua.crypto.cert_gen import setup_self_signed_certificate  # noqa: E402
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256  # noqa: E402
from asyncua.ua.uaerrors import UaError  # noqa: E402
from cryptography.x509.oid import ExtendedKeyUsageOID  # noqa: E402

CLOCK = GatewaySettings(machine_clock=True, timeout_s=30.0)  # a busy computer is no fault
MILD = {"T1": 20.4, "T4": 20.4}
NAMESPACE = "https://spindle-drift.invalid/gateway"
T = TypeVar("T")


def free_url() -> str:
    """Return a URL with a port that nobody uses."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"opc.tcp://127.0.0.1:{probe.getsockname()[1]}/spindle-drift"


def patiently(work: Callable[[], Coroutine[Any, Any, T]]) -> T:
    """Return what a client gets, as soon as the server is there."""
    got: list[T] = []

    def tried() -> bool:
        with contextlib.suppress(OSError, TimeoutError, ConnectionError, UaError):
            got.append(asyncio.run(work()))
            return True
        time.sleep(0.3)  # to ask with a certificate takes long
        return False

    until(tried)
    return got[0]


async def found(client: Client, name: str) -> Any:
    """Return a variable of the gateway."""
    index = await client.get_namespace_index(NAMESPACE)
    group = name.partition(".")[0]
    path = ["0:Objects", f"{index}:Gateway", f"{index}:{group}", f"{index}:{name}"]
    return await client.nodes.root.get_child(path)


async def value_of(client: Client, name: str) -> Any:
    """Return a value, None if its status is bad."""
    data = await (await found(client, name)).read_data_value(raise_on_bad_status=False)
    return data.Value.Value if data.StatusCode.is_good() else None


async def validity(client: Client) -> Any:
    """Connect a client, and return whether the offsets are valid."""
    async with client:
        return await value_of(client, "state.valid")


@dataclass
class Hall:
    """A gateway with a hall status, and a control."""

    service: Service
    control: Control
    url: str


@contextlib.contextmanager
def told_hall(database: Database, fmu: Path) -> Iterator[Hall]:
    """A gateway on a bus in memory that tells the hall."""
    url = free_url()
    wire = new_wire("virtual")
    with contextlib.ExitStack() as stack:
        service = stack.enter_context(gateway_thread(wire, database, fmu, CLOCK))
        status = stack.enter_context(contextlib.closing(HallStatus(url, None, service.unit)))
        service.participants.append(status)
        patiently(lambda: validity(Client(url)))  # however long it starts, the machine is heard
        control = stack.enter_context(contextlib.closing(Control(wire, database, 1.0)))
        yield Hall(service, control, url)


@pytest.fixture(scope="module")
def hall(database: Database, quick_fmu: Path) -> Iterator[Hall]:
    """One for all who only read."""
    with told_hall(database, quick_fmu) as one:
        one.control.settle(MILD)
        yield one


@pytest.mark.long
def test_the_hall_reads_what_the_bus_carries(hall):
    answer, unit = hall.control.cycle(MILD), hall.service.unit
    steps = hall.service.node.steps

    async def read() -> dict[str, Any]:
        async with Client(hall.url) as client:
            hall.control.cycle(MILD)
            names = [f"state.{n}" for n in ("steps", "valid", "status", "status_text", "trust")]
            names += ["state.compensator_sha256", "state.gateway_state", "inputs.T1", "inputs.T7"]
            names += ["outputs.dX", "outputs.dX_uncertainty"]
            found_values = {name: await value_of(client, name) for name in names}
            if (found_values["state.steps"] or 0) < steps:
                raise TimeoutError
            node = await (await found(client, "outputs.dX")).get_child("0:EngineeringUnits")
            found_values["unit"] = (await node.read_value()).DisplayName.Text
            return found_values

    values = patiently(read)
    # By now a cycle or two later.
    assert values.pop("outputs.dX_uncertainty") == pytest.approx(
        unit.outputs["dX_uncertainty"], rel=0.02
    )
    assert values.pop("outputs.dX") == pytest.approx(answer["dX"], abs=0.02)
    assert values.pop("inputs.T1") == pytest.approx(20.4)
    assert values.pop("inputs.T7") == pytest.approx(20.0)
    assert values.pop("state.steps") >= steps > 2
    assert values.pop("state.status_text")
    assert values == {
        "unit": "um",
        "state.valid": True,
        "state.status": 0,
        "state.trust": "protected",
        "state.gateway_state": "running",
        "state.compensator_sha256": unit.slave.sha256,
    }


@pytest.mark.long
def test_a_client_knows_the_units_by_their_codes(hall):
    """The ids are those of the OPC Foundation's table, UNECE_to_OPCUA.csv."""
    ids = {"inputs.T1": 4408652, "inputs.speed": 5394509, "inputs.tool_length": 5066068}
    ids |= {"outputs.dX": 13384, "outputs.yaw": 4340023, "state.machine_time": 5457219}

    async def read() -> dict[str, int]:
        async with Client(hall.url) as client:
            nodes = {name: await found(client, name) for name in ids}
            units = {n: await nodes[n].get_child("0:EngineeringUnits") for n in ids}
            return {name: (await unit.read_value()).UnitId for name, unit in units.items()}

    assert patiently(read) == ids


@pytest.mark.long
def test_nothing_can_be_written_or_called_or_added(hall):

    async def attack() -> list[str]:
        refused = []
        async with Client(hall.url) as client:
            node = await found(client, "outputs.dX")
            before = await node.read_value()
            index = await client.get_namespace_index(NAMESPACE)
            objects = client.nodes.objects
            for name, attempt in {
                "write": lambda: node.write_value(1.0),
                "write access": lambda: node.set_writable(),
                "add": lambda: objects.add_variable(index, "mine", 1),
                "delete": lambda: client.delete_nodes([node]),
                "call": lambda: client.nodes.server.call_method("0:GetMonitoredItems", 1),
            }.items():
                try:
                    await attempt()
                except UaError:
                    refused.append(name)
            assert await node.read_value() == pytest.approx(before, abs=1.0)
        return refused

    assert patiently(attack) == ["write", "write access", "add", "delete", "call"]
    hall.control.cycle(MILD)
    assert hall.service.unit.outputs["dX"] != 1.0


@pytest.mark.long
def test_an_administrator_by_name_gets_in_nowhere(hall):
    patiently(lambda: validity(Client(hall.url)))
    client = Client(hall.url)
    client.set_user("admin")
    client.set_password("admin")
    with pytest.raises(UaError):
        asyncio.run(validity(client))


class _Events:
    def __init__(self) -> None:
        self.heard: list[tuple[str, int]] = []

    def event_notification(self, event: Any) -> None:
        self.heard.append((event.Message.Text, event.Severity))


@pytest.mark.long
def test_a_loss_of_validity_is_an_event(hall):

    async def listen() -> list[tuple[str, int]]:
        events = _Events()
        async with Client(hall.url) as client:
            subscription = await client.create_subscription(50, events)
            await subscription.subscribe_events()
            await asyncio.sleep(0.3)
            for _ in range(20):
                # A frame is left out: the cycle cannot be used.
                await asyncio.to_thread(hall.control.cycle, MILD, lambda m: m[1:])
            await asyncio.sleep(1.5)
        return events.heard

    heard = patiently(listen)
    assert any("not valid" in text and severity == 667 for text, severity in heard), heard


@pytest.mark.long
def test_a_gateway_that_stands_still_is_told_from_one_that_has_nothing_new(database, unit):
    unit.start()
    url = free_url()
    with contextlib.closing(HallStatus(url, None, unit)) as status:
        state = dict.fromkeys(("valid", "reference_known"), True) | {"status": 0, "steps": 1}
        state |= dict.fromkeys(("status_text", "gateway_state", "bus_fault", "trust"), "a")
        state |= {"machine_time": 1.0, "compensator": "c", "compensator_sha256": "d"}
        state["status_sensor"] = 0
        patiently(lambda: validity(Client(url)))
        report = Report({}, {"T1": 20.0}, {"dX": 1.0}, state)
        status.update(0.0, lambda: report)

        def shown() -> bool:
            status.update(time.monotonic(), lambda: report)
            return asyncio.run(validity(Client(url))) is True

        until(shown)
        until(lambda: asyncio.run(validity(Client(url))) is None)


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="needs signals")
def test_a_server_that_hangs_keeps_nobody_waiting(database, quick_fmu):
    with told_hall(database, quick_fmu) as hall:
        hall.control.settle(MILD)
        (status,) = hall.service.participants
        os.kill(status._server.pid, signal.SIGSTOP)
        slowest = 0.0
        for _ in range(150):
            begun = time.monotonic()
            for _ in range(10):
                status.hear("x" * 500)
            answer = hall.control.cycle(MILD)
            slowest = max(slowest, time.monotonic() - begun)
        assert answer["valid"] == "valid"
        assert slowest < 2.0
        begun = time.monotonic()
    assert time.monotonic() - begun < 15.0


@pytest.mark.long
def test_a_server_that_is_gone_does_not_end_the_gateway(database, unit):
    unit.start()
    said: list[str] = []
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        url = f"opc.tcp://127.0.0.1:{taken.getsockname()[1]}"
        with contextlib.closing(HallStatus(url, None, unit, said.append)) as status:
            until(lambda: bool(said))
            for _ in range(1000):
                status.hear("x" * 500)
    assert any("the server is gone" in line and "in use" in line for line in said), said


# Certificates


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates of a server, a client that is trusted, and a stranger."""
    folder = tmp_path_factory.mktemp("certificates")
    (folder / "trusted").mkdir()
    for name, use in (
        ("server", ExtendedKeyUsageOID.SERVER_AUTH),
        ("client", ExtendedKeyUsageOID.CLIENT_AUTH),
        ("stranger", ExtendedKeyUsageOID.CLIENT_AUTH),
    ):
        certificate = folder / f"{name}.der"
        asyncio.run(
            setup_self_signed_certificate(
                *(folder / f"{name}.pem", certificate, f"urn:{name}", "localhost", [use]),
                {"commonName": name, "organizationName": "Tests"},
            )
        )
    (folder / "trusted" / "client.der").write_bytes((folder / "client.der").read_bytes())
    return folder


@pytest.mark.long
def test_only_who_is_trusted_reads_with_certificates(certificates, unit):
    unit.start()
    url = free_url()
    security = Security(
        certificates / "server.der", certificates / "server.pem", certificates / "trusted"
    )

    async def visit(name: str) -> str:
        client = Client(url)
        client.application_uri = f"urn:{name}"
        await client.set_security(
            SecurityPolicyBasic256Sha256,
            certificate=str(certificates / f"{name}.der"),
            private_key=str(certificates / f"{name}.pem"),
            server_certificate=str(certificates / "server.der"),
        )
        async with client:
            node = await found(client, "state.valid")
            return str((await node.read_browse_name()).Name)

    with contextlib.closing(HallStatus(url, security, unit)):
        assert patiently(lambda: visit("client")) == "state.valid"
        with pytest.raises((UaError, OSError, TimeoutError)):
            asyncio.run(visit("stranger"))
        with pytest.raises((UaError, OSError, TimeoutError)):
            asyncio.run(validity(Client(url)))  # without any
        assert asyncio.run(visit("client")) == "state.valid"


# The command line


@pytest.mark.parametrize(
    ("url", "problem"),
    [
        ("opc.tcp://0.0.0.0:4840", "can be reached by others"),
        ("opc.tcp://192.0.2.7:4840/x", "can be reached by others"),
        ("opc.tcp://hall:4840", "can be reached by others"),
        ("http://127.0.0.1:4840", "is not of the form"),
        ("opc.tcp://127.0.0.1", "is not of the form"),
        ("opc.tcp://127.0.0.1:99999", "is not of the form"),
    ],
)
def test_a_url_that_others_can_reach_needs_certificates(url, problem):
    with pytest.raises(BadInput, match=problem):
        checked_url(url, None)


def test_a_url_of_this_computer_is_taken(tmp_path):
    for host in ("127.0.0.1", "localhost", "[::1]"):
        assert checked_url(f"opc.tcp://{host}:4840", None)
    with pytest.raises(BadInput, match="no such certificate"):
        checked_url("opc.tcp://0.0.0.0:4840", Security(tmp_path / "a", tmp_path / "b", tmp_path))
    with pytest.raises(BadInput, match="needs --opcua-key"):
        security_of((tmp_path, None, None))
    assert security_of((None, None, None)) is None
