"""Hybrid: a weighted sum of other error models' predictions."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import SAME_SPEED_SHARE, STILL_RPM, known_speed, share
from fmu_compensator.runtime.sums import summed

CONDITIONS = ("stopped", "changing", "steady")
Weights = list[list[float]]


class VectorAngleCosine(ErrorModel):
    r"""y = sum of w_i x_i over the constituent models, each target with its own weights.

    The weights may depend on the condition: the spindle is at a standstill, its speed changed
    recently, or it turns steadily. After a change they adapt within a few minutes. If displacement
    is measured, models that recently did better than in training gain weight: w_i times p_i / s_i,
    where p_i is the squared error in training and s_i the recent one.

    Parameters
    ----------
    models : list of ErrorModel
        The constituents x_i.
    weights : dict of str to list of list of float
        For each condition: targets x models [1].
    settle_s, blend_s, memory_s : float
        How long after a change the speed counts as changing; time constants of the weights and of
        the recent error [s].
    prior : list of list of float, targets x models
        p_i [um^2, urad^2]; empty if measurements should not change the weights.
    """

    remembers = ("_started", "_speed", "_since", "_parts", "_blended", "_errors", "_models")

    def __init__(
        self,
        models: list[ErrorModel],
        weights: dict[str, Weights],
        settle_s: float,
        blend_s: float,
        memory_s: float,
        prior: Weights,
    ) -> None:
        self._models, self._weights, self._prior = models, weights, prior
        self._settle_s, self._blend_s, self._memory_s = settle_s, blend_s, memory_s
        self._targets = len(weights[CONDITIONS[0]])
        self.uses_measured = bool(prior) or any(model.uses_measured for model in models)
        self._started, self._speed, self._since = False, 0.0, 0.0
        self._parts = [[0.0] * self._targets for _ in models]
        self._blended = [[0.0] * len(models) for _ in range(self._targets)]
        self._errors = [list(row) for row in prior]

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> VectorAngleCosine:
        """Return the model that the file's numbers describe."""
        models_by_kind = error_models()
        models = []
        for table in fields.tables("models", "models", 1):
            kind = table.choice("kind", tuple(name for name in models_by_kind if name != "vac"))
            models.append(models_by_kind[kind].from_fields(table, inputs, targets))
            table.done()
        table = fields.table("weights")
        weights = {name: table.matrix(name, targets, len(models)) for name in CONDITIONS}
        table.done()
        prior = []
        if fields.items("prior", "lists of numbers"):
            prior = fields.matrix("prior", targets, len(models))
            for target, row in enumerate(prior):
                for index, value in enumerate(row):
                    if value < 1e-9:
                        place = f"prior.{target}.{index}"
                        raise fields.refusal(place, f"{value:g} is not allowed: at least 1e-9")
        settle, blend, memory = (
            fields.number(key, 1.0, 1e7) for key in ("settle_s", "blend_s", "memory_s")
        )
        return cls(models, weights, settle, blend, memory, prior)

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets."""
        if measured is not None and self._prior:
            self._learn(measured, elapsed_s)
        self._parts = [model.predict(inputs, elapsed_s, speed, measured) for model in self._models]
        self._follow(speed, elapsed_s)
        result = []
        for target, blended in enumerate(self._blended):
            weights = self._in_force(target, blended)
            result.append(
                summed(w * part[target] for w, part in zip(weights, self._parts, strict=True))
            )
        return result

    def _learn(self, measured: Sequence[float], elapsed_s: float) -> None:
        """Update every model's recent error with its error at the previous sample."""
        part = share(elapsed_s, self._memory_s)
        for target, errors in enumerate(self._errors):
            for index, values in enumerate(self._parts):
                missed = min(abs(measured[target] - values[target]), 1e6)
                errors[index] += part * (missed * missed - errors[index])

    def _in_force(self, target: int, blended: list[float]) -> list[float]:
        if not self._prior:
            return blended
        pairs = zip(blended, self._prior[target], self._errors[target], strict=True)
        moved = [w * p / max(s, 1e-3 * p) for w, p, s in pairs]
        total, wanted = summed(moved), summed(blended)
        return [w * wanted / total for w in moved] if total > 0.0 else blended

    def _follow(self, speed: float, elapsed_s: float) -> None:
        """Move the weights towards those of the condition."""
        now = known_speed(speed, self._speed)
        self._since += elapsed_s
        if abs(now - self._speed) > SAME_SPEED_SHARE * max(now, self._speed):
            self._since = 0.0
        self._speed, self._since = now, min(self._since, 1e9)
        condition = "stopped" if now < STILL_RPM else "steady"
        if now >= STILL_RPM and self._since < self._settle_s:
            condition = "changing"
        part = share(elapsed_s, self._blend_s) if self._started else 1.0
        self._started = True
        for row, wanted in zip(self._blended, self._weights[condition], strict=True):
            for index, value in enumerate(wanted):
                row[index] += part * (value - row[index])

    def reset(self) -> None:
        """Forget everything."""
        super().reset()
        for model in self._models:
            model.reset()
        self._errors = [list(row) for row in self._prior]
