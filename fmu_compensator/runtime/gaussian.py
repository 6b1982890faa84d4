"""The Gaussian model at run time: drift from temperatures, its variance, update by measurements."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan, sqrt
from operator import add, mul, sub

from fmu_compensator.runtime.fields import LARGEST, Fields
from fmu_compensator.runtime.lags import behind, checked_state, share, taus
from fmu_compensator.runtime.sums import summed, written_out

MOST_PROBES = 8
"""Number of rows that store how far all measurements narrow the interval; their effect on the mean
stays. Set on no data: the C form computes this many sums side by side."""
FURTHEST = 3.0
"""A measurement that is off by more half widths must be confirmed by the next one [1]: by Student's
t, one sound measurement in 170 is. Set on the lathe's August to October, where three of 18 runs
creep past 2 within an hour; June and July and three simulated machines never do, and the electric
spindle's few pieces gain and lose."""
NAMED = 3
"""Number of sensors that a status text names: in addition to the newest broken one, or those that
make inputs new. Set on no data; odd, so that the C outputs have no gaps."""
FASTEST = 10.0
"""No spindle turns faster than this many times the usual speed of its training [1]: above it the
signal is wrong, and the last known speed holds. Set on no data."""
SPEEDS = 2
"""Inputs that the speed makes: itself and its square [1]: given by the model."""
OF_START, OF_FIXED = "start", "fixed"


class Gaussian:
    r"""Weights, random walk and noise as one Gaussian, conditioned on the training.

    .. math::
        y = a m + W x + b, \qquad
        \mathrm{var}(y) = \Sigma\,(1 + \rho^2 t + \sum_k g_k |x_k|^2 - \sum_i (d_i \cdot x^+)^2)

    m is the error model's prediction, a its share of each target, x the inputs and their
    first-order lags: the rises and, if every training run had it, the speed until now and its
    square. b is a random walk since the start, and x+ = (x, 1) with b's place last. Rows d from
    training end in 0. A measurement adds one row and updates W and b as a Kalman filter does. The
    novelty is the variance due to the weights: g_k |x_k|^2 of the inputs and of each lag, less what
    training determined. Inputs are new if it is the larger part of the variance.

    Parameters
    ----------
    reference : {"start", "fixed"}
        Whether rises count from the first sample or from the fixed temperatures ``usual``.
    usual : list of float, one per input
        The fixed temperatures [degC]; not used with "start".
    constant : list of float, one per target
        The drift at the reference [um, urad].
    mean_share : list of float, one per target
        a: weight of the error model's prediction, 0 to 1 [1]; 1 if omitted.
    settled_h : float
        How long the walk has been running at the first sample [h]; 0 with "start".
    lags_s : list of float
        Time constants [s].
    weights : list of list of float, a row per target
        W: inputs, then lag by lag [um/K, urad/K].
    scale : list of float, one for the inputs and one per lag
        g [1/K^2].
    seen : list of list of float
        d from training [1/K].
    walk_per_h : float
        rho^2 [1/h].
    noise : list of list of float, a row per target
        Lower triangular root of Sigma, the covariance of the noise [um, urad].
    deviations : float
        Half width of the interval in standard deviations [1].
    coverage : float
        Share of unseen drift that the interval should contain [1].
    speed_rpm : float or None
        The speed that counts like a rise of 1 K [rpm]; left out, speed is not used.
    """

    def __init__(
        self,
        reference: str,
        usual: list[float],
        constant: list[float],
        mean_share: list[float],
        settled_h: float,
        lags_s: list[float],
        weights: list[list[float]],
        scale: list[float],
        seen: list[list[float]],
        walk_per_h: float,
        noise: list[list[float]],
        deviations: float,
        coverage: float,
        speed_rpm: float | None = None,
    ) -> None:
        self.fixed = reference == OF_FIXED
        self.usual, self.noise, self.mean_share = usual, noise, mean_share
        self.spread = [sqrt(summed(map(mul, row, row))) for row in noise]  # of each target
        self.deviations, self.coverage = deviations, coverage
        self._constant, self._settled_h, self._unit_rpm = constant, settled_h, speed_rpm
        self._lags_s, self._learnt, self._seen = lags_s, weights, seen
        self._walk_per_h = walk_per_h
        self._inputs = len(weights[0]) // (1 + len(lags_s))
        self._prior = [value for value in scale for _ in range(self._inputs)]
        # The learnt weights are in use until the first measurement.
        rows = [*weights, *seen]
        self._sums = written_out([0.0] * len(rows), rows)
        # Steps mostly have the same length: keep for it how far lags move and inputs are behind.
        self._elapsed_s, self._paces = 0.0, [(0.0, 0.0)] * (self._inputs * len(lags_s))
        self.reset()

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> Gaussian:
        """Return the model of a file's table.

        Raises
        ------
        ModelFileError
            For the first field that is missing or out of range.
        """
        lags_s = taus(fields, "lags_s")
        speed_rpm = fields.number("speed_rpm", 1e-3, 1e6) if fields.has("speed_rpm") else None
        width = (inputs + (0 if speed_rpm is None else SPEEDS)) * (1 + len(lags_s))
        rows = len(fields.items("seen", "lists of numbers"))
        reference = fields.choice("reference", (OF_START, OF_FIXED))
        noise = fields.matrix("noise", targets, targets)
        for place, row in enumerate(noise):
            if not row[place] > 0.0:
                raise fields.refusal(
                    f"noise.{place}.{place}", f"{row[place]:g} is not allowed: above 0"
                )
        model = cls(
            reference,
            fields.numbers("usual", inputs, 1e4) if reference == OF_FIXED else [0.0] * inputs,
            fields.numbers("constant", targets),
            fields.numbers("mean_share", targets, 1.0, low=0.0)
            if fields.has("mean_share")
            else [1.0] * targets,
            fields.number("settled_h", 0.0, 1e6),
            lags_s,
            fields.matrix("weights", targets, width),
            fields.numbers("scale", 1 + len(lags_s), LARGEST, low=0.0),
            fields.matrix("seen", rows, width) if rows else [],
            fields.number("walk_per_h", 0.0, LARGEST),
            noise,
            fields.number("deviations", 0.0, 1e3),
            fields.number("coverage", 0.01, 0.9999),
            speed_rpm,
        )
        fields.number("rows", 0.0, LARGEST)  # for `update`
        fields.done()
        return model

    def reset(self) -> None:
        """Forget everything except what was learnt in training."""
        self._hours, self._speed = self._settled_h, 0.0  # the speed since the last sample [rpm]
        self._features = [0.0] * len(self._learnt[0])  # inputs, then lag by lag [K]
        self._along = [0.0] * len(self._seen)  # products of the features with the rows `seen`
        self._weights = self._learnt
        self._bias = list(self._constant)  # the walk, and the drift at the reference
        self._leaps = 0.0  # variance that confirmed leaps added to the walk, over Sigma [1]
        self._probes: list[list[float]] = []  # rows of d, the walk's place last
        self._suspect: list[float] = []  # the bias according to an unconfirmed measurement
        self.added, self.novelty, self.variance = list(self._constant), 0.0, 1.0
        self._left = self.variance  # of the weights and the walk, after all measurements

    def step(self, rises: Sequence[float], elapsed_s: float, speed: float = nan) -> None:
        """Process one good sample.

        Sets the amount to add to the error model's prediction (``added`` [um, urad]), the variance
        of the sum over Sigma (``variance`` [1]) and the novelty of the inputs (``novelty`` [1]).

        Parameters
        ----------
        rises : sequence of float
            Of the chosen sensors [K].
        elapsed_s : float
            Time since the previous good sample; 0 for the first [s].
        speed : float
            Of the spindle from this sample on [rpm]; NaN: unknown, the last known one continues.
        """
        if elapsed_s != self._elapsed_s:
            self._elapsed_s = elapsed_s
            paces = [(share(elapsed_s, tau), behind(elapsed_s, tau)) for tau in self._lags_s]
            self._paces = [pace for pace in paces for _ in range(self._inputs)]
        self._hours += elapsed_s / 3600.0
        inputs = [*rises]
        if self._unit_rpm is not None:
            # A second look at the same sample, as for a probe, sees the same past.
            turning = self._features[self._inputs - SPEEDS]
            if elapsed_s > 0.0:
                turning = self._speed / self._unit_rpm
            inputs += [turning, turning * turning]
            if self.knows(speed):
                self._speed = abs(speed)
        last, lagged = self._features[: self._inputs], self._features[self._inputs :]
        moves = [*zip(inputs, map(sub, inputs, last), strict=True)] * len(self._lags_s)
        features = inputs
        for value, (part, late), (now, move) in zip(lagged, self._paces, moves, strict=True):
            features.append(value + part * (now - late * move - value))
        sums, targets = self._sums(features), len(self._bias)
        self._features, self._along = features, sums[targets:]
        novelty = summed(map(mul, self._prior, map(mul, features, features)))
        for along in self._along:
            novelty -= along * along
        self.novelty = max(novelty, 0.0)
        left = self.novelty + self._walk_per_h * self._hours + self._leaps
        for row in self._probes:
            along = summed(map(mul, row, features)) + row[-1]
            left -= along * along
        self._left = max(left, 0.0)
        self.variance = 1.0 + self._left
        if self._weights is not self._learnt:
            sums = [summed(map(mul, weights, features)) for weights in self._weights]
        self.added = list(map(add, self._bias, sums))

    @property
    def usual_variance(self) -> float:
        """Variance of noise and walk over Sigma: that in conditions like training [1]."""
        return 1.0 + self._walk_per_h * self._hours

    @property
    def is_new(self) -> bool:
        """Whether more than half of the variance is due to conditions not seen in training."""
        return self.novelty > self.usual_variance

    def knows(self, speed: float) -> bool:
        """Return whether a speed [rpm] can be used, or is not needed."""
        return self._unit_rpm is None or abs(speed) <= FASTEST * self._unit_rpm

    def take(self, missed: Sequence[float]) -> None:
        """Condition on a measurement at the last sample.

        Parameters
        ----------
        missed : sequence of float
            Measured minus predicted (with ``added``) [um, urad].
        """
        furthest = FURTHEST * self.deviations
        limits = [furthest * sqrt(self.variance) * value for value in self.spread]
        if any(abs(value) > limit for value, limit in zip(missed, limits, strict=True)):
            whole = [bias + value for bias, value in zip(self._bias, missed, strict=True)]
            last, self._suspect = self._suspect, whole
            if not last or any(
                abs(a - b) > limit for a, b, limit in zip(whole, last, limits, strict=True)
            ):
                return
            # Confirmed: a joint has settled. Allow the walk a leap of this size.
            sizes = [a / b for a, b in zip(missed, self.spread, strict=True)]
            leap = max(size * size for size in sizes)
            self._leaps += leap
            self._left += leap
        self._suspect = []
        self._condition(missed)

    def _condition(self, missed: Sequence[float]) -> None:
        features = self._features
        column = list(map(mul, self._prior, features))
        walk = self._walk_per_h * self._hours + self._leaps
        covariances = []
        for along, row in zip(self._along, self._seen, strict=True):
            column = [value - along * weight for value, weight in zip(column, row, strict=True)]
        for row in self._probes:
            along = summed(map(mul, row, features)) + row[-1]
            column = [value - along * weight for value, weight in zip(column, row, strict=False)]
            walk -= along * row[-1]
            covariances.append(along)
        size = 1.0 + self._left
        self._weights = [
            [weight + value * miss / size for weight, value in zip(weights, column, strict=True)]
            for weights, miss in zip(self._weights, missed, strict=True)
        ]
        self._bias = [
            bias + walk * miss / size for bias, miss in zip(self._bias, missed, strict=True)
        ]
        if len(self._probes) == MOST_PROBES:
            # Rotating two rows in their plane does not change the variance. Rotate them so that one
            # has no effect on this sample, and drop that one.
            (oldest, kept), (a, b) = self._probes[:2], covariances[:2]
            if a != 0.0:
                length = sqrt(a * a + b * b)
                kept = [(a * u + b * v) / length for u, v in zip(oldest, kept, strict=True)]
            self._probes[:2] = [kept]
        root = sqrt(size)
        self._probes.append([value / root for value in (*column, walk)])

    def culprits(self) -> list[int]:
        """Return the places of the inputs that make the last sample new, the worst first.

        As many as account for half of the novelty, at most `NAMED`; the speed comes after the
        sensors.
        """
        shares = list(map(mul, self._prior, self._features))
        for along, row in zip(self._along, self._seen, strict=True):
            shares = [value - along * weight for value, weight in zip(shares, row, strict=True)]
        parts = [0.0] * self._inputs
        for place, (value, feature) in enumerate(zip(shares, self._features, strict=True)):
            parts[place % self._inputs] += value * feature
        if self._unit_rpm is not None:
            parts[-SPEEDS:] = [sum(parts[-SPEEDS:])]
        named, left = [], 0.5 * self.novelty
        for place in sorted(range(len(parts)), key=lambda place: -parts[place])[:NAMED]:
            named.append(place)
            left -= parts[place]
            if left <= 0.0:
                break
        return named

    def state(self) -> list[float]:
        """Return the memory; it is longer after measurements."""
        changed = [value for row in self._weights for value in row] if self._probes else []
        return [
            self._hours,
            self._speed,
            self._leaps,
            self.novelty,
            self.variance,
            self._left,
            float(len(self._suspect)),
            float(len(self._probes)),
            *self._features,
            *self._bias,
            *self.added,
            *self._suspect,
            *(value for row in self._probes for value in row),
            *changed,
        ]

    def restore(self, state: Sequence[float]) -> None:
        """Restore what `state` returned.

        Raises
        ------
        ValueError
            If the state does not belong to this file.
        """
        targets, width = len(self._constant), len(self._features)
        self.reset()
        shortest = 8 + width + 2 * targets
        numbers = checked_state(state, len(state))
        suspected, probes = (int(value) for value in [*numbers, *[0.0] * 8][6:8])
        if suspected not in (0, targets) or not 0 <= probes <= MOST_PROBES:
            raise ValueError("the state counts measurements that there cannot be")
        changed = targets * width if probes else 0
        values = iter(checked_state(numbers, shortest + suspected + probes * (width + 1) + changed))

        def rows(count: int, length: int) -> list[list[float]]:
            return [[next(values) for _ in range(length)] for _ in range(count)]

        self._hours, self._speed, self._leaps, self.novelty = rows(1, 4)[0]
        self.variance, self._left = rows(1, 2)[0]
        rows(1, 2)
        self._features, self._bias = rows(1, width)[0], rows(1, targets)[0]
        self.added, self._suspect = rows(1, targets)[0], rows(1, suspected)[0]
        self._along = self._sums(self._features)[targets:]
        self._probes = rows(probes, width + 1)
        if probes:
            self._weights = rows(targets, width)
