"""The gateway's protocols, one adapter per file; see `gateway.protocols.base`.

Adapters are found in the files of this folder and through the entry points of the group
``spindle_drift.gateway_protocols``, so a new bus is one file, here or in another distribution.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gateway.protocols.base import Adapter
from measurement.walk import classes_of

GROUP = "spindle_drift.gateway_protocols"


@cache
def adapters() -> tuple[type[Adapter], ...]:
    """Return all adapters, those of this folder first, by name."""
    return tuple(classes_of(__name__, Path(__file__).parent, Adapter, GROUP))
