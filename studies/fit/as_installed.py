"""What a fitted model predicts, told by the model that is installed: one form of the equation."""

from __future__ import annotations

from typing import Any

import numpy as np

from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.fields import Fields


def predicted(
    kind: str, table: dict[str, Any], targets: int, run: TrainingRun, measured: Array | None
) -> Array:
    """Return the targets predicted for a run, shape (n, targets) [um, urad].

    Parameters
    ----------
    kind : str
        The error model's.
    table : dict
        Its numbers, as `FittedModel.table` gives them.
    targets : int
    run : TrainingRun
    measured : array (n, targets), optional
        Of the rows, as `FittedModel.predict` takes it.
    """
    model = error_models()[kind].from_fields(Fields(table, kind), run.inputs.shape[1], targets)
    elapsed = np.diff(run.time_s, prepend=run.time_s[0]).tolist()
    told: list[list[float] | None] = [None] * len(elapsed)
    if measured is not None:
        told[1:] = [row.tolist() if np.isfinite(row).all() else None for row in measured[:-1]]
    rows = zip(run.inputs.tolist(), elapsed, run.speed.tolist(), told, strict=True)
    return np.array([model.predict(*row) for row in rows])
