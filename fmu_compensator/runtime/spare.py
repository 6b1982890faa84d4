"""What a broken thermometer is likely to read, given the others."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, expm1, sqrt
from operator import mul
from typing import NamedTuple

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import checked_state

MOST_BROKEN = 2
BLEND_S = 120.0
"""A reading that is taken from elsewhere moves there with this time constant [s]."""
FRESH = 0.1
"""A sensor that has stood still for a larger share of what makes it stale tells nothing new [1]."""
START_AFTER_S = 60.0
"""A sensor that does not answer for so long is not waited for: sensors come on line one by one."""
MOST_S = 1e9
LARGEST = 1e9


class Starts(NamedTuple):
    """From where the rises count.

    Attributes
    ----------
    first : list of float
        What each sensor read first, or is likely to have read [degC].
    unread : list of int
        Places of those of which it is only likely.
    """

    first: list[float]
    unread: list[int]


class Spare:
    r"""The rises of all chosen sensors as a Gaussian of mean zero; P is its precision matrix.

    .. math::
        P_{bb}\, r_b = z_b\, e^{-t/\tau} - P_{bg}\, r_g, \qquad
        \mathrm{cov}(r_b) = P_{bb}^{-1}, \text{ each deviation times } \sqrt{g (1 - e^{-2t/\tau})}

    r is the rise above the first reading, b stands for the broken sensors (at most `MOST_BROKEN`)
    and g for the good ones. :math:`z = P r` is what the others did not explain of a sensor while it
    still was good, t since then: the broken one goes on from where it stood. With at most two of
    them no larger system is to be solved than two by two.

    A sensor that never read since the start has a rise all the same: that of the estimate. Where it
    starts is a guess; once it is good, its readings count from where the estimate is then, and what
    that was uncertain by stays.

    Parameters
    ----------
    precision : list of list of float
        P, symmetric, a row per chosen sensor [1/K^2].
    growth : list of float, one per chosen sensor
        g: variance of the error on runs left out, over that which P says [1].
    memory_s : float
        tau: how long a sensor's difference from what the others say stays alike [s].
    deviations : float
        Half width of the file's interval in standard deviations [1].
    shortest, longest : list of list of float, 3 x chosen
        What an error of a reading does to the drift along X, Y, Z at the shortest and the longest
        tool [um/K].
    usual_shortest, usual_longest : list of float
        Root mean square drift of training along X, Y, Z at either tool [um]; 0: not measured.
    """

    def __init__(
        self,
        precision: list[list[float]],
        growth: list[float],
        memory_s: float,
        deviations: float,
        shortest: list[list[float]],
        longest: list[list[float]],
        usual_shortest: list[float],
        usual_longest: list[float],
    ) -> None:
        self.deviations = deviations
        self._precision, self._growth, self._memory_s = precision, growth, memory_s
        self._shortest, self._longest = shortest, longest
        self._usual_shortest, self._usual_longest = usual_shortest, usual_longest
        self.reset()

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int) -> Spare:
        """Return the spare of a file's table.

        Raises
        ------
        ModelFileError
            For the first field that is missing or out of range.
        """
        precision = fields.matrix("precision", inputs, inputs, LARGEST)
        _check_precision(fields, precision)
        growth = _not_negative(fields, "growth", inputs, LARGEST)
        usual = [
            _not_negative(fields, f"{tool}_tool_usual_um", 3, 1e6)
            for tool in ("shortest", "longest")
        ]
        spare = cls(
            precision,
            growth,
            fields.number("memory_s", 1.0, LARGEST),
            fields.number("deviations", 0.0, 10.0),
            fields.matrix("shortest_tool_um_per_K", 3, inputs, 1e6),
            fields.matrix("longest_tool_um_per_K", 3, inputs, 1e6),
            *usual,
        )
        fields.done()
        return spare

    def reset(self) -> None:
        """Forget everything."""
        count = len(self._growth)
        self._started = self._stopped = False
        self._clock = 0.0  # since the first sample [s]
        self.turn = 0  # whose reading is compared with the others' in the next sample
        self._first = [0.0] * count  # readings [degC]
        self._last = [0.0] * count  # readings used [degC]
        self._own = [0.0] * count  # P_ii^-1 z_i, what is a sensor's own [K]
        self._seen = [0.0] * count  # when that was, by the clock [s]
        self._gap = [0.0] * count  # on the way from one source to another [K]
        self._good_for = [-1.0] * count  # of a broken sensor, since its last bad reading [s]
        self._unread = [0.0] * count  # 1 for a sensor that has not read since the start
        self._shift = [0.0] * count  # from its readings to those used, once it reads [K]
        self._extra = [0.0] * 3  # variance of the drift [um^2]
        self._lasting = [0.0] * 3  # what stays of it [um^2]

    @property
    def broken(self) -> list[int]:
        """Places of the sensors that are done without, or wait for their return."""
        return [place for place, good_for in enumerate(self._good_for) if good_for >= 0.0]

    def step(
        self,
        readings: Sequence[float],
        bad: Sequence[int],
        idle: float,
        elapsed_s: float,
        recover_s: float,
        tool_share: float,
        starts: Starts | None = None,
    ) -> list[float] | None:
        """Take in one sample; return the readings to use [degC], None if there is no going on.

        Parameters
        ----------
        readings : sequence of float
            Of the chosen sensors [degC]; those of bad ones are not looked at.
        bad : sequence of int
            Places of those that cannot be used.
        idle : float
            For how long the sensor at `turn` has stood still, over what makes it stale [1].
        elapsed_s : float
            Time since the sample before this one [s].
        recover_s : float
            How long a sensor must be good to be used again [s].
        tool_share : float
            Where the tool is from the shortest (0) to the longest (1).
        starts : Starts, optional
            From where rises may count if not all are good; without it they must be to start.
        """
        if not self._started:
            return self._start(readings, bad, elapsed_s, tool_share, starts)
        self._clock = min(self._clock + elapsed_s, MOST_S)
        before = list(self._good_for)
        self._count(bad, elapsed_s, recover_s)
        broken = self.broken
        if not self._can_go_on(broken, tool_share):
            if bad:
                self._stopped = True
                return None
            # All are good, and the offsets wait for them anyway.
            self._good_for = [-1.0] * len(before)
            broken = []
        self._read_at_last(readings)
        readings = [value + shift for value, shift in zip(readings, self._shift, strict=True)]
        used = self._filled(readings, broken)
        kept = exp(-elapsed_s / BLEND_S)
        self._blend(used, before, kept)
        self._fade_extra(broken, kept, tool_share)
        self._compare(used, idle)
        self._stopped, self._last = False, used
        return used

    def _start(
        self,
        readings: Sequence[float],
        bad: Sequence[int],
        elapsed_s: float,
        tool_share: float,
        starts: Starts | None,
    ) -> list[float] | None:
        """Take in a sample before the first one in use."""
        if not bad:
            self._started = True
            self._clock = 0.0
            self._first = list(readings)
            self._last = list(readings)
            return self._last
        if starts is None or self._clock < START_AFTER_S:
            self._clock = min(self._clock + elapsed_s, MOST_S)
            return None
        good_for = [0.0 if place in bad else -1.0 for place in range(len(readings))]
        waited, self._clock = self._clock, 0.0
        if not self._can_go_on(bad, tool_share):
            self._clock = waited
            return None
        self._started = True
        self._first, self._good_for = list(starts.first), good_for
        for place in starts.unread:
            self._unread[place] = 1.0
        self._last = self._filled(readings, bad)
        return self._last

    def _read_at_last(self, readings: Sequence[float]) -> None:
        """Let a sensor that is good for the first time go on from its estimate."""
        for place, unread in enumerate(self._unread):
            if unread and self._good_for[place] < 0.0:
                self._unread[place] = 0.0
                self._shift[place] = self._last[place] - readings[place]
                self._lasting = [
                    max(*pair) for pair in zip(self._lasting, self._extra, strict=True)
                ]

    def _count(self, bad: Sequence[int], elapsed_s: float, recover_s: float) -> None:
        """Count how long the broken sensors have been good again."""
        for place, good_for in enumerate(self._good_for):
            if place in bad:
                self._good_for[place] = 0.0
            elif good_for >= 0.0:
                good_for += elapsed_s
                self._good_for[place] = -1.0 if good_for >= recover_s else good_for

    def _can_go_on(self, broken: Sequence[int], tool_share: float) -> bool:
        """Return whether some drift stays known to better than its usual size, for long."""
        if not broken:
            return True
        if len(broken) > MOST_BROKEN:
            return False
        for axis, extra in enumerate(self._variances(broken, tool_share, lasting=True)):
            usual = self._usual(axis, tool_share)
            if usual > 0.0 and extra <= usual * usual:
                return True
        return False

    def _filled(self, readings: Sequence[float], broken: Sequence[int]) -> list[float]:
        """Return the readings with what the broken sensors are likely to read [degC]."""
        used = list(readings)
        if not broken:
            return used
        rises = [value - first for value, first in zip(readings, self._first, strict=True)]
        for place in broken:
            rises[place] = 0.0
        pulls = []
        for place in broken:
            row = self._precision[place]
            kept = exp(-(self._clock - self._seen[place]) / self._memory_s)
            pulls.append(row[place] * self._own[place] * kept - sum(map(mul, row, rises)))
        (aa, ab, bb), determinant = self._covariance(broken)
        a = broken[0]
        if len(broken) == 1:
            used[a] = self._first[a] + aa * pulls[0] / determinant
        else:
            b = broken[1]
            used[a] = self._first[a] + (aa * pulls[0] + ab * pulls[1]) / determinant
            used[b] = self._first[b] + (ab * pulls[0] + bb * pulls[1]) / determinant
        return used

    def _covariance(self, broken: Sequence[int]) -> tuple[tuple[float, float, float], float]:
        """Return the inverse of P_bb times its determinant: (aa, ab, bb), and the determinant."""
        a = broken[0]
        if len(broken) == 1:
            return (1.0, 0.0, 0.0), self._precision[a][a]
        b = broken[1]
        p, q, r = self._precision[a][a], self._precision[a][b], self._precision[b][b]
        return (r, -q, p), p * r - q * q

    def _variances(self, broken: Sequence[int], tool_share: float, *, lasting: bool) -> list[float]:
        """Return what the broken sensors add to the variance of the drift, for X, Y, Z [um^2]."""
        (aa, ab, bb), determinant = self._covariance(broken)
        found = []
        for axis in range(3):
            a = self._weight(axis, broken[0], tool_share, lasting=lasting)
            total = aa * a * a
            if len(broken) > 1:
                b = self._weight(axis, broken[1], tool_share, lasting=lasting)
                total += 2.0 * ab * a * b + bb * b * b
            found.append(max(total / determinant, 0.0))
        return found

    def _weight(self, axis: int, place: int, tool_share: float, *, lasting: bool) -> float:
        """Return what a unit of P_bb's deviation of one sensor does to the drift [um/K]."""
        shortest, longest = self._shortest[axis][place], self._longest[axis][place]
        told = 1.0
        if not lasting:
            told = -expm1(-2.0 * (self._clock - self._seen[place]) / self._memory_s)
        weight = shortest + tool_share * (longest - shortest)
        return weight * sqrt(self._growth[place] * told)

    def _usual(self, axis: int, tool_share: float) -> float:
        shortest, longest = self._usual_shortest[axis], self._usual_longest[axis]
        return shortest + tool_share * (longest - shortest)

    def _blend(self, used: list[float], before: Sequence[float], kept: float) -> None:
        """Let no reading step when it comes from elsewhere than in the sample before."""
        changed = any(
            (was >= 0.0) != (now >= 0.0) for was, now in zip(before, self._good_for, strict=True)
        )
        if self._stopped:
            self._gap = [0.0] * len(used)  # the offsets are elsewhere as well
            return
        if any(self._gap):
            self._gap = [gap * kept for gap in self._gap]
        if changed:
            for place, (was, now) in enumerate(zip(before, self._good_for, strict=True)):
                if was >= 0.0 or now >= 0.0:
                    self._gap[place] = self._last[place] - used[place]
        for place, gap in enumerate(self._gap):
            used[place] += gap

    def _fade_extra(self, broken: Sequence[int], kept: float, tool_share: float) -> None:
        if broken:
            now = self._variances(broken, tool_share, lasting=False)
            self._extra = [max(new, old * kept) for new, old in zip(now, self._extra, strict=True)]
        elif any(self._extra):
            self._extra = [old * kept for old in self._extra]
        if any(self._lasting):
            self._extra = [max(*pair) for pair in zip(self._extra, self._lasting, strict=True)]

    def _compare(self, used: Sequence[float], idle: float) -> None:
        """Put down what one sensor reads beyond what the others say; each has its turn."""
        place = self.turn
        self.turn = (place + 1) % len(used)
        if self._good_for[place] >= 0.0 or idle > FRESH:
            return
        row = self._precision[place]
        rises = map(float.__sub__, used, self._first)
        self._own[place] = sum(map(mul, row, rises)) / row[place]
        self._seen[place] = self._clock

    def faded(self, axis: int, tool_share: float, doubt: float) -> float:
        """Return which share of an offset is still backed by what is known, 0 to 1.

        Parameters
        ----------
        axis : int
            0, 1, 2 for X, Y, Z.
        tool_share : float
            Where the tool is from the shortest (0) to the longest (1).
        doubt : float
            Share of the error's variance that is left since a measurement, 0 to 1.
        """
        extra, usual = self._extra[axis] * doubt, self._usual(axis, tool_share)
        return usual * usual / (usual * usual + extra) if extra > 0.0 else 1.0

    def widened(
        self, half_width: tuple[float, float, float], doubt: float
    ) -> tuple[float, float, float]:
        """Return half widths with what the broken sensors add [um]; what is not known stays so."""
        if not any(self._extra):
            return half_width
        scale = self.deviations * self.deviations * doubt
        x, y, z = (
            sqrt(width * width + scale * extra) if width >= 0.0 and extra > 0.0 else width
            for width, extra in zip(half_width, self._extra, strict=True)
        )
        return x, y, z

    def state(self) -> list[float]:
        """Return what is remembered."""
        return [
            float(self._started),
            float(self._stopped),
            self._clock,
            float(self.turn),
            *(value for values in self._rows() for value in values),
        ]

    def restore(self, state: Sequence[float]) -> None:
        """Take up the state that `state` returned.

        Raises
        ------
        ValueError
            If the state is not one of this file's.
        """
        values = iter(checked_state(state, len(self.state())))
        self._started, self._stopped = bool(next(values)), bool(next(values))
        self._clock, self.turn = next(values), int(next(values))
        if not 0 <= self.turn < len(self._first):
            raise ValueError(f"the state counts {self.turn} of {len(self._first)} sensors")
        for held in self._rows():
            held[:] = [next(values) for _ in held]

    def _rows(self) -> tuple[list[float], ...]:
        return (
            self._first,
            self._last,
            self._own,
            self._seen,
            self._gap,
            self._good_for,
            self._unread,
            self._shift,
            self._extra,
            self._lasting,
        )


def _not_negative(fields: Fields, key: str, length: int, limit: float) -> list[float]:
    values = fields.numbers(key, length, limit)
    for index, value in enumerate(values):
        if value < 0.0:
            raise fields.refusal(f"{key}.{index}", f"{value:g} is not allowed: at least 0")
    return values


def _check_precision(fields: Fields, precision: list[list[float]]) -> None:
    """Refuse a matrix by which one or two sensors have no variance."""
    for i, row in enumerate(precision):
        if not row[i] > 0.0:
            problem = f"{row[i]:g} is not allowed: must be above 0"
            raise fields.refusal(f"precision.{i}.{i}", problem)
        for j, other in enumerate(precision[:i]):
            problem = f"{row[j]:g} is not allowed: "
            if row[j] != other[i]:
                problem += f"must be that of precision.{j}.{i} ({other[i]:g})"
                raise fields.refusal(f"precision.{i}.{j}", problem)
            if not row[j] * row[j] < row[i] * other[j]:
                problem += f"below {sqrt(row[i] * other[j]):g} in size"
                raise fields.refusal(f"precision.{i}.{j}", problem)
