"""A machine, a gateway with a compensator made of glass, a bus between them, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import isfinite

import can
import numpy as np

from gateway.codec import Sender, Value, decode
from gateway.database import COMPENSATOR, MACHINE, Database
from gateway.node import GatewayNode, GatewaySettings
from gateway.state import Saved

CYCLE_S = 0.1
OLDEST_S = 0.5
"""An answer to readings of longer ago that is called valid is unsafe: twice *late after* [s]."""
WRONG_TIME_S = 1.0
"""So far may the compensator's time be from the machine's [s]."""
Messages = list[can.Message]
Change = Callable[[Messages], Messages]


class Glass:
    """A compensator that believes everything, and shows what it was given."""

    def __init__(self, database: Database) -> None:
        names = [signal.name for _, signal in database.signals(MACHINE)]
        self.inputs = [name for name in names if name[0] == "T" or name in ("speed", "tool_length")]
        self.probed: list[str] = []
        self.outputs: dict[str, float] = {f"d{axis}": 0.0 for axis in "XYZ"} | {"valid": 0.0}
        self.given: Mapping[str, float] = {}
        self.time_s, self.share = 0.0, 1.0

    def step(self, values: Mapping[str, float], step_s: float) -> dict[str, float]:
        """Take in a sample; valid if nothing is missing."""
        self.given, self.time_s = values, self.time_s + step_s
        whole = all(isfinite(values.get(name, np.nan)) for name in self.inputs)
        self.outputs = {**self.outputs, "valid": float(whole), "status": 0.0}
        return self.outputs

    def text(self) -> str:
        """Return nothing: there is no more to say."""
        return ""


@dataclass
class Outcome:
    """What an episode came to.

    Attributes
    ----------
    noticed : bool
        At least one answer was not valid after the fault began.
    answers, unsafe : int
        Answers after the fault began, and those of them that were called valid and were not.
    valid : int
        Answers that were called valid.
    back_s : float
        How long after the fault's end the offsets were valid for good [s]; inf where they were not
        at the end.
    """

    noticed: bool = False
    answers: int = 0
    unsafe: int = 0
    valid: int = 0
    back_s: float = np.inf

    @property
    def again(self) -> bool:
        """Whether the offsets were valid at the end."""
        return self.back_s < np.inf


class Episode:
    """A machine that runs, a gateway that answers, and the truth about both.

    Parameters
    ----------
    database : Database
        The frames between them.
    rng : Generator
        Makes readings and faults.
    settings : GatewaySettings, optional
        How the gateway runs.
    warm : Saved, optional
        The state that the gateway takes up.
    cold : bool, optional
        Whether the machine says that it is cold.
    """

    def __init__(
        self,
        database: Database,
        rng: np.random.Generator,
        settings: GatewaySettings | None = None,
        warm: Saved | None = None,
        *,
        cold: bool = True,
    ) -> None:
        self.database, self.rng = database, rng
        self.settings, self.cold = settings or GatewaySettings(), cold
        self.reference_known = cold or warm is not None
        self.now = 1000.0
        self.wall_ahead_s = 1e9
        self.sender = Sender(self.database, MACHINE)
        self.challenge: int | None = None
        self.background: Change = lambda messages: messages
        self.time_s = self.read_s = float(rng.integers(0, 4_000_000))
        self.truth: dict[int, tuple[float, dict[str, float]]] = {}
        self.outcome = Outcome()
        self.begun_at = (0.0, 0.0)
        self.rate = 1.0
        self.rate_matters = False
        self.real_s: float | None
        self.rivals_at = -1e9
        self._valid = False
        self._valid_since = np.inf
        self.start_gateway(warm)

    def start_gateway(self, warm: Saved | None = None) -> None:
        """Start the gateway, or start it anew."""
        self.glass, self.real_s = Glass(self.database), None
        self.node = GatewayNode(
            *(self.database, self.glass, self._answer, self.settings, self.now, warm),
            clock=lambda: self.now,
            wall=lambda: self.now + self.wall_ahead_s,
        )

    # The machine

    def start_machine(self, time_s: float = 0.0) -> None:
        """Start the machine anew, its clock at a time [s]."""
        self.sender, self.time_s = Sender(self.database, MACHINE), time_s
        self.challenge = None
        for _ in range(int(self.rng.integers(1, 5))):
            self.wait(CYCLE_S)
            self.give(self.background(self.messages("starting")))

    def messages(self, state: str = "running", **more: Value) -> Messages:
        """Return the next cycle of the machine, as it leaves it."""
        rng = self.rng
        readings = {f"T{n}": round(20.0 + 30.0 * rng.random(), 2) for n in range(1, 12)}
        readings |= {"speed": float(rng.integers(0, 20_000))}
        readings |= {"tool_length": round(50.0 + 300.0 * rng.random(), 3)}
        step_s = round(CYCLE_S * self.rate, 2) if state == "running" else 0.0
        values: dict[str, Value] = {**readings, "machine_state": state, "machine_step": step_s}
        values |= {"machine_time": self.time_s, "offset_use": "following"}
        values |= {"thermal_state": "cold" if self.cold else "warm"}
        values |= more
        if isfinite(float(values["machine_time"])):
            raw = round(float(values["machine_time"]) * 1e3) % 65536
            self.truth[raw] = (self.now, readings)
        self.read_s = self.time_s
        self.time_s = round(self.time_s + (step_s or CYCLE_S * self.rate), 3)
        return self.sender.messages(values, self.challenge)

    def cycle(self, change: Change = lambda messages: messages, **more: Value) -> None:
        """Run one cycle of the machine, changed on its way."""
        self.wait(CYCLE_S)
        self.give(self.background(change(self.messages(**more))))

    def give(self, messages: Messages, waited_s: float = 0.0) -> None:
        """Hand messages to the gateway."""
        for message in messages:
            self.node.handle(message, self.now, waited_s)

    def wait(self, seconds: float) -> None:
        """Let time go by; the gateway does what is due."""
        until = self.now + seconds
        while self.node.deadline() <= until:
            self.now = max(self.now, self.node.deadline())
            self.node.tick(self.now)
        self.now = until

    def settle(self) -> None:
        """Start, run for some cycles, and let the fault begin."""
        for _ in range(3):
            self.wait(CYCLE_S)
            self.give(self.messages("starting"))
        for _ in range(int(self.rng.integers(3, 20))):
            self.cycle()
        self.begin()

    def pass_unseen(self, gone_s: float) -> None:
        """Let time go by that this computer's clock does not see, from now on told of or not."""
        if self.node.begun:  # before, the compensator has no time that could be wrong
            self.real_s = self.glass.time_s - self.now + gone_s

    def begin(self) -> None:
        """From now on, judge the answers."""
        self.outcome = Outcome()
        self.begun_at = (self.glass.time_s, self.read_s)

    def finish(self, cycles: int = 20) -> Outcome:
        """Run on without a fault and return what came of it."""
        ended = self.now
        for _ in range(cycles):
            self.cycle()
        if self._valid:
            self.outcome.back_s = max(self._valid_since - ended, 0.0)
        return self.outcome

    # The gateway's answers

    def _answer(self, messages: Iterable[can.Message]) -> None:
        frames = {frame.frame_id: frame for frame in self.database.of(COMPENSATOR)}
        values: dict[str, float] = {}
        for message in messages:
            frame = frames.get(message.arbitration_id)
            if frame is not None and len(message.data) == frame.message.length:
                values |= decode(frame, message.data).values
        if "valid" not in values:
            return
        self.challenge = int(values["challenge"])
        valid = values["valid"] == 1.0
        if valid and not self._valid:
            self._valid_since = self.now
        self._valid = valid
        self.outcome.answers += 1
        self.outcome.valid += valid
        self.outcome.noticed |= not self._valid
        self.outcome.unsafe += self._valid and not self._is_right(values)

    def _is_right(self, values: Mapping[str, float]) -> bool:
        """Whether a valid answer may be called so, by what only the bench knows."""
        known = self.truth.get(round(values["answered_time"] * 1e3))
        if known is None or not self.reference_known:
            return False
        read_at, readings = known
        same = all(abs(self.glass.given[name] - read) < 0.006 for name, read in readings.items())
        alone = self.now - self.rivals_at > 0.5
        return same and alone and self.now - read_at <= OLDEST_S and self._keeps_time()

    def _keeps_time(self) -> bool:
        if self.real_s is not None:
            # Time that was told and did not go by makes a compensator careful, not wrong.
            return self.glass.time_s >= self.now + self.real_s - WRONG_TIME_S
        if not self.rate_matters:
            return True
        own, machine = self.begun_at
        gone = (self.glass.time_s - own) - (self.read_s - machine)
        return abs(gone) <= WRONG_TIME_S
