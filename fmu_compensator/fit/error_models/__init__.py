"""Error models as they are fitted: one file, one model, named like its twin in the runtime."""

from __future__ import annotations

from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.runtime.walk import classes_found


def fitted_models() -> dict[str, type[FittedModel]]:
    """Return every error model that can be fitted, by its kind (= file name)."""
    return classes_found(__name__, __path__, FittedModel)  # type: ignore[type-abstract]
