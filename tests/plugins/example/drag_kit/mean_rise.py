"""Drift in proportion to the mean of the inputs: as it is fitted, as it runs, and its C twin.

An FMU carries the class that runs, and of this file only what that needs: no numpy.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields

LARGEST = 1e6


class FittedMeanRise(FittedModel):
    """y = b mean(x) with b = argmin sum (y - b mean(x))^2, one b per target."""

    title = "Mean rise"

    def __init__(self, slopes: Array) -> None:
        self.slopes = slopes

    @classmethod
    def fit(cls, task: Task, **options: Any) -> FittedMeanRise:
        """Return the model fitted to the task's runs."""
        mean = np.concatenate([run.inputs.mean(axis=1) for run in task.runs])
        targets = np.concatenate([run.targets for run in task.runs])
        return cls(mean @ targets / (mean @ mean))

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        return {"slopes": self.slopes.tolist()}


C_TWIN = """
#include "../error_model.h"

struct mean_rise {
    struct error_model base;
    size_t inputs, targets;
    const double *slopes;
};

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct mean_rise *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->inputs = inputs;
    self->targets = targets;
    self->slopes = field_numbers(setup, table, "slopes", NULL);
    return &self->base;
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct mean_rise *self = (const struct mean_rise *)model;
    double total = 0.0;
    (void)state;
    for (size_t i = 0; i < self->inputs; i++) {
        total += sample->inputs[i];
    }
    for (size_t target = 0; target < self->targets; target++) {
        targets[target] = self->slopes[target] * (total / (double)self->inputs);
    }
}

const struct error_model_kind mean_rise_kind = {"mean_rise", make, NULL, predict};
"""


class MeanRise(ErrorModel):
    """y = b mean(x), one b per target [um/K, urad/K]."""

    c_twin = C_TWIN

    def __init__(self, slopes: list[float]) -> None:
        self._slopes = slopes

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> MeanRise:
        """Return the model that the file's numbers describe."""
        return cls(fields.numbers("slopes", targets, LARGEST))

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets."""
        mean = sum(inputs) / len(inputs)
        return [slope * mean for slope in self._slopes]
