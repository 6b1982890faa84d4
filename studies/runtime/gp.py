"""Gaussian-process regression on temperatures and their lags, written out as a sum."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp
from operator import mul

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import share, taus
from fmu_compensator.runtime.sums import summed


class GaussianProcess(ErrorModel):
    r"""A plane and bumps: the prediction of a process with a linear and a Gaussian kernel.

    .. math:: y = c + A x + \sum_i w_i \exp(-|x - z_i|^2 / (2 \ell^2))

    x are the inputs minus their reference (the first sample; zero in the rise form), followed by
    the same after each first-order lag, starting at zero; z_i are centres among the training
    samples.

    Parameters
    ----------
    lags_s : list of float
        Time constants [s].
    length : float
        l [K].
    constant : list of float, one per target [um, urad]
    linear : list of list of float, targets x features [um/K, urad/K]
    centres : list of list of float, centres x features [K]
    weights : list of list of float, targets x centres [um, urad]
    """

    remembers = ("_lagged",)

    def __init__(
        self,
        lags_s: list[float],
        length: float,
        constant: list[float],
        linear: list[list[float]],
        centres: list[list[float]],
        weights: list[list[float]],
        inputs: int,
    ) -> None:
        self._lags_s = lags_s
        self._sharpness = 0.5 / (length * length)
        self._constant, self._linear = constant, linear
        self._centres, self._weights = centres, weights
        self._lagged = [[0.0] * inputs for _ in lags_s]

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> GaussianProcess:
        """Return the model that the file's numbers describe."""
        lags_s = taus(fields, "lags_s")
        width = inputs * (1 + len(lags_s))
        count = len(fields.items("centres", "lists of numbers", 1))
        return cls(
            lags_s,
            fields.number("length", 1e-3, 1e6),
            fields.numbers("constant", targets),
            fields.matrix("linear", targets, width),
            fields.matrix("centres", count, width),
            fields.matrix("weights", targets, count),
            inputs,
        )

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets; speed and measurements are not used."""
        features = list(inputs)
        for lag, tau_s in enumerate(self._lags_s):
            part = share(elapsed_s, tau_s)
            values = [
                value + part * (now - value)
                for value, now in zip(self._lagged[lag], inputs, strict=True)
            ]
            self._lagged[lag] = values
            features += values
        bumps = []
        for centre in self._centres:
            away = 0.0
            for value, place in zip(features, centre, strict=True):
                away += (value - place) * (value - place)
            bumps.append(exp(-self._sharpness * away))
        return [
            constant + summed(map(mul, row, features)) + summed(map(mul, weights, bumps))
            for constant, row, weights in zip(
                self._constant, self._linear, self._weights, strict=True
            )
        ]
