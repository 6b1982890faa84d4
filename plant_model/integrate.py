"""Stepping C dT/dt = -L T + f + N(T), exactly in the linear part.

With y = C^(1/2) T the matrix is symmetric, so its modes are orthogonal and decay without
coupling: z(t+h) = e^(-lambda h) z + h phi1 f0 + h phi2 (f1 - f0) is exact for forcing f that is
linear in time (Hochbruck and Ostermann, Acta Numerica 19 (2010) 209-286,
doi:10.1017/S0962492910000048). The temperature-dependent part N is stepped by the third-order
exponential Runge-Kutta scheme of Cox and Matthews (J. Comput. Phys. 176 (2002) 430-455,
doi:10.1006/jcph.2002.6995); the second-order scheme in it gives the error estimate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np

from plant_model.parameters import FloatArray

TOLERANCE = 1e-2
"""Largest estimated local error of a part of a step [K]; the estimate is that of the second-order
scheme. Set on every effect of the catalogue, alone and all at once, on the jig borer in lumps and
on a lathe, in steps of 1 to 120 s: compared with a tolerance of 1e-6 K, temperatures are off by at
most 7e-3 K, and by 0.026 K when coolant stops; a thermometer resolves 0.1 K."""

MOST_PARTS = 100_000
"""Most parts of a step: a step of weeks in which something keeps switching is refused instead of
running on: set on no data."""

ROUNDING = 1e-6
"""A smaller fraction of a part is ignored, because lengths are sums and counts are whole. It is
given by arithmetic: far above rounding, far below any part."""

Forcing = Callable[[FloatArray, FloatArray], FloatArray]
"""Takes the fraction of each run's step (0..1), shape (runs,), and the state in modes, shape (sets,
runs, size); returns the forcing in modes, same shape."""


class IntegrationError(ArithmeticError):
    """Error control cannot reach the tolerance: the model is not finite or changes too fast."""


def phi(order: int, x: FloatArray) -> FloatArray:
    """Return phi_k(x) = (phi_{k-1}(x) - 1/(k-1)!) / x with phi_0 = exp, for x <= 0.

    Near zero the quotient cancels, so a Taylor series replaces it below 0.5 (error under 1e-16).

    Parameters
    ----------
    order : int
        k, 1 or more.
    x : array
        Any shape, none above 0 [1].
    """
    small = np.abs(x) < 0.5
    near, far = x[small], x[~small]
    value, factorial = np.expm1(far) / far, 1.0
    for k in range(2, order + 1):
        factorial *= k - 1
        value = (value - 1.0 / factorial) / far
    series = np.zeros_like(near)
    for j in range(15, -1, -1):
        series *= near
        series += 1.0 / math.factorial(j + order)
    out = np.empty_like(x)
    out[small], out[~small] = series, value
    return out


def step_weights(decay: FloatArray, h: FloatArray | float) -> tuple[FloatArray, ...]:
    """Return e^x, h phi1(x) and h phi2(x) for steps, each (..., sets, size) [1, s, s].

    x = -lambda h with the decay rates lambda, (sets, size) [1/s], and the length h of one step or
    the lengths of several, (steps, 1, 1) [s].
    """
    x = -decay * h
    return np.exp(x), phi(1, x) * h, phi(2, x) * h


def third_order(decay: FloatArray, length: float) -> FloatArray:
    """Return the weights of the third-order scheme in its order, (7, sets, size) [1, s].

    Decay rates are (sets, size) [1/s], the length is in s.
    """
    x = -decay * length
    p1, p2, p3 = (phi(k, x) for k in (1, 2, 3))
    return np.stack(
        [
            np.exp(x / 2.0),
            np.exp(x),
            phi(1, x / 2.0) * (length / 2.0),
            length * p1,
            length * (p1 - 3.0 * p2 + 4.0 * p3),
            length * (4.0 * p2 - 8.0 * p3),
            length * (4.0 * p3 - p2),
        ]
    )


@dataclass(frozen=True)
class Modes:
    """The modes of a network at one set of inputs, followed by the own states of effects.

    Attributes
    ----------
    decay : array, shape (sets or 1, size)
        Decay rate of every mode [1/s], zero for own states.
    to_state, to_modes : array, shape (sets or 1, size, size)
        Matrices from modes to [temperatures, own states] and back.
    weights, third_order : callable
        `step_weights` and `third_order` of a step's length [s].
    """

    decay: FloatArray
    to_state: FloatArray
    to_modes: FloatArray
    weights: Callable[[float], tuple[FloatArray, ...]] = field(init=False, repr=False)
    third_order: Callable[[float], FloatArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Keep the weights for the next step of the same length."""
        object.__setattr__(self, "weights", lru_cache(partial(step_weights, self.decay)))
        object.__setattr__(self, "third_order", lru_cache(partial(third_order, self.decay)))

    @classmethod
    def of(cls, matrix: FloatArray, capacity: FloatArray, state_count: int = 0) -> Modes:
        """Find the modes of L, shape (sets, nodes, nodes), with capacities (sets, nodes).

        Parameters
        ----------
        matrix : array, shape (sets or 1, nodes, nodes)
            Conductances L: symmetric, heat out of a node on the diagonal [W/K].
        capacity : array, shape (sets or 1, nodes)
            [J/K]
        state_count : int
            Number of effects' own states, which come after the nodes and do not decay.

        Returns
        -------
        Modes
            With rates in 1/s.
        """
        root = np.sqrt(capacity)
        scaled = matrix / (root[:, :, None] * root[:, None, :])
        # Sets often differ outside the network only, and the modes cost more than all else.
        unlike = np.any(scaled != scaled[:1], axis=(1, 2))
        which = np.where(unlike, np.cumsum(unlike), 0)
        decay, vectors = (
            part[which] for part in np.linalg.eigh(scaled[np.append(0, np.flatnonzero(unlike))])
        )
        # Heat cannot flow uphill: a negative rate is rounding of an isolated network.
        decay = np.maximum(decay, 0.0)
        to_state = vectors / root[:, :, None]
        to_modes = np.swapaxes(vectors, 1, 2) * root[:, None, :]
        if state_count:
            sets, nodes = decay.shape
            size = nodes + state_count
            decay = np.concatenate([decay, np.zeros((sets, state_count))], axis=1)
            to_state, to_modes = (_with_identity(part, size) for part in (to_state, to_modes))
        return cls(decay, to_state, to_modes)

    def with_state_decay(self, state_decay: FloatArray) -> Modes:
        """Return the same modes with own states that decay at known rates.

        Parameters
        ----------
        state_decay : array, shape (sets, states)
            Decay rates of all own states that the modes were made with [1/s].
        """
        count = state_decay.shape[1]
        kept = self.decay[:, : self.decay.shape[1] - count]
        kept = np.broadcast_to(kept, (max(len(kept), len(state_decay)), kept.shape[1]))
        decay = np.concatenate([kept, np.broadcast_to(state_decay, (len(kept), count))], axis=1)
        return Modes(decay, self.to_state, self.to_modes)


def _with_identity(matrix: FloatArray, size: int) -> FloatArray:
    whole = np.broadcast_to(np.eye(size), (matrix.shape[0], size, size)).copy()
    whole[:, : matrix.shape[1], : matrix.shape[2]] = matrix
    return whole


def apply(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Return matrix (sets or 1, ..., n, m) times vector (sets, ..., m)."""
    if len(matrix) == 1 < len(vector) and vector.ndim == 3:
        # One matrix for all sets: one matrix product instead of one product for each vector.
        together = np.matmul(vector.swapaxes(0, 1), matrix[0].swapaxes(1, 2))
        return np.asarray(together.swapaxes(0, 1))
    return np.asarray(np.matmul(matrix, vector[..., None])[..., 0])


def linear_steps(
    modes: Modes, start: FloatArray, steps: FloatArray, first: FloatArray, last: FloatArray
) -> FloatArray:
    """Step a linear network exactly through many steps.

    Parameters
    ----------
    modes : Modes
        The same for all steps.
    start : array, shape (sets, size)
        State at the start, in modes.
    steps : array, shape (K,)
        Lengths of the steps [s].
    first, last : array, shape (sets, K, size)
        Forcing in modes at the start and end of each step, linear in between.

    Returns
    -------
    array, shape (sets, K, size)
        State at the end of each step, in modes.
    """
    lengths, which = np.unique(steps, return_inverse=True)
    if len(lengths) == 1:
        keep, weight1, weight2 = (part[None] for part in modes.weights(float(lengths[0])))
    else:
        keep, *gains = step_weights(modes.decay, lengths[:, None, None])
        weight1, weight2 = (gain[which] for gain in gains)
    # Steps are the first axis and contiguous, so that the loop has only three short operations.
    first, last = np.swapaxes(first, 0, 1), np.swapaxes(last, 0, 1)
    out = np.ascontiguousarray(weight1 * first + weight2 * (last - first))
    state = start
    for row, k in zip(out, which.tolist(), strict=True):
        state = keep[k] * state
        state += row
        row[...] = state
    return np.swapaxes(out, 0, 1)


class ExponentialRungeKutta:
    """Third-order stepping of runs side by side, each with its own error control.

    Parameters
    ----------
    modes : sequence of Modes
        Modes of the linear part, one for each run.
    tolerance : float
        Local error allowed [K].
    scale : array, shape (size,), optional
        Change of each state that counts as much as 1 K, for own states in other units.

    Attributes
    ----------
    to_state, to_modes : array, shape (sets, runs, size, size)
        Matrices of each run's modes.
    part : array, shape (runs,)
        Fraction of an interval that each run steps at a time [1].
    """

    def __init__(
        self,
        modes: Sequence[Modes],
        tolerance: float = TOLERANCE,
        scale: FloatArray | float = 1.0,
    ) -> None:
        self._modes = list(modes)
        self._tolerance, self._scale = tolerance, scale
        self.to_state = np.stack([of_run.to_state for of_run in modes], axis=1)
        self.to_modes = np.stack([of_run.to_modes for of_run in modes], axis=1)
        self.part = np.ones(len(modes))
        self._lengths = np.full(len(modes), np.nan)
        self._weights = np.empty((7, len(modes[0].decay), *self.to_state.shape[1:3]))

    def enter(self, run: int, modes: Modes) -> None:
        """Let the run at a position continue with other modes."""
        if modes is not self._modes[run]:
            self._modes[run], self._lengths[run] = modes, np.nan
            self.to_state[:, run], self.to_modes[:, run] = modes.to_state, modes.to_modes

    def keep(self, runs: int) -> None:
        """Continue with the first runs only, as many as given."""
        self.to_state, self.to_modes = self.to_state[:, :runs], self.to_modes[:, :runs]
        self.part, self._lengths = self.part[:runs], self._lengths[:runs]
        self._weights = self._weights[:, :, :runs]

    def once(
        self, state: FloatArray, h: FloatArray, forcing: Forcing, at: FloatArray, part: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the state in modes after one step of length h in each run, and its error estimate.

        The step covers the fractions ``at`` to ``at + part`` of the interval of *forcing*.
        """
        for run in np.flatnonzero(h != self._lengths).tolist():
            self._weights[:, :, run] = self._modes[run].third_order(float(h[run]))
        self._lengths = h
        half, full, a_gain, b_gain, w0, wa, wb = self._weights
        f0 = forcing(at, state)
        fa = forcing(at + part / 2.0, half * state + a_gain * f0)
        fb = forcing(at + part, full * state + b_gain * (2.0 * fa - f0))
        end = full * state + w0 * f0 + wa * fa + wb * fb
        return end, wb * (f0 - 2.0 * fa + fb)

    def interval(self, state: FloatArray, lengths: FloatArray, forcing: Forcing) -> FloatArray:
        """Step every run through an interval, in equal parts until the error requires others.

        The error grows with the cube of a part's length, that of fast modes with its square: parts
        are doubled by the cubic rule and shortened by the quadratic one. Counts are whole, so that
        the C form has the same parts and equal parts share their weights.

        Parameters
        ----------
        state : array, shape (sets, runs, size)
            In modes.
        lengths : array, shape (runs,)
            Length of each run's interval [s].
        forcing : callable

        Raises
        ------
        IntegrationError
            If even the smallest split does not reach the tolerance.
        """
        at, parts, part = np.zeros(len(lengths)), 0, self.part
        smallest = np.finfo(np.float64).eps  # a shorter part would not move the time
        left = np.ceil(1.0 / part - ROUNDING)
        while (going := left > 0.0).any():
            part = np.where(going, (1.0 - at) / np.maximum(left, 1.0), part)
            taken = part * going
            # A diverging state overflows: its error is not finite and is refused like any other.
            with np.errstate(over="ignore", invalid="ignore"):
                end, error = self.once(state, lengths * taken, forcing, at, taken)
                off = np.abs(apply(self.to_state, error) / self._scale)
            parts += 1
            worst = off.max(axis=(0, 2))
            excess = worst / self._tolerance
            good = going & (excess <= 1.0)
            again = going & ~good
            stuck = again & ((part <= smallest) | ~np.isfinite(worst))
            if parts > MOST_PARTS or stuck.any():
                run = int(np.argmax(stuck))
                raise IntegrationError(
                    f"an error of {worst[run]:g} is left in a step of "
                    f"{lengths[run] * part[run]:g} s"
                )
            at = np.where(good, at + part, at)
            state = np.where(good[:, None], end, state)
            left = left - good
            longer = good & (excess <= 1.0 / 8.0)
            part = np.where(longer, 2.0 * part, part)
            left = np.where(longer, (left + 1.0) // 2.0, left)
            if again.any():
                most = (1.0 - at) / smallest
                left = np.where(again, np.ceil(np.minimum(left * np.sqrt(excess), most)), left)
        self.part = np.minimum(1.0, part)
        return state
