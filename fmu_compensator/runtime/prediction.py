"""From good readings to the drift that is compensated, and how far that may be off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, sqrt
from typing import Any, Protocol

from fmu_compensator.runtime.guard import Guard
from fmu_compensator.runtime.interval import NOT_KNOWN
from fmu_compensator.runtime.modelfile import Model
from fmu_compensator.runtime.spare import Spare

LARGEST = 1e6  # of a measured target [um, urad]; six orders above any spindle


class Prediction:
    """Error model on its leash, corrected by measurements, faded where nothing is known.

    Where the file has a guard, the error model's prediction is kept near a careful one, and the
    offsets fade the further the inputs are from what training knew: `Guard`. Measured targets
    then correct any error model: `Correction`.

    Parameters
    ----------
    model : Model
        A compensator file, read.
    spare : Spare or None
        What stands in for broken sensors, and makes the drift less certain.

    Attributes
    ----------
    guard : Guard or None
    wanted : tuple of float
        Offsets for X, Y, Z, within the limits [um].
    pose : tuple of float
        Elongation, yaw, pitch [um, urad, urad].
    half_width : tuple of float
        Of the interval of X, Y, Z [um]; `NOT_KNOWN` without one.
    novelty : float
        Of the last good sample [1].
    """

    def __init__(self, model: Model, spare: Spare | None) -> None:
        self.model = model
        self._error_model = model.new_error_model()
        self.guard, self._correction, self._spare = model.new_guard(), model.new_correction(), spare
        # An error model that only adds a bias leaves that to the correction.
        self._own_correction = self._correction is None or self._error_model.corrects_itself
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._error_model.reset()
        if self.guard is not None:
            self.guard.reset()
        if self._correction is not None:
            self._correction.reset()
        self._unmodelled = 0.0  # since the error model last ran [s]
        self._measured: list[float] | None = None  # of the sample before, not yet used [um, urad]
        self._predicted: list[float] | None = None  # of the last good sample [um, urad]
        self._followed: list[float] | None = None  # by the correction, not the error model's own
        self._growth = 1.0  # of its error [1]
        self.wanted = (0.0, 0.0, 0.0)
        self.pose = (0.0, 0.0, 0.0)
        self.half_width = (NOT_KNOWN, NOT_KNOWN, NOT_KNOWN)
        self.novelty = 0.0

    def wait(self, elapsed_s: float) -> None:
        """Let time pass until the next good sample."""
        self._unmodelled += elapsed_s

    def take(self, measured: Sequence[float]) -> None:
        """Keep the targets measured with this sample for the next [um, urad].

        What is not finite counts as none.
        """
        if all(map(isfinite, measured)):
            self._measured = [min(max(value, -LARGEST), LARGEST) for value in measured]

    def step(
        self,
        inputs: Sequence[float],
        readings: Sequence[float],
        speed: float,
        tool_length: float,
        since_start_s: float,
    ) -> None:
        """Put down the wanted offsets, the pose and the half widths for a good sample.

        Parameters
        ----------
        inputs : sequence of float
            Of the error model [degC or K].
        readings : sequence of float
            The chosen temperatures [degC].
        speed : float
            [rpm]
        tool_length : float
            [mm]
        since_start_s : float
            Time since the first good sample [s].
        """
        elapsed_s, measured = self._unmodelled, self._measured
        self._unmodelled, self._measured, self._followed = 0.0, None, None
        targets = self._error_model.predict(
            inputs, elapsed_s, speed, measured if self._own_correction else None
        )
        doubt = self._corrected(elapsed_s, measured)
        guard, spare, interval = self.guard, self._spare, self.model.interval
        if guard is not None:
            careful = guard.step(readings, elapsed_s)
            self.novelty = careful.novelty
            targets = self._leashed(guard, targets, careful.targets)
        elif not self._own_correction:
            targets = self._biased(targets)
        geometry, limits = self.model.geometry, self.model.limits
        share = limits.tool_share(tool_length)
        wanted = [0.0 - drift for drift in geometry.drift(targets, tool_length)]
        given_up = (0.0, 0.0, 0.0)
        if guard is not None or spare is not None:
            wanted, given_up = self._faded(wanted, tool_length, share, doubt)
        x, y, z = wanted
        self.wanted = limits.saturated(x), limits.saturated(y), limits.saturated(z)
        self.pose = geometry.pose(targets)
        if interval is not None:
            self._growth = interval.growth(since_start_s, self.novelty)
            self.half_width = interval.half_width(self._growth * sqrt(doubt), share)
            if spare is not None:
                self.half_width = spare.widened(self.half_width, doubt)
            self.half_width = _wider(self.half_width, given_up)
        if self._correction is not None:
            self._predicted = targets if self._followed is None else self._followed

    def _faded(
        self, wanted: list[float], tool_length: float, share: float, doubt: float
    ) -> tuple[list[float], tuple[float, float, float]]:
        """Return offsets in proportion to what is known, and how much was given up [um].

        What is not known falls back to what was measured last; to zero if nothing was.
        """
        guard, spare, correction = self.guard, self._spare, self._correction
        new = guard is not None and self.novelty > guard.known
        if not new and spare is None:
            return wanted, (0.0, 0.0, 0.0)
        last: Sequence[float] = (0.0, 0.0, 0.0)
        if correction is not None and any(correction.held):
            drift = self.model.geometry.drift(correction.held, tool_length)
            last = [0.0 - value for value in drift]
        found, given_up = [], []
        for axis, offset in enumerate(wanted):
            part = 1.0
            if guard is not None and new:
                part = guard.faded(axis, self.novelty, share, doubt)
            if spare is not None:
                part *= spare.faded(axis, share, doubt)
            moved = (1.0 - part) * (offset - last[axis])
            found.append(offset - moved)
            given_up.append(abs(moved))
        return found, three(given_up)

    def _corrected(self, elapsed_s: float, measured: Sequence[float] | None) -> float:
        """Take in what was measured with the sample before; return the doubt that is left [1]."""
        correction = self._correction
        if correction is None:
            return 1.0
        if measured is not None and self._predicted is not None:
            pairs = zip(measured, self._predicted, strict=True)
            missed = [value - predicted for value, predicted in pairs]
            correction.take(missed, self._growth, self._predicted)
        correction.wait(elapsed_s)
        return correction.doubt

    def _leashed(
        self, guard: Guard, targets: Sequence[float], careful: Sequence[float]
    ) -> list[float]:
        """Return a prediction near the careful one, both with what measurements corrected.

        An error model that corrects itself is not corrected again; there the correction follows
        the careful model, so that the leash moves with what was measured.
        """
        if self._correction is None:
            return guard.held(targets, careful)
        if not self._own_correction:
            return self._biased(guard.held(targets, careful))
        self._followed = self._biased(careful)
        return guard.held(targets, self._followed)

    def _biased(self, targets: Sequence[float]) -> list[float]:
        assert self._correction is not None
        return [value + b for value, b in zip(targets, self._correction.bias, strict=True)]

    def state(self) -> dict[str, Any]:
        """Return everything remembered, as values that JSON carries without loss."""
        return {
            "unmodelled": self._unmodelled,
            "measured": self._measured,
            "wanted": list(self.wanted),
            "pose": list(self.pose),
            "half_width": list(self.half_width),
            "predicted": self._predicted,
            "growth": self._growth,
            "novelty": self.novelty,
            "guard": [] if self.guard is None else self.guard.state(),
            "correction": [] if self._correction is None else self._correction.state(),
            "error_model": self._error_model.state(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned.

        Raises
        ------
        ValueError
            If the state is not one of this file's.
        """
        self._error_model.restore(state["error_model"])
        restore_part(self.guard, state, "guard")
        restore_part(self._correction, state, "correction")
        self._unmodelled = state["unmodelled"]
        self._measured = None if state["measured"] is None else list(state["measured"])
        self.wanted = three(state["wanted"])
        self.pose = three(state["pose"])
        self.half_width = three(state["half_width"])
        self._predicted = None if state["predicted"] is None else list(state["predicted"])
        self._growth, self.novelty = state["growth"], state["novelty"]


class _Restorable(Protocol):
    def restore(self, state: Sequence[float]) -> None: ...


def restore_part(part: _Restorable | None, state: Mapping[str, Any], name: str) -> None:
    """Give a part of a compensator its state.

    Raises
    ------
    ValueError
        If the state is not one of the part's, or there is one and no such part.
    """
    if part is not None:
        part.restore(state[name])
    elif len(state[name]) != 0:
        raise ValueError(f"the state holds a {name}, the file has none")


def _wider(
    half_width: tuple[float, float, float], by: tuple[float, float, float]
) -> tuple[float, float, float]:
    x, y, z = (
        width if width == NOT_KNOWN else width + more
        for width, more in zip(half_width, by, strict=True)
    )
    return x, y, z


def three(values: Sequence[float]) -> tuple[float, float, float]:
    """Return three numbers as a tuple of three."""
    x, y, z = values
    return x, y, z
