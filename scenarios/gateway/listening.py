"""How a database's frames are listened to: cycle by cycle, or each at its own pace."""

from __future__ import annotations

from scenarios.gateway.database import COMPENSATOR, MACHINE, Database
from scenarios.gateway.judging import Judge
from scenarios.gateway.sampling import Sampling, StateJudge
from scenarios.gateway.supervision import Reception


class Answered:
    """Which time of the machine is answered, as the wire carries it.

    Parameters
    ----------
    database : Database
        The frames; a machine that sends no time of its own is answered without one.
    """

    def __init__(self, database: Database) -> None:
        signals = database.closing(COMPENSATOR).signals
        timed = "answered_time" in signals and database.has("machine_time")
        self._count = 1 << signals["answered_time"].bits if timed else 1
        self._scale = database.signal("machine_time").scale if timed else 0.0

    def value(self, raw: int) -> float:
        """Return what names a raw machine time [s]."""
        return raw % self._count * self._scale


def ears(
    database: Database, speed_up: float | None, timeout_s: float | None
) -> tuple[Reception, Judge] | tuple[Sampling, StateJudge]:
    """Return what judges the machine's frames, and what judges its cycles.

    Parameters
    ----------
    database : Database
        The frames.
    speed_up : float or None
        See `Judge`.
    timeout_s : float or None
        Silence after which a frame is late; None: what the DBC or the map says [s].
    """
    frames, closing = database.of(MACHINE), database.closing(MACHINE)
    if database.every_s is not None:
        sampling = Sampling(frames, database.substitutes, timeout_s)
        states = next((s for _, s in database.signals(MACHINE) if s.name == "machine_state"), None)
        return sampling, StateJudge(closing, states)
    judge = Judge(closing, speed_up, timeout_s or closing.timeout_s)
    return Reception(frames, timeout_s), judge
