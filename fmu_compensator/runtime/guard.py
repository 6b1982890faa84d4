"""How far the present inputs are from all that was trained on, and what is still known there."""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul
from statistics import median
from typing import NamedTuple

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import checked_state, matrices_by_lag, share, taus

LARGEST = 1e6
MOST_DIRECTIONS = 2000
REFERENCES = ("start", "fixed")
CULPRITS = 3
"""At most so many sensors are named when the inputs are outside training."""
CULPRIT_SHARE = 0.15
"""A sensor is named if it brings at least this share of the novelty [1]."""

LEVEL_FAULT_K = 10.0
"""One sensor alone this far from its usual place at the start is wrong by a constant [K]: heat
that is left from before is never in one place only. Its rises are as good as ever."""
LONE = 3.0
"""It is alone if it is so many times further off than any other [1]."""


class Careful(NamedTuple):
    """What the guard says of a sample.

    Attributes
    ----------
    targets : list of float
        What the careful model predicts [um, urad].
    novelty : float
        Variance of that prediction that training did not remove, over training's own noise [1].
    """

    targets: list[float]
    novelty: float


class Guard:
    r"""A Bayesian ridge regression on few features, which knows where it knows nothing.

    .. math::
        y_s = c + A r + \sum_j (B_j L_j[r] + C_j L_j[s]), \qquad
        h = x^T (\lambda I + X^T X)^{-1} x = |x|^2 / \lambda - |D x|^2

    r is the rise of each temperature above its first reading, s how far its first reading lay from
    its usual place among the others (0 for a lone sensor with a wrong level), L_j a first-order lag
    that starts at zero, x all of them in a row. h, the novelty, is the leverage of x: 0 where
    nothing moved yet, about 1 at the edge of what training determines, and growing with the square
    of the distance beyond.

    The error model is believed as far as it stays near the careful one (the leash): it may differ
    by what runs left out of training showed, and no further. Beyond the novelty that training knew,
    the offsets fade in proportion to what is still known.

    Parameters
    ----------
    lags_s : list of float
        Time constants [s].
    reference : {"start", "fixed"}
        Rises count from the first sample, or from fixed temperatures (``usual``); then there is
        no start.
    usual : list of float, one per input
        Usual first reading above the median of all first readings [K], or the fixed reference
        [degC].
    constant : list of float, one per target
        c [um, urad].
    direct, rise_lags, start_lags : matrices, targets x inputs, the latter two one per lag
        A, B and C [um/K, urad/K].
    prior : float
        1 / lambda [1/K^2].
    seen : list of list of float
        D, a row per direction that training saw [1/K].
    known : float
        Novelty up to which the inputs count as known [1].
    leash : list of float, one per target
        How far the error model may be from the careful one [um, urad].
    fade_shortest, fade_longest : tuple of float or None
        How fast the offsets fade with novelty at the shortest and the longest tool, for X, Y, Z:
        error variance per novelty over the variance of the usual drift [1].
    """

    def __init__(
        self,
        lags_s: list[float],
        reference: str,
        usual: list[float],
        constant: list[float],
        direct: list[list[float]],
        rise_lags: list[list[list[float]]],
        start_lags: list[list[list[float]]],
        prior: float,
        seen: list[list[float]],
        known: float,
        leash: list[float],
        fade_shortest: tuple[float | None, ...],
        fade_longest: tuple[float | None, ...],
    ) -> None:
        self.known, self.leash = known, leash
        self._lags_s, self._usual, self._constant = lags_s, usual, constant
        self._fixed = reference == "fixed"
        self._prior, self._seen = prior, seen
        self._fade_shortest = [0.0 if value is None else value for value in fade_shortest]
        self._fade_longest = [0.0 if value is None else value for value in fade_longest]
        # One row of weights per target, over: rises; per lag: lagged rises, starts.
        self._weights = []
        for target, row in enumerate(direct):
            weights = list(row)
            for lag in range(len(lags_s)):
                weights += rise_lags[lag][target] + start_lags[lag][target]
            self._weights.append(weights)
        # Steps are mostly of one length: the lags' shares of it are worth keeping.
        self._elapsed_s, self._shares = 0.0, [0.0] * len(lags_s)
        self.reset()

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> Guard:
        """Return the guard of a file's table.

        Raises
        ------
        ModelFileError
            For the first field that is missing or out of range.
        """
        lags_s = taus(fields, "lags_s")
        width = inputs * (1 + 2 * len(lags_s))
        rows = len(fields.items("seen", 0, MOST_DIRECTIONS, "lists of numbers"))
        leash = fields.numbers("leash", targets, LARGEST)
        for index, value in enumerate(leash):
            if value < 0.0:
                raise fields.refusal(f"leash.{index}", f"{value:g} is not allowed: at least 0")
        guard = cls(
            lags_s,
            fields.choice("reference", REFERENCES),
            fields.numbers("usual", inputs, 1e4),
            fields.numbers("constant", targets, LARGEST),
            fields.matrix("direct", targets, inputs, LARGEST),
            matrices_by_lag(fields, "rise_lags", len(lags_s), targets, inputs),
            matrices_by_lag(fields, "start_lags", len(lags_s), targets, inputs),
            fields.number("prior", 0.0, LARGEST),
            fields.matrix("seen", rows, width, LARGEST) if rows else [],
            fields.number("known", 0.0, LARGEST),
            leash,
            axis_numbers(fields, "fade_shortest"),
            axis_numbers(fields, "fade_longest"),
        )
        fields.done()
        return guard

    def step(self, readings: Sequence[float], elapsed_s: float) -> Careful:
        """Take in one good sample.

        Parameters
        ----------
        readings : sequence of float
            The chosen temperatures, as read [degC].
        elapsed_s : float
            Time since the sample before this one [s]; 0 for the first.
        """
        if not self._started:
            self._begin(readings)
            elapsed_s = 0.0
        rises = [value - first for value, first in zip(readings, self._first, strict=True)]
        if elapsed_s != self._elapsed_s:
            self._elapsed_s = elapsed_s
            self._shares = [share(elapsed_s, tau_s) for tau_s in self._lags_s]
        features = list(rises)
        for lag, part in enumerate(self._shares):
            values = [
                value + part * (rise - value)
                for value, rise in zip(self._lagged[lag], rises, strict=True)
            ]
            self._lagged[lag] = values
            weight = self._settled[lag] = self._settled[lag] + part * (1.0 - self._settled[lag])
            features += values
            features += [weight * start for start in self._starts]
        self._features = features
        novelty = self._prior * sum(map(mul, features, features))
        for direction in self._seen:
            along = sum(map(mul, direction, features))
            novelty -= along * along
        return Careful(
            [
                constant + sum(map(mul, weights, features))
                for constant, weights in zip(self._constant, self._weights, strict=True)
            ],
            max(novelty, 0.0),
        )

    def _begin(self, readings: Sequence[float]) -> None:
        self._started = True
        if self._fixed:
            self._first, self._starts = list(self._usual), [0.0] * len(readings)
            return
        middle = median(readings)
        self._first = list(readings)
        self._starts = [
            value - middle - usual for value, usual in zip(readings, self._usual, strict=True)
        ]
        away = sorted(map(abs, self._starts))
        if len(away) > 1 and away[-1] > LEVEL_FAULT_K and away[-1] > LONE * away[-2]:
            self._starts = [0.0 if abs(start) == away[-1] else start for start in self._starts]

    def usual_start(self, place: int, middle: float) -> float | None:
        """Return what a sensor is likely to read at the start [degC].

        None where rises count from fixed temperatures: then a level cannot be guessed.

        Parameters
        ----------
        place : int
            Of the input.
        middle : float
            Median of what the others read [degC].
        """
        return None if self._fixed else middle + self._usual[place]

    def held(self, targets: Sequence[float], careful: Sequence[float]) -> list[float]:
        """Return an error model's prediction, on its leash to the careful one [um, urad]."""
        return [
            min(max(value, safe - leash), safe + leash)
            for value, safe, leash in zip(targets, careful, self.leash, strict=True)
        ]

    def faded(self, axis: int, novelty: float, tool_share: float, doubt: float) -> float:
        """Return which share of an offset is still backed by what is known, 0 to 1.

        Parameters
        ----------
        axis : int
            0, 1, 2 for X, Y, Z.
        novelty : float
            Of this sample [1].
        tool_share : float
            Where the tool is from the shortest (0) to the longest (1).
        doubt : float
            Share of the error's variance that is left since a measurement, 0 to 1.
        """
        beyond = novelty - self.known
        if beyond <= 0.0:
            return 1.0
        shortest, longest = self._fade_shortest[axis], self._fade_longest[axis]
        return 1.0 / (1.0 + (shortest + tool_share * (longest - shortest)) * beyond * doubt)

    def culprits(self, novelty: float) -> list[int]:
        """Return the places of the inputs that make the last sample new, the worst first."""
        count = len(self._usual)
        shares = [self._prior * value for value in self._features]
        for direction in self._seen:
            along = sum(map(mul, direction, self._features))
            shares = [
                value - along * weight for value, weight in zip(shares, direction, strict=True)
            ]
        parts = [0.0] * count
        for place, (value, feature) in enumerate(zip(shares, self._features, strict=True)):
            parts[place % count] += value * feature
        order = sorted(range(count), key=lambda place: -parts[place])
        named = [place for place in order[:CULPRITS] if parts[place] >= CULPRIT_SHARE * novelty]
        return named or order[:1]

    def reset(self) -> None:
        """Forget everything."""
        count = len(self._usual)
        self._started = False
        self._first, self._starts = [0.0] * count, [0.0] * count
        self._settled = [0.0] * len(self._lags_s)
        self._lagged = [[0.0] * count for _ in self._lags_s]
        self._features = [0.0] * (count * (1 + 2 * len(self._lags_s)))

    def state(self) -> list[float]:
        """Return what is remembered."""
        lagged = [value for values in self._lagged for value in values]
        return [float(self._started), *self._first, *self._starts, *self._settled, *lagged]

    def restore(self, state: Sequence[float]) -> None:
        """Take up the state that `state` returned."""
        values = iter(checked_state(state, len(self.state())))
        self._started = bool(next(values))
        for held in (self._first, self._starts, self._settled, *self._lagged):
            held[:] = [next(values) for _ in held]


def axis_numbers(fields: Fields, key: str) -> tuple[float | None, ...]:
    """Return three numbers or nulls, for X, Y and Z."""
    values = fields.items(key, 3, 3, "numbers or nulls, for X, Y and Z")
    place = f"{fields.place}.{key}" if fields.place else key
    table = Fields({str(n): value for n, value in enumerate(values)}, fields.source, place)
    return tuple(table.number_or_none(str(n), 0.0, LARGEST) for n in range(3))
