"""A value that jumps to random levels after random times."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from measurement.errors import BadInput
from plant_model.drive import MOST_STEPS
from scenarios.signals.base import Duration, FloatArray, Setting, Signal, Value


class RandomSteps(Signal):
    """``kind = "random_steps"``: levels drawn uniformly from *low* to *high*.

    Each level lasts a time drawn uniformly from *dwell_s* = [shortest, longest]. Levels are rounded
    to a multiple of *round_to*, if given. *stops* is the share of levels replaced by zero. The same
    seed gives the same signal; *seed* replaces the scenario's.
    """

    kind: Literal["random_steps"]
    low: Value
    high: Value
    dwell_s: Annotated[list[Duration], Field(min_length=2, max_length=2)]
    round_to: Annotated[float, Field(gt=0.0, le=1e9, allow_inf_nan=False)] | None = None
    stops: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] | None = None

    @model_validator(mode="after")
    def _fits(self) -> RandomSteps:
        if self.low > self.high:
            raise ValueError(f"low, {self.low:g}, must not be above high, {self.high:g}")
        shortest, longest = self.dwell_s
        if not 1.0 <= shortest <= longest:
            raise ValueError("dwell_s must be [shortest, longest], the shortest at least 1 s")
        return self

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the level at each time."""
        own = None if self.seed is None else np.random.default_rng(self.seed)
        random = own or setting.generator()
        shortest, longest = self.dwell_s
        if time_s[-1] / shortest > MOST_STEPS:
            raise BadInput(
                setting.source,
                f"{setting.place}.dwell_s",
                f"{shortest:g} s is too short for {time_s[-1]:g} s: at most {MOST_STEPS} levels",
            )
        # One row of three numbers per level, so that longer scenarios begin like shorter ones.
        count = int(time_s[-1] / shortest) + 2
        dwell, level, stop = random.random((count, 3)).T
        starts = np.concatenate(([0.0], np.cumsum(shortest + dwell * (longest - shortest))[:-1]))
        levels = self.low + level * (self.high - self.low)
        if self.round_to is not None:
            levels = np.clip(np.round(levels / self.round_to) * self.round_to, self.low, self.high)
        levels = np.where(stop < self.stops, 0.0, levels)
        return levels[np.searchsorted(starts, time_s, side="right") - 1]
