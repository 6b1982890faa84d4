"""What other controls take an offset in: one file, one control; see `gateway.controls.base`.

Every file of this folder is walked, and so are the entry points of the group
``spindle_drift.controls``. All of them follow manuals; none was tried on a real control.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gateway.controls.base import Control
from measurement.walk import classes_of

GROUP = "spindle_drift.controls"


@cache
def controls() -> dict[str, type[Control]]:
    """Return every control, by name."""
    folder = Path(__file__).parent
    # The base class is only looked for, never made.
    kinds = classes_of(__name__, folder, Control, GROUP)  # type: ignore[type-abstract]
    return {kind.name: kind for kind in kinds}
