"""From good readings to the compensated drift and its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, sqrt
from operator import add, mul
from typing import Any

from fmu_compensator.runtime.fields import LARGEST
from fmu_compensator.runtime.modelfile import Model
from fmu_compensator.runtime.spare import Spare
from fmu_compensator.runtime.sums import summed

NOT_KNOWN = -1.0
"""Half width of an unmeasured axis, or before the first sample [um]: given by the FMU's
interface."""
Three = tuple[float, float, float]
NOTHING: Three = (0.0, 0.0, 0.0)
"""Offsets before the first sample [um]: given by what needs no compensation."""


class Prediction:
    """An error model's prediction, corrected by the Gaussian.

    Parameters
    ----------
    model : Model
        A compensator file, read.
    spare : Spare or None
        Replaces broken sensors, which makes the drift less certain.

    Attributes
    ----------
    gaussian : Gaussian
    targets : list of float
        Prediction for the last good sample [um, urad].
    wanted : tuple of float
        Offsets for X, Y, Z, within the limits [um].
    pose : tuple of float
        Elongation, yaw, pitch [um, urad, urad].
    half_width : tuple of float
        Half width of the interval for X, Y, Z [um]; `NOT_KNOWN` without one.
    """

    def __init__(self, model: Model, spare: Spare | None) -> None:
        self.model = model
        self._error_model = model.new_error_model()
        self.gaussian, self._spare = model.new_gaussian(), spare
        self._tool_length: float | None = None
        self._axes: list[list[float]] = []  # derivatives of the drift by the targets, X, Y, Z
        self._spread: list[float] = []  # root of a unit of variance, X, Y, Z [um]
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._error_model.reset()
        self.gaussian.reset()
        self._unmodelled = 0.0  # since the error model last ran [s]
        self._measured: list[float] | None = None  # for an error model that corrects itself
        self.targets = [0.0] * len(self.model.targets)
        self.wanted = NOTHING
        self.pose = NOTHING
        self.half_width: Three = (NOT_KNOWN, NOT_KNOWN, NOT_KNOWN)

    def wait(self, elapsed_s: float) -> None:
        """Let time pass until the next good sample."""
        self._unmodelled += elapsed_s

    def take(self, measured: Sequence[float]) -> None:
        """Condition on the targets measured with this sample [um, urad]; used from the next on.

        If any is not finite, all are ignored.
        """
        if not all(map(isfinite, measured)):
            return
        values = [min(max(value, -LARGEST), LARGEST) for value in measured]
        if self._error_model.uses_measured:
            self._measured = values
            return
        self.gaussian.take([a - b for a, b in zip(values, self.targets, strict=True)])

    def step(
        self,
        inputs: Sequence[float],
        rises: Sequence[float],
        speed: float,
        tool_length: float,
    ) -> None:
        """Set the wanted offsets, the pose and the half widths for a good sample.

        Parameters
        ----------
        inputs : sequence of float
            Inputs of the error model [degC or K].
        rises : sequence of float
            Of the chosen temperatures [K].
        speed : float
            [rpm]
        tool_length : float
            [mm]
        """
        elapsed_s, measured = self._unmodelled, self._measured
        self._unmodelled, self._measured = 0.0, None
        mean = self._error_model.predict(inputs, elapsed_s, speed, measured)
        gaussian, limits, geometry = self.gaussian, self.model.limits, self.model.geometry
        gaussian.step(rises, elapsed_s, speed)
        counted = map(mul, gaussian.mean_share, mean)
        self.targets = targets = list(map(add, counted, gaussian.added))
        x, y, z = drift = geometry.drift(targets, tool_length)
        self.pose = geometry.pose(targets)
        share, saturated = limits.share, limits.saturated
        self.wanted = (
            saturated(0.0 - share * x),
            saturated(0.0 - share * y),
            saturated(0.0 - share * z),
        )
        self.axes(tool_length)
        variance, deviations = gaussian.variance, gaussian.deviations
        extra = NOTHING if self._spare is None else self._spare.added
        half_width = [
            deviations * sqrt(variance * spread * spread + more) + abs(value + sent)
            if spread > 0.0
            else NOT_KNOWN
            for spread, more, value, sent in zip(
                self._spread, extra, drift, self.wanted, strict=True
            )
        ]
        self.half_width = half_width[0], half_width[1], half_width[2]

    def axes(self, tool_length: float) -> list[list[float]]:
        """Return the derivatives of the drift by the targets: `Geometry.weights`."""
        if tool_length != self._tool_length:
            self._tool_length = tool_length
            self._axes = self.model.geometry.weights(tool_length)
            columns = list(zip(*self.gaussian.noise, strict=True))
            along = [[summed(map(mul, row, column)) for column in columns] for row in self._axes]
            self._spread = [sqrt(summed(map(mul, row, row))) for row in along]
        return self._axes

    def state(self) -> dict[str, Any]:
        """Return the whole memory, as values that JSON stores without loss."""
        return {
            "unmodelled": self._unmodelled,
            "measured": self._measured,
            "targets": list(self.targets),
            "wanted": list(self.wanted),
            "pose": list(self.pose),
            "half_width": list(self.half_width),
            "gaussian": self.gaussian.state(),
            "error_model": self._error_model.state(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Restore what `state` returned.

        Raises
        ------
        ValueError
            If the state does not belong to this file.
        """
        if len(state["targets"]) != len(self.model.targets):
            raise ValueError("the state holds other targets than the file")
        self._error_model.restore(state["error_model"])
        self.gaussian.restore(state["gaussian"])
        self._unmodelled = state["unmodelled"]
        self._measured = None if state["measured"] is None else list(state["measured"])
        self.targets = list(state["targets"])
        self.wanted = three(state["wanted"])
        self.pose = three(state["pose"])
        self.half_width = three(state["half_width"])


def three(values: Sequence[float]) -> Three:
    """Return three numbers as a tuple of three."""
    x, y, z = values
    return x, y, z
