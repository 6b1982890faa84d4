"""Fitting of the error models: one model per file, named like its twin in the runtime."""

from __future__ import annotations

from functools import cache

from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.plugins import FIT, plugged_classes
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.walk import classes_found


@cache
def fitted_models() -> dict[str, type[FittedModel]]:
    """Return every error model that can be fitted, including those of plug-ins, by kind.

    Raises
    ------
    BadInput
        For a plug-in that cannot be used or has no runtime twin.
    """
    shipped = classes_found(__name__, __path__, FittedModel)  # type: ignore[type-abstract]
    more = plugged_classes(FittedModel, FIT, shipped)  # type: ignore[type-abstract]
    for kind, plugin in more.items():
        if kind not in error_models():
            raise plugin.refuse(f"{kind} has no predicting twin: a subclass of ErrorModel")
    every = shipped | {kind: plugin.thing for kind, plugin in more.items()}
    return dict(sorted(every.items()))
