"""The checks that look for broken sensors: one file, one check; see `base`."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from measurement.faults.checks.base import Check
from measurement.walk import classes_of


@cache
def checks() -> tuple[Check, ...]:
    """Return every check, by stage."""
    every = [check() for check in classes_of(__name__, Path(__file__).parent, Check)]
    return tuple(sorted(every, key=lambda check: check.stage))
