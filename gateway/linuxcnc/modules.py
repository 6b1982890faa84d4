"""LinuxCNC's Python modules, which come with it, not from a package index."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from measurement.errors import BadInput

FOLDER = Path("/usr/lib/python3/dist-packages")
"""Where Debian's package installs them."""


def new_component(name: str, pins: Mapping[tuple[str, str], Iterable[str]]) -> Any:
    """Make a component of HAL with its pins; it is not ready yet.

    Parameters
    ----------
    name : str
        The component's name.
    pins : mapping
        Names of pins, by type (``BIT``, ``S32``, ``FLOAT``) and direction (``IN``, ``OUT``).
    """
    hal = linuxcnc_module("hal")
    component = hal.component(name)
    for (kind, way), names in pins.items():
        for pin in names:
            component.newpin(pin, getattr(hal, f"HAL_{kind}"), getattr(hal, f"HAL_{way}"))
    return component


def linuxcnc_module(name: str) -> Any:
    """Return a module of LinuxCNC.

    Parameters
    ----------
    name : {"hal", "linuxcnc"}
        The module's name.

    Raises
    ------
    BadInput
        If it is not installed, or is for another version of Python.
    """
    # Appended, so that the environment's own libraries come first.
    if str(FOLDER) not in sys.path:
        sys.path.append(str(FOLDER))
    try:
        return import_module(name)
    except ImportError as error:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise BadInput(
            str(FOLDER / name), "", f"LinuxCNC's module is not there for Python {version}: {error}"
        ) from None
