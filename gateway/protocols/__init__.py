"""The protocols that the gateway speaks: one file, one adapter; see `gateway.protocols.base`.

Every file of this folder is walked, and so are the entry points of the group
``spindle_drift.gateway_protocols``: a further bus is one file, here or in another distribution.
"""

from __future__ import annotations

import inspect
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

from gateway.protocols.base import Adapter

GROUP = "spindle_drift.gateway_protocols"


@cache
def adapters() -> tuple[type[Adapter], ...]:
    """Return every adapter; those that come with the gateway first, by name."""
    names = sorted(path.stem for path in Path(__file__).parent.glob("[a-z]*.py"))
    modules = [import_module(f"{__name__}.{name}") for name in names if name != "base"]
    found = [kind for module in modules for kind in vars(module).values() if _is_adapter(kind)]
    return (*found, *(point.load() for point in entry_points(group=GROUP)))


def _is_adapter(kind: object) -> bool:
    return inspect.isclass(kind) and issubclass(kind, Adapter) and kind is not Adapter
