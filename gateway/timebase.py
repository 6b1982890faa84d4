"""Whether the machine's time agrees with this computer's clock.

If all frames of a cycle are delayed equally, their counts are right but the values are old. And if
the gateway counts one second while the machine counts fifty, it follows the wrong warm-up. Both
show when the machine's time is compared with the arrival of its frames: the offset between the two
clocks must stay constant, except for the drift of good clocks.

If the machine's time falls behind, either its frames are delayed or its clock was set; only a proof
of freshness tells these apart. Without one, the reference offset stays: late cycles are not used
until the offset is right again, whatever the machine reports in between."""

from __future__ import annotations

CLOCK_DRIFT = 5e-4
"""Largest drift between two clocks, as a share of the elapsed time [1]: given by Linux, which sets
a clock right by running it at most 500 ppm faster or slower (``MAXFREQ`` of ``timex.h``). A delay
that grows more slowly cannot be told from drift."""
WORD_HOLDS_S = 60.0
"""How long a machine's word holds [s]: nothing is trusted after its time ran at another rate, it
counts as cold after it said so, temperatures count as unchanged between two readings, a probe is
repeated, and the same line about it is not. Set on no data."""
RATE = "time_rate", "machine_time runs at another rate than this computer's clock times --speed-up"


class Timebase:
    """Compares the machine's time with the time of arrival.

    Parameters
    ----------
    period : int
        Number of counts after which the machine's raw time starts again.
    scale_s : float
        Seconds of the machine per count.
    speed_up : float
        Seconds of the machine per second of this computer's clock.
    tolerance_s : float
        How late or early a cycle may arrive, by this computer's clock [s].

    Attributes
    ----------
    behind : bool
        Whether the newest cycle was behind, and no proof has come since.
    in_time : bool
        Whether the machine's clock and this one agree in the newest cycle.
    unseen_s : float
        How far the last call of `judge` found the machine's time ahead of this clock, at this
        clock's rate [s].
    """

    def __init__(self, period: int, scale_s: float, speed_up: float, tolerance_s: float) -> None:
        self._period, self._count_s = period, scale_s / speed_up
        self._tolerance_s = tolerance_s
        self._distrusted_until = float("-inf")
        self._last: int | None = None
        self._position_s = self._arrived = self._low_s = self._first_s = 0.0
        self._restarted = self.behind = False
        self.tell_nothing()

    def tell_nothing(self) -> None:
        """Note that the newest cycle has not been judged."""
        self.in_time, self.unseen_s = False, 0.0

    def restart(self, *, proven: bool = False) -> None:
        """Note that the machine reports that it starts, so its time may be different.

        Parameters
        ----------
        proven : bool, optional
            Whether that report is proven to be fresh; a delayed one stays late.
        """
        self._restarted = not self.behind
        if proven:
            self._last = None

    def judge(
        self, raw: int, arrived: float, *, jumped: bool = False, proven: bool = False
    ) -> tuple[str, str] | None:
        """Return the fault and a text, or None if the times agree.

        Parameters
        ----------
        raw : int
            The machine's raw time.
        arrived : float
            When its frame arrived [s].
        jumped : bool
            Whether the time differs from the one that the previous cycle announced.
        proven : bool
            Whether the frame is proven to be fresh.
        """
        self.tell_nothing()
        if self._last is None:
            self._begin(raw, arrived)
            return self._distrust(arrived)
        ahead = (raw - self._last) % self._period
        back = ahead > self._period // 2
        if not ahead:
            fault = "time_jump" if jumped else "time_stands"
            return fault, "machine_time stands while the machine runs"
        position_s = self._position_s + (ahead - self._period * back) * self._count_s
        offset_s, drift_s = arrived - position_s, CLOCK_DRIFT * max(arrived - self._arrived, 0.0)
        behind_s, restarted = offset_s - self._low_s, self._restarted
        self._last, self._position_s, self._arrived = raw, position_s, arrived
        self._restarted = False
        if restarted and (back or behind_s < -self._tolerance_s):
            self._begin(raw, arrived)
            return self._distrust(arrived)
        if behind_s > self._tolerance_s + drift_s:
            if proven:
                self._begin(raw, arrived)
                return self._set(back or jumped, -behind_s, arrived)
            self.behind = True
            text = f"machine_time is {behind_s:.3f} s behind this computer's clock"
            return "time_jump" if back else "delayed", text
        self.behind = False
        self._low_s = min(self._low_s + drift_s, offset_s)
        self._first_s = max(self._first_s - drift_s, self._low_s)
        before_s = self._first_s - offset_s
        if before_s > self._tolerance_s:
            self._begin(raw, arrived)
            self.unseen_s = before_s
            return self._set(jumped, before_s, arrived)
        self.in_time = True
        return self._distrust(arrived)

    def _set(self, jumped: bool, ahead_s: float, arrived: float) -> tuple[str, str] | None:
        """Judge a time that has moved against this clock [s]: a jump, or a different rate."""
        if jumped:
            return "time_jump", f"machine_time jumped by {ahead_s:.3f} s"
        self._distrusted_until = arrived + WORD_HOLDS_S
        return self._distrust(arrived)

    def _begin(self, raw: int, arrived: float) -> None:
        self._last, self._position_s, self._arrived = raw, 0.0, arrived
        self._low_s = self._first_s = arrived
        self.behind = False

    def _distrust(self, arrived: float) -> tuple[str, str] | None:
        return RATE if arrived < self._distrusted_until else None
