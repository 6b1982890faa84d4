"""The finite-element spindle, reduced to a few thermal modes per regime of speed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import exp, expm1
from typing import NamedTuple

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import LARGEST, Fields
from fmu_compensator.runtime.lags import known_speed
from fmu_compensator.runtime.sums import summed


class Source(NamedTuple):
    """Heat at speed n: viscous n^(5/3) + load n; below the threshold slow n + load n [W]."""

    viscous: float
    threshold: float
    slow: float
    load: float

    def power(self, speed: float) -> float:
        """Return the heat at a speed [W]."""
        churning = self.slow * speed
        if speed >= self.threshold:
            churning = self.viscous * speed ** (5.0 / 3.0)
        return churning + self.load * speed


class RegimeModes(NamedTuple):
    """Rates of the modes [1/s], modes as columns, forcing per kelvin outside."""

    rates: list[float]
    vectors: list[list[float]]
    outside: list[list[float]]


class FiniteElementModel(ErrorModel):
    r"""Targets are weighted sums of the reduced spindle's response to each drive.

    .. math::
        \dot x_d = -V_k \Lambda_k V_k^T x_d + f_d, \qquad y = c + \sum_d W_d x_d

    Drives d are the heat sources, :math:`f_d = b_d P_d(n)`, and the changes of the outside
    temperatures (air, coolant), :math:`f_d = g_{kd} (u_d - u_d(0))`. The modes
    :math:`V_k, \Lambda_k` are those of the regime k with the nearest speed. Between two samples the
    speed is that of the first and outside temperatures are averaged, so that each step is exact.

    Parameters
    ----------
    speeds : list of float
        Of the regimes, ascending [r/min].
    regimes : list of RegimeModes
    sources : list of Source
    entries : list of list of float
        b_d, one row per source.
    outside_inputs : list of int
        Which inputs are outside temperatures.
    intercept : list of float
        c, one per target.
    outputs : list of list of float
        W, one row per target, over all coordinates of the first drive, the second, and so on.
    """

    remembers = ("_started", "_speed", "_first", "_last", "_states")

    def __init__(
        self,
        speeds: list[float],
        regimes: list[RegimeModes],
        sources: list[Source],
        entries: list[list[float]],
        outside_inputs: list[int],
        intercept: list[float],
        outputs: list[list[float]],
    ) -> None:
        self._edges = [(a + b) / 2.0 for a, b in pairwise(speeds)]
        self._regimes, self._sources, self._entries = regimes, sources, entries
        self._outside_inputs = outside_inputs
        self._rows = list(zip(intercept, outputs, strict=True))
        self._started = False
        self._speed = 0.0  # at the previous sample [r/min]
        self._first = [0.0] * len(outside_inputs)
        self._last = [0.0] * len(outside_inputs)
        drives = len(sources) + len(outside_inputs)
        self._states = [[0.0] * len(entries[0]) for _ in range(drives)]

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> FiniteElementModel:
        """Return the model that the file's numbers describe."""
        states = fields.integer("states", 1, int(LARGEST))
        outside = fields.items("outside_inputs", "numbers of inputs")
        for index, value in enumerate(outside):
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < inputs:
                raise fields.refusal(f"outside_inputs.{index}", f"must be from 0 to {inputs - 1}")
        speeds, regimes = [], []
        for table in fields.tables("regimes", "regimes", 1):
            speeds.append(table.number("speed", 0.0, LARGEST))
            if len(speeds) > 1 and speeds[-1] <= speeds[-2]:
                raise table.refusal("speed", f"must be above {speeds[-2]:g}, the one before")
            rates = table.numbers("rates", states)
            for index, rate in enumerate(rates):
                if not rate > 0.0:
                    raise table.refusal(f"rates.{index}", f"{rate:g} must be above 0")
            regimes.append(
                RegimeModes(
                    rates,
                    table.matrix("vectors", states, states, 2.0),
                    table.matrix("outside", len(outside), states),
                )
            )
            table.done()
        sources, entries = [], []
        for table in fields.tables("sources", "sources", 1):
            numbers = [table.number(name, 0.0, LARGEST) for name in Source._fields]
            sources.append(Source(*numbers))
            entries.append(table.numbers("entry", states))
            table.done()
        width = states * (len(sources) + len(outside))
        return cls(
            speeds,
            regimes,
            sources,
            entries,
            outside,
            fields.numbers("intercept", targets),
            fields.matrix("outputs", targets, width),
        )

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets; only speed and outside temperatures are used."""
        now = [inputs[index] for index in self._outside_inputs]
        if not self._started:
            self._started, self._first, self._last = True, list(now), now
        if elapsed_s > 0.0:
            self._advance(elapsed_s, now)
        self._last, self._speed = now, known_speed(speed, self._speed)
        flat = [value for state in self._states for value in state]
        return [
            constant + summed(weight * value for weight, value in zip(weights, flat, strict=True))
            for constant, weights in self._rows
        ]

    def _advance(self, elapsed_s: float, now: list[float]) -> None:
        regime = self._regimes[sum(self._speed > edge for edge in self._edges)]
        decay = [exp(-rate * elapsed_s) for rate in regime.rates]
        gain = [-expm1(-rate * elapsed_s) / rate for rate in regime.rates]
        forcing = [
            [source.power(self._speed) * value for value in entry]
            for source, entry in zip(self._sources, self._entries, strict=True)
        ]
        for index, row in enumerate(regime.outside):
            rise = (now[index] + self._last[index]) / 2.0 - self._first[index]
            forcing.append([rise * value for value in row])
        for state, push in zip(self._states, forcing, strict=True):
            modes = []
            for number, (keep, add) in enumerate(zip(decay, gain, strict=True)):
                place, force = 0.0, 0.0
                for row, value, pushed in zip(regime.vectors, state, push, strict=True):
                    place += row[number] * value
                    force += row[number] * pushed
                modes.append(keep * place + add * force)
            state[:] = [
                summed(part * mode for part, mode in zip(row, modes, strict=True))
                for row in regime.vectors
            ]
