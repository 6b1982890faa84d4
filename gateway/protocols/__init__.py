"""The protocols that the gateway speaks: one file, one adapter; see `gateway.protocols.base`.

Every file of this folder is walked, and so are the entry points of the group
``spindle_drift.gateway_protocols``: a further bus is one file, here or in another distribution.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gateway.protocols.base import Adapter
from measurement.walk import classes_of

GROUP = "spindle_drift.gateway_protocols"


@cache
def adapters() -> tuple[type[Adapter], ...]:
    """Return every adapter; those that come with the gateway first, by name."""
    return tuple(classes_of(__name__, Path(__file__).parent, Adapter, GROUP))
