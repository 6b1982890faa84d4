"""How a database's frames are listened to: cycle by cycle, or each at its own pace."""

from __future__ import annotations

from gateway.database import MACHINE, Database
from gateway.judging import Judge
from gateway.sampling import Sampling, StateJudge
from gateway.supervision import Reception


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
