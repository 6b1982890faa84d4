"""Error models that other installed distributions add; a compensator FMU has no such module.

Without plug-ins it loads the standard library only, like the runtime that asks.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

from fmu_compensator.runtime.error_models.base import ErrorModel

if TYPE_CHECKING:
    from measurement.plugins import PlugIn

GROUP = "spindle_drift.error_models"


@cache
def plugged_error_models(shipped: Collection[str]) -> dict[str, PlugIn[type[ErrorModel]]]:
    """Return the predicting error models of plug-ins, by kind.

    Parameters
    ----------
    shipped : frozenset of str
        Kinds that the project itself has.

    Raises
    ------
    BadInput
        For a plug-in that is no error model.
    """
    if not entry_points(group=GROUP):
        return {}
    from measurement.plugins import classes_plugged_in

    return classes_plugged_in(GROUP, ErrorModel, shipped)  # type: ignore[type-abstract]
