"""Estimates the reading of a broken thermometer from the others."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, expm1, sqrt
from operator import mul
from typing import ClassVar, NamedTuple

from fmu_compensator.runtime.error_models.base import Remembering
from fmu_compensator.runtime.fields import LARGEST, Fields
from fmu_compensator.runtime.sums import summed


class Starts(NamedTuple):
    """References of the rises.

    Attributes
    ----------
    first : list of float
        First reading of each sensor, or its estimate [degC].
    unread : list of int
        Places of the sensors with an estimate.
    """

    first: list[float]
    unread: list[int]


class Spare(Remembering):
    r"""The rises of all chosen sensors as a Gaussian with zero mean and precision matrix P.

    .. math::
        P_{bb}\, r_b = z_b\, e^{-t/\tau} - P_{bg}\, r_g, \qquad
        \mathrm{cov}(r_b) = P_{bb}^{-1}, \text{ each deviation times } \sqrt{g (1 - e^{-2t/\tau})}

    r is the rise above the first reading; b stands for the broken sensors and g for the good ones.
    :math:`z = P r` is the part of a sensor that the others did not explain while it was still good,
    t the time since then: the estimate continues from the last reading. The compensator continues
    as long as one sensor is good.

    A sensor without a reading since the start has the estimated rise. Its start is a guess; once it
    is good, its readings count from the estimate at that time, whose uncertainty remains.

    Parameters
    ----------
    precision : list of list of float
        P, symmetric, one row per chosen sensor [1/K^2].
    growth : list of float, one per chosen sensor
        g: variance of the error on left-out runs, divided by the variance from P [1].
    memory_s : float
        tau: correlation time of a sensor's deviation from its estimate by the others [s].
    usual_start : list of float or None
        Usual reading of each sensor at the start, above the median of all [K]; None if rises
        count from fixed temperatures.
    sensitivity : list of list of float, targets x chosen
        Change of the targets by a lasting error of a reading [um/K, urad/K].
    """

    remembers: ClassVar[tuple[str, ...]] = (
        "_started",
        "_clock",
        "turn",
        *("_first", "_last", "_own", "_seen", "_good_for", "_unread", "_shift"),
        *("_extra", "_lasting"),
    )

    def __init__(
        self,
        precision: list[list[float]],
        growth: list[float],
        memory_s: float,
        usual_start: list[float] | None,
        sensitivity: list[list[float]],
    ) -> None:
        self.usual_start = usual_start
        self._precision, self._growth, self._memory_s = precision, growth, memory_s
        self._sensitivity = sensitivity
        self.reset()

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> Spare:
        """Return the estimator of a file's table.

        Raises
        ------
        ModelFileError
            For the first field that is missing or out of range.
        """
        precision = fields.matrix("precision", inputs, inputs)
        _check_precision(fields, precision)
        growth = fields.numbers("growth", inputs, low=0.0)
        spare = cls(
            precision,
            growth,
            fields.number("memory_s", 1.0, LARGEST),
            None
            if fields.raw("usual_start") is None
            else fields.numbers("usual_start", inputs, 1e4),
            fields.matrix("sensitivity", targets, inputs),
        )
        if fields.has("usual"):
            fields.raw("usual")  # of earlier files, no longer needed
        fields.done()
        return spare

    def reset(self) -> None:
        """Forget everything."""
        count = len(self._growth)
        self._started = False
        self.quiet = False  # no sensor is or was broken recently: readings are used unchanged
        self._clock = 0.0  # since the first sample [s]
        self.turn = 0  # sensor to compare with the others at the next sample
        self._first = [0.0] * count  # readings [degC]
        self._last = [0.0] * count  # readings used [degC]
        self._own = [0.0] * count  # P_ii^-1 z_i, unexplained by the others [K]
        self._seen = [0.0] * count  # time of that comparison by the clock [s]
        self._good_for = [-1.0] * count  # of a broken sensor, since its last bad reading [s]
        self._unread = [0.0] * count  # 1 for a sensor without a reading since the start
        self._shift = [0.0] * count  # to add to its readings, once it reads [K]
        self._extra = [0.0] * 3  # variance of the drift [um^2]
        self._lasting = [0.0] * 3  # the part of it that remains [um^2]

    @property
    def broken(self) -> list[int]:
        """Places of the sensors that are replaced, including those waiting to be used again."""
        return [place for place, good_for in enumerate(self._good_for) if good_for >= 0.0]

    def step(
        self,
        readings: Sequence[float],
        bad: Sequence[int],
        stands: bool,
        elapsed_s: float,
        recover_s: float,
        axes: Sequence[Sequence[float]],
        starts: Starts | None = None,
    ) -> list[float] | None:
        """Process one sample; return the readings to use [degC], None if too much is missing.

        Parameters
        ----------
        readings : sequence of float
            Of the chosen sensors [degC]; those of bad sensors are ignored.
        bad : sequence of int
            Places of the sensors that cannot be used.
        stands : bool
            Whether the reading of the sensor at `turn` is unchanged and so tells nothing new.
        elapsed_s : float
            Time since the previous sample [s].
        recover_s : float
            How long a sensor must be good before it is used again, and how long to wait for it
            before starting without it [s].
        axes : sequence of sequence of float
            Derivatives of the drift along X, Y, Z by the targets: `Geometry.weights`.
        starts : Starts, optional
            References to start with if some sensors are bad; without it all must be good to start.
        """
        if not self._started:
            return self._start(readings, bad, elapsed_s, recover_s, starts)
        self._clock = min(self._clock + elapsed_s, LARGEST)
        self.quiet = False
        self._count(bad, elapsed_s, recover_s)
        broken = self.broken
        if len(broken) == len(readings):
            if bad:
                return None
            # All are good again, and the offsets wait for recovery anyway.
            self._good_for = [-1.0] * len(readings)
            broken = []
        self._read_at_last(readings)
        readings = [value + shift for value, shift in zip(readings, self._shift, strict=True)]
        used = self._filled(readings, broken)
        self._extra = self._added(broken, axes)
        self._compare(used, stands)
        self._last = used
        memories = (self._unread, self._shift, self._extra)
        self.quiet = not self.broken and not any(map(any, memories))
        return used

    def go_on(self, readings: list[float], stands: bool, elapsed_s: float) -> None:
        """Process a sample without bad readings while `quiet`: the readings are used unchanged."""
        self._clock = min(self._clock + elapsed_s, LARGEST)
        self._compare(readings, stands)
        self._last = readings

    def _start(
        self,
        readings: Sequence[float],
        bad: Sequence[int],
        elapsed_s: float,
        recover_s: float,
        starts: Starts | None,
    ) -> list[float] | None:
        """Process a sample before the first one that is used."""
        if not bad:
            self._started = True
            self._clock = 0.0
            self._first = list(readings)
            self._last = list(readings)
            return self._last
        if starts is None or self._clock < recover_s:
            self._clock = min(self._clock + elapsed_s, LARGEST)
            return None
        self._started, self._clock = True, 0.0
        self._first = list(starts.first)
        self._good_for = [0.0 if place in bad else -1.0 for place in range(len(readings))]
        for place in starts.unread:
            self._unread[place] = 1.0
        self._last = self._filled(readings, bad)
        return self._last

    def _read_at_last(self, readings: Sequence[float]) -> None:
        """Let a sensor that is good for the first time continue from its estimate."""
        for place, unread in enumerate(self._unread):
            if unread and self._good_for[place] < 0.0:
                self._unread[place] = 0.0
                self._shift[place] = self._last[place] - readings[place]
                self._lasting = list(map(max, self._lasting, self._extra))

    def _count(self, bad: Sequence[int], elapsed_s: float, recover_s: float) -> None:
        """Track how long the broken sensors have been good again."""
        for place, good_for in enumerate(self._good_for):
            if place in bad:
                self._good_for[place] = 0.0
            elif good_for >= 0.0:
                good_for += elapsed_s
                self._good_for[place] = -1.0 if good_for >= recover_s else good_for

    def _filled(self, readings: Sequence[float], broken: Sequence[int]) -> list[float]:
        """Return the readings with those of broken sensors estimated [degC]."""
        used = list(readings)
        rises = [value - first for value, first in zip(readings, self._first, strict=True)]
        for place in broken:
            rises[place] = 0.0
        pulls = []
        for place in broken:
            row = self._precision[place]
            kept = exp(-(self._clock - self._seen[place]) / self._memory_s)
            pulls.append(row[place] * self._own[place] * kept - summed(map(mul, row, rises)))
        for place, rise in zip(broken, self._solved(broken, pulls), strict=True):
            used[place] = self._first[place] + rise
        return used

    def _solved(self, broken: Sequence[int], right: Sequence[float]) -> list[float]:
        """Return the solution of P_bb x = right, by elimination: P_bb is positive definite."""
        rows = [
            [*(self._precision[row][other] for other in broken), value]
            for row, value in zip(broken, right, strict=True)
        ]
        count = len(rows)
        for at in range(count):
            for below in range(at + 1, count):
                part = rows[below][at] / rows[at][at]
                for column in range(at, count + 1):
                    rows[below][column] -= part * rows[at][column]
        solution = [0.0] * count
        for at in reversed(range(count)):
            known = summed(rows[at][column] * solution[column] for column in range(at + 1, count))
            solution[at] = (rows[at][count] - known) / rows[at][at]
        return solution

    def _added(self, broken: Sequence[int], axes: Sequence[Sequence[float]]) -> list[float]:
        """Return what the broken sensors add to the variance of the drift, for X, Y, Z [um^2]."""
        roots = []
        for place in broken:
            unseen_share = -expm1(-2.0 * (self._clock - self._seen[place]) / self._memory_s)
            roots.append(sqrt(self._growth[place] * unseen_share))
        variances = []
        for weights in axes:
            moved = [
                root
                * summed(w * row[place] for w, row in zip(weights, self._sensitivity, strict=True))
                for place, root in zip(broken, roots, strict=True)
            ]
            variances.append(summed(map(mul, moved, self._solved(broken, moved))))
        return list(map(max, variances, self._lasting))

    def _compare(self, used: Sequence[float], stands: bool) -> None:
        """Store the deviation of one sensor from its estimate by the others; sensors take turns."""
        place = self.turn
        self.turn = (place + 1) % len(used)
        if self._good_for[place] >= 0.0 or stands:
            return
        row = self._precision[place]
        pairs = zip(row, used, self._first, strict=True)
        self._own[place] = summed([a * (value - first) for a, value, first in pairs]) / row[place]
        self._seen[place] = self._clock

    @property
    def added(self) -> list[float]:
        """What broken sensors add to the variance of the drift now, for X, Y, Z [um^2]."""
        return self._extra

    def restore(self, state: Sequence[float]) -> None:
        """Restore what `state` returned.

        Raises
        ------
        ValueError
            If the state does not belong to this file.
        """
        super().restore(state)
        self.quiet = False
        if not 0 <= self.turn < len(self._first):
            raise ValueError(f"the state counts {self.turn} of {len(self._first)} sensors")


def _check_precision(fields: Fields, precision: list[list[float]]) -> None:
    """Refuse a matrix that is not symmetric and positive definite."""
    left = [list(row) for row in precision]
    for i, row in enumerate(precision):
        for j, other in enumerate(precision[:i]):
            if row[j] != other[i]:
                problem = f"{row[j]:g} is not allowed: must be that of precision.{j}.{i}"
                raise fields.refusal(f"precision.{i}.{j}", f"{problem} ({other[i]:g})")
        if not left[i][i] > 0.0:
            problem = f"{row[i]:g} is not allowed: the matrix must be positive definite"
            raise fields.refusal(f"precision.{i}.{i}", problem)
        for below in left[i + 1 :]:
            part = below[i] / left[i][i]
            below[i:] = [a - part * b for a, b in zip(below[i:], left[i][i:], strict=True)]
