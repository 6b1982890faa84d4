"""A further protocol is one file: found in the folder or by entry point, and at work at once."""

import argparse
from importlib.metadata import EntryPoint
from pathlib import Path

from gateway import protocols
from gateway.protocols.base import Adapter
from measurement import plugins
from scenarios import cli


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
