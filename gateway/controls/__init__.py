"""What other controls take an offset in: one file, one control; see `gateway.controls.base`.

Every file of this folder is walked, and so are the entry points of the group
``spindle_drift.controls``. All of them follow manuals; none was tried on a real control.
"""

from __future__ import annotations

import inspect
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

from gateway.controls.base import Control

GROUP = "spindle_drift.controls"


@cache
def controls() -> dict[str, type[Control]]:
    """Return every control, by name."""
    names = sorted(path.stem for path in Path(__file__).parent.glob("[a-z]*.py"))
    modules = [import_module(f"{__name__}.{name}") for name in names if name != "base"]
    kinds = [kind for module in modules for kind in vars(module).values() if _is_control(kind)]
    kinds += [point.load() for point in entry_points(group=GROUP)]
    return {kind.name: kind for kind in kinds}


def _is_control(kind: object) -> bool:
    return inspect.isclass(kind) and issubclass(kind, Control) and kind is not Control
