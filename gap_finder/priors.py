"""Prior knowledge of parameters: a range, taken as a normal distribution in a fitting scale.

A parameter with a positive range is fitted in its logarithm, any other directly. The range is four
standard deviations wide and not a hard limit: values beyond it are unlikely, and only what physics
forbids is impossible (:mod:`plant_model.limits`). A direction has no limits, because beyond half a
turn it comes back from the other side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plant_model.limits import physical_limits
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

DETERMINED = 0.5
"""Prior contraction above which the runs count as determining a parameter [1]: set on no data."""
FAR = 2.0
"""Standard deviations from its value at which a parameter's range ends: given by the meaning of a
range in a machine file [1]."""
TURN = 360.0
"""Range of a direction, given by arithmetic [deg]."""


@dataclass(frozen=True)
class Priors:
    """Some parameters of a machine in their fitting scale: prior mean 0, standard deviation 1.

    Attributes
    ----------
    names : tuple of str
    low, high : array, shape (P,)
        Physical limits, in the fitting scale.
    """

    names: tuple[str, ...]
    _centre: FloatArray
    _width: FloatArray
    _log: npt.NDArray[np.bool_]
    _turns: npt.NDArray[np.bool_]
    low: FloatArray
    high: FloatArray
    _bottom: FloatArray
    _top: FloatArray

    @classmethod
    def of(cls, machine: Machine, *, calibrated: bool) -> Priors:
        """Return the priors of the parameters that calibration may move, or of those it may not.

        They are centred on the machine's values. Neither includes parameters without a range, nor
        parameters of effects that calibration may not move: their range limits the effect and does
        not say how well it is known.
        """
        chosen = {
            name: p
            for name, p in machine.parameters.items()
            if p.high > p.low
            and p.calibrate == calibrated
            and (calibrated or not name.startswith("effects."))
        }
        limits = physical_limits(machine)
        log = np.array([p.low > 0.0 for p in chosen.values()], dtype=np.bool_)
        whole = [p.unit == "deg" and p.high - p.low == TURN for p in chosen.values()]
        turns = np.array(whole, dtype=np.bool_)
        columns = [(p.value, p.low, p.high, *limits[n]) for n, p in chosen.items()]
        plain = np.array(columns, dtype=np.float64).reshape(-1, 5)
        with np.errstate(divide="ignore"):  # The lower limit of a positive number may be 0.
            scaled = np.where(log[:, None], np.log(np.maximum(plain, 0.0)), plain)
        centre, low, high, bottom, top = scaled.T
        width = np.maximum((high - low) / (2.0 * FAR), 1e-300)
        bottom, top = np.where(turns, -np.inf, bottom), np.where(turns, np.inf, top)
        bounds = (bottom - centre) / width, (top - centre) / width
        ends = plain[:, 3], plain[:, 4]
        return cls(tuple(chosen), centre, width, log, turns, *bounds, *ends)

    def position(self, machine: Machine) -> FloatArray:
        """Return a machine's values in the fitting scale, shape (P,)."""
        value = np.array([machine.parameters[name].value for name in self.names])
        plain = np.where(self._log, np.log(np.where(self._log, value, 1.0)), value)
        away = plain - self._centre
        return np.asarray(np.where(self._turns, _within_a_turn(away), away) / self._width)

    def values(self, x: FloatArray) -> dict[str, FloatArray]:
        """Return parameter values, each (sets,), from the fitting scale, shape (sets, P) [1]."""
        plain = self._plain(x)
        plain = np.where(self._turns, _within_a_turn(plain), plain)
        return {name: plain[:, i] for i, name in enumerate(self.names)}

    def beside(self, x: FloatArray, away: FloatArray) -> FloatArray:
        """Return parameter values, (P,), some way from a point, both (P,) [1].

        Those of a direction are beside its own, even beyond half a turn.
        """
        at = self._plain(x)
        return self._plain(x + away) - np.where(self._turns, at - _within_a_turn(at), 0.0)

    def _plain(self, x: FloatArray) -> FloatArray:
        plain = self._centre + np.clip(x, self.low, self.high) * self._width
        plain = np.where(self._log, np.exp(np.where(self._log, plain, 0.0)), plain)
        # Rounding in the logarithm must not lead out of the physical range.
        limited = np.clip(plain, self._bottom, self._top)
        return np.asarray(np.where(self._turns, plain, limited))


def _within_a_turn(angle: FloatArray) -> FloatArray:
    """Return the same direction between minus half a turn and half a turn [deg]."""
    return np.asarray((angle + TURN / 2.0) % TURN - TURN / 2.0)


def heavy_tail(value: float, low: float, high: float, *, log: bool) -> float:
    """Return -2 log of a Cauchy density relative to its maximum.

    Parameters
    ----------
    value, low, high : float
        The usual range is one scale parameter to either side: its ends cost 1.4, five times
        as far 6.5, and nothing is impossible.
    log : bool
        Whether the logarithm has this distribution.
    """
    if log:
        value, low, high = (float(np.log(max(x, 1e-12))) for x in (value, low, high))
    distance = (value - (low + high) / 2.0) / max((high - low) / 2.0, 1e-12)
    return float(2.0 * np.log1p(distance**2))
