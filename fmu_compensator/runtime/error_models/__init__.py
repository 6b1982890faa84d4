"""Error models as they run: one file, one model; the file's name is the model's kind.

Plug-ins add models of their own. An FMU carries the one that its file needs, as a file here.
"""

from __future__ import annotations

from functools import cache

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.walk import classes_found


# Walked once: a host may delete an FMU's folder and load the FMU again in the same process, which
# finds this module still imported and its folder gone.
@cache
def shipped_error_models() -> dict[str, type[ErrorModel]]:
    """Return every error model in this folder, by its kind."""
    return classes_found(__name__, __path__, ErrorModel)  # type: ignore[type-abstract]


@cache
def error_models() -> dict[str, type[ErrorModel]]:
    """Return every error model, those of plug-ins included, by its kind."""
    shipped = shipped_error_models()
    try:
        from fmu_compensator.plugins import plugged_error_models
    except ImportError:  # in an FMU
        return shipped
    more = plugged_error_models(frozenset(shipped))
    return dict(sorted((shipped | {kind: one.thing for kind, one in more.items()}).items()))
