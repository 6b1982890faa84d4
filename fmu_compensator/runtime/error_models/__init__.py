"""Error models at run time: one per file, whose name is the model's kind.

Plug-ins can add models. An FMU bundles the one that its file needs, as a file in this folder.
"""

from __future__ import annotations

from functools import cache

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.walk import classes_found


# Walked once: a host may delete an FMU's folder and load the FMU again in the same process; then
# this module is still imported but its folder is gone.
@cache
def shipped_error_models() -> dict[str, type[ErrorModel]]:
    """Return every error model in this folder by kind."""
    return classes_found(__name__, __path__, ErrorModel)  # type: ignore[type-abstract]


@cache
def error_models() -> dict[str, type[ErrorModel]]:
    """Return every error model, including those of plug-ins, by kind."""
    shipped = shipped_error_models()
    try:
        from fmu_compensator.plugins import plugged_error_models
    except ImportError:  # in an FMU
        return shipped
    more = plugged_error_models(frozenset(shipped))
    return dict(sorted((shipped | {kind: plugin.thing for kind, plugin in more.items()}).items()))
