"""A further protocol is one file: found in the folder or by entry point, and at work at once."""

import argparse
import contextlib
from importlib.metadata import EntryPoint
from pathlib import Path

from gateway import protocols
from gateway.node import GatewaySettings
from gateway.protocols.base import Adapter, Participant
from measurement import plugins
from scenarios import cli
from tests.gateway.bench import WARM
from tests.gateway.bus import Control, gateway_thread
from tests.gateway.conftest import new_wire
from tests.patience import until


class Lamp(Participant):
    """Shines while the offsets are valid."""

    def __init__(self) -> None:
        self.shines, self.lines, self.operational = False, list[str](), True

    def update(self, now: float, report: object) -> None:
        self.shines = bool(report().state["valid"])

    def hear(self, line: str) -> None:
        self.lines.append(line)


class LampAdapter(Adapter):
    """A lamp by its number."""

    @classmethod
    def add_arguments(cls, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--lamp", type=int, help="which lamp")


def test_every_file_of_the_folder_holds_one_adapter():
    files = {p.stem for p in Path(protocols.__file__).parent.glob("[a-z]*.py")} - {"base"}
    assert {kind.__module__.rpartition(".")[2] for kind in protocols.adapters()} == files
    assert len(protocols.adapters()) == len(files)


def test_another_distribution_adds_one_by_entry_point(monkeypatch):
    point = EntryPoint("lamp", f"{__name__}:LampAdapter", protocols.GROUP)
    points = {protocols.GROUP: (point,)}
    monkeypatch.setattr(plugins, "_points", lambda group: points.get(group, ()))
    protocols.adapters.cache_clear()
    try:
        assert protocols.adapters()[-1].__name__ == "LampAdapter"
        assert "--lamp" in cli.parser_of("gateway").format_help()
    finally:
        protocols.adapters.cache_clear()


def test_a_participant_sees_the_gateway_and_may_hold_it_back(database, quick_fmu):
    wire, lamp = new_wire("virtual"), Lamp()
    settings = GatewaySettings(machine_clock=True, timeout_s=5.0)
    with (
        gateway_thread(wire, database, quick_fmu, settings, participants=[lamp]) as service,
        contextlib.closing(Control(wire, database, 1.0)) as control,
    ):
        control.settle(WARM)
        until(lambda: lamp.shines)
        assert any("status" in line for line in lamp.lines)
        lamp.operational = False
        assert service.node is not None
        steps = service.node.steps
        control.send(control.messages(WARM))
        assert control.ear.next(1.0) is None
        assert service.node.steps == steps
