"""The gateway: the compensator FMU as a node of the bus.

A cycle of the machine comes in, the FMU takes one step, the answer goes out. When the machine is
silent, the gateway keeps its own time.

The gateway decides whether an input can be trusted, and passes *missing* (NaN) to the FMU if not.
Holding, ramping to zero and moving back are left to the compensator. The gateway adds two rules:
offsets are marked valid only in the answer to a usable cycle that has just arrived, and only while
no other gateway is on the bus; and the FMU gets no reading before the reference of the drift is
proven.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import inf, nan

import can

from fmu_compensator.runtime.fmi_slave import HALF_WIDTHS
from gateway.clocks import Stepper
from gateway.codec import CountedTime, Finding, Sender, Value
from gateway.database import COMPENSATOR, FAREWELLS, MACHINE, OFFSETS, TRUST, Database, key_of
from gateway.judging import Judge, Rival
from gateway.mapped_signals import named
from gateway.probes import COUNTED, LATEST_STEPS, ProbeReceiver
from gateway.proof import CHALLENGE, FRESHNESS, NOT_PROVEN, PROVEN, Challenges
from gateway.reception import Cycle, Reception, Substitution
from gateway.reference import Proof, Reference
from gateway.state import Saved
from gateway.timebase import WORD_HOLDS_S
from gateway.unit import CompensatorUnit
from measurement.rig import AXES

LOSSES = ("bus_off", "interface_lost")
AFTER_LOSS = ("startup", "missing", "late", "machine_not_running")
UNKNOWN = "reference_unknown"
STARTING, READY, RUNNING, FAULT = "starting", "ready", "running", "fault"


@dataclass(frozen=True)
class GatewaySettings:
    """How the gateway runs.

    Attributes
    ----------
    machine_clock : bool
        Whether to step by the machine's count of time, as in a simulation that runs faster than
        real time, or by this computer's clock.
    speed_up : float
        Seconds of the compensator per second of this computer's clock.
    startup_s : float
        Time for the interface to appear and the machine's first complete cycle to arrive [s].
    timeout_s : float or None
        Silence of the machine after which the inputs are missing, and how old a cycle may be;
        None: from the DBC file [s].
    proof : Proof
        The accepted proofs that the machine is cold.
    key : bytes or None
        The key of the machine's proofs of freshness.
    """

    machine_clock: bool = False
    speed_up: float = 1.0
    startup_s: float = 10.0
    timeout_s: float | None = None
    proof: Proof = field(default_factory=Proof)
    key: bytes | None = field(default=None, repr=False)


class GatewayNode:
    """The gateway without its bus: messages and times in, messages out.

    Parameters
    ----------
    database : Database
        The frames.
    unit : CompensatorUnit
        The compensator, started.
    send : callable
        Takes the messages of an answer.
    settings : GatewaySettings
        How it runs.
    now : float
        The time of this computer's monotonic clock [s], which all later times are read from.
    warm : Saved or None
        The state that the compensator was restored from: it goes on at once, and the time in
        between counts as time without inputs.
    say : callable
        Takes a line for people when something changes.
    clock : callable or None
        This computer's monotonic clock, read again before offsets are marked valid; None: not read.
    wall : callable or None
        The time of day, which goes on when the other clock stops; None: not used.

    Attributes
    ----------
    state : str
        As the DBC names the values of ``gateway_state``.
    machine_off : bool
        Whether the machine has announced that it is off.
    answer : dict
        The values of the newest answer.
    given : dict of str to float
        The received inputs of that answer; NaN or absent if not usable.
    stepper : Stepper
        Steps the compensator.
    """

    def __init__(
        self,
        database: Database,
        unit: CompensatorUnit,
        send: Callable[[Iterable[can.Message]], object],
        settings: GatewaySettings,
        now: float,
        warm: Saved | None = None,
        say: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] | None = None,
        wall: Callable[[], float] | None = None,
    ) -> None:
        self._unit, self._send, self._settings, self._say = unit, send, settings, say
        self._clock = clock
        self._sender = Sender(database, COMPENSATOR)
        self._closing = closing = database.closing(MACHINE)
        self._every_s = database.every_s
        speed_up = None if settings.machine_clock else settings.speed_up
        self._cycle_s = database.every_s or closing.cycle_s
        self._timeout_s = settings.timeout_s or (
            LATEST_STEPS * self._every_s if self._every_s else closing.timeout_s
        )
        self.reception = Reception(
            database.of(MACHINE),
            together=self._every_s is None,
            optional=database.substitutes,
            timeout_s=settings.timeout_s,
        )
        # A control answers a challenge with its next cycle, which may be late like any other.
        self._challenges = Challenges(self._timeout_s + self._cycle_s, settings.key)
        self._judge = Judge(database, speed_up, self._timeout_s, self._challenges)
        self._proves = database.proof is not None
        self._substitution = Substitution(database.substitutes)
        self._trust = TRUST.index(database.trust)
        self._when_invalid: dict[str, Value] = dict(database.when_invalid)
        answered = database.closing(COMPENSATOR).signals.get("answered_time")
        timed = answered is not None and self._judge.time is not None
        self._answered = CountedTime(answered) if answered is not None and timed else None
        self.probes = ProbeReceiver(database.events(MACHINE), say)
        self._rival = Rival(database.of(COMPENSATOR))
        thermometers = [s.name for _, s in database.signals(MACHINE) if s.unit == "degC"]
        self.reference = Reference(
            settings.proof, [name for name in unit.inputs if name in thermometers]
        )
        states = database.has("thermal_state") and database.signal("thermal_state").codes
        self._cold = states["cold"] if states else None
        self._usable_at = now
        self._restored = warm  # until it has been compared with the machine's time
        self._lost_track = False
        sent = (signal for _, signal in database.signals(COMPENSATOR))
        self._own_offsets = [signal for signal in sent if signal.name in OFFSETS]
        self.begun = warm is not None
        self.state = STARTING
        self.machine_off = False
        self._started_at = self._deadline = now
        rate = settings.speed_up, settings.machine_clock
        self.stepper = Stepper(unit, *rate, self._cycle_s, self._timeout_s, now, warm, wall)
        self._finding: Finding | None = None
        self._followed = dict(unit.outputs)  # when offsets last followed the model
        self._late_start = False
        self._said: dict[tuple[str, ...], float] = {}
        self._without: set[tuple[str, ...]] = set()
        self.answer: Mapping[str, Value] = {}
        self.given: Mapping[str, float] = {}

    # Events

    def deadline(self) -> float:
        """Return when `tick` must be called, unless a cycle comes first [s]."""
        return self._deadline

    def handle(self, message: can.Message, now: float, waited_s: float = 0.0) -> bool:
        """Take in a message; return whether it closed a cycle, which has then been answered.

        Parameters
        ----------
        message : can.Message
            The message.
        now : float
            The time [s].
        waited_s : float
            How long ago it arrived at this computer [s].
        """
        arrived = now - waited_s
        if self._rival.hear(message, arrived) or self.probes.hear(message):
            return False
        cycle = self.reception.take(key_of(message), message.data, arrived)
        if cycle is None:
            return False
        self._on_cycle(cycle, arrived, now)
        self._deadline = now + self._timeout_s
        return True

    @property
    def grace_s(self) -> float:
        """How long unread frames may delay what is due, because one may close a cycle [s]."""
        return self._cycle_s if self._every_s is None else 0.0

    def tick(self, now: float, lost: str = "") -> None:
        """Do what is due at *now* if no cycle has come.

        Parameters
        ----------
        now : float
            The time [s].
        lost : str
            Why there is no bus, as the DBC names it; empty if there is one.
        """
        if self._every_s is not None and not lost:
            self._look(self._every_s, now)
            return
        cycle = self.reception.look(now, silent=True)
        finding = cycle.finding
        if lost:
            text = lost.replace("_", " ")
            finding = Finding(lost, self._closing, text)
        self._judge.forget()
        self.given = {}
        unseen_s = self._unseen_s(now)
        if self.begun:
            self.stepper.silence(unseen_s, now)
        elif not lost and now - self._started_at > self._settings.startup_s:
            text = f"no complete cycle of the machine within {self._settings.startup_s:g} s"
            finding = Finding("startup_timeout", self._closing, text)
            self._late_start = True
        self._answer(finding, now, now, usable=False, lost=lost)
        self._deadline = now + self._cycle_s

    def _unseen_s(self, now: float, *, believed: bool = True) -> float:
        """Return, and report, the machine's time that has passed by the time of day only [s]."""
        unseen_s = self.stepper.unseen_s(now)
        if not believed:
            return 0.0
        if unseen_s and self.begun:
            text = f"the time of day went on by {unseen_s:.0f} s that no other clock has seen"
            self._say(f"time jump: {text}; they count as time without inputs")
        return unseen_s

    def _look(self, every_s: float, now: float) -> None:
        """Use the newest content of frames that come at their own pace."""
        cycle = self.reception.look(now)
        if not (self.begun or cycle.usable) and now - self._started_at > self._settings.startup_s:
            self._late_start = True
        self._on_cycle(cycle, now, now)
        self._deadline += every_s
        if self._deadline <= now:
            self._deadline = now + every_s

    @property
    def steps(self) -> int:
        """Number of steps that the compensator has taken."""
        return self.stepper.steps

    @property
    def status(self) -> int:
        """The status that the newest answer carries."""
        shown = self.answer.get("status", self._unit.outputs.get("status", 0))
        return named("status")[shown] if isinstance(shown, str) else int(shown)

    @property
    def status_text(self) -> str:
        """The status in words."""
        if self.answer.get("status") == UNKNOWN:
            return "nothing has proven that the machine is cold"
        return self._unit.text()

    @property
    def reference_known(self) -> bool:
        """Whether the reference of the drift is known."""
        return self.begun and not self._lost_track

    def reconnected(self) -> None:
        """Forget the machine's counters, because frames were lost with the bus."""
        self.reception.reset()
        self._judge.forget()

    def farewell(self, state: str = "stopping") -> None:
        """Announce that this node leaves the bus: offsets are invalid and no longer available."""
        values: dict[str, Value] = {"valid": "invalid", "gateway_state": state}
        for _ in range(FAREWELLS):
            self._send(self._sender.messages(values))

    # One cycle

    def _on_cycle(self, cycle: Cycle, arrived: float, now: float) -> None:
        usable, finding = self._judge.judge(cycle, arrived, now)
        proven = self._judge.proven
        # If the machine's clock and this one agree, a jump of the time of day was a manual setting.
        own_s = self._unseen_s(now, believed=not (usable and self._judge.in_time))
        unseen_s = max(self._judge.unseen_s * self._settings.speed_up, own_s)
        if proven or not self._proves:
            self.stepper.hear(cycle.heartbeat, now, sampled=self._every_s is not None)
            self.machine_off = self._judge.machine_state == "off"
        if proven:
            self.reception.renew()
        if usable and self._restored is not None:
            shown_s = cycle.heartbeat.get("machine_time", nan)
            why = self.stepper.too_old(self._restored, shown_s, self._judge.time, now)
            self._lost_track, self._restored = bool(why), None
            if why:
                self._say(why)
        self.given = self._substitution.fill(cycle.values, now) if usable else {}
        if cycle.usable:
            self._tell_signals(cycle.wrong, now)
        idle = finding is not None and finding.fault == "machine_not_running"
        if not self.begun and (usable or idle):
            self._look_for_reference(cycle, now)
        if self.begun or (usable and self.reference.known):
            self.begun = True
            probe = {}
            if usable:
                step_s = cycle.values.get("machine_step", nan)
                probe = self.probes.due(self._judge.time_s, step_s, self._unit.probed)
            self.stepper.advance({**self.given, **probe}, cycle.heartbeat, now, unseen_s)
        elif cycle.usable and not usable:
            # In contact, but the machine has not started: nothing to compensate yet.
            self.state, self._late_start = READY, False
        self._answer(finding, arrived, now, usable=usable, ready=cycle.usable)

    def _look_for_reference(self, cycle: Cycle, now: float) -> None:
        elapsed_s = (now - self._usable_at) * self._settings.speed_up
        if self._settings.machine_clock:
            elapsed_s = cycle.values["machine_step"]
        self._usable_at = now
        before = self.reference.known
        cold = cycle.values.get("thermal_state", nan) == self._cold
        if self.reference.take(cycle.values, elapsed_s, cold=cold) != before:
            known = self.reference.known or "nothing proves any more that the machine is cold"
            self._say(f"reference: {known}")

    def renew_reference(self) -> None:
        """Count the drift from the next readings, because a user has declared the machine cold."""
        self.stepper.renew()
        self.reference.say_cold()
        self.begun, self._lost_track, self._restored = False, False, None

    # The answer

    def _answer(
        self,
        finding: Finding | None,
        arrived: float,
        now: float,
        *,
        usable: bool,
        lost: str = "",
        ready: bool = False,
    ) -> None:
        outputs = self._unit.outputs
        rival = self._rival.finding(arrived)
        if rival is not None and not lost:
            finding, usable = rival, False
        known = self.reference_known
        valid = usable and known and bool(outputs.get("valid", False)) and self._fits(outputs)
        if valid and self._clock is not None and self._clock() - arrived > self._timeout_s:
            text = f"the answer took {self._clock() - arrived:.3f} s"
            finding, valid = Finding("stale", self._closing, text), False
        self._note(finding, now, done=valid or (usable and not known))
        if lost:
            self.state = "reconnecting"
        elif self.begun or usable:
            self.state = RUNNING if usable else FAULT
        elif not ready:
            self.state = "startup_timeout" if self._late_start else STARTING
        kept, counted = self._finding, self._answered
        answered_s = counted.carried_s(self._judge.time_s) if counted else 0.0
        issued = self._clock() if self._clock is not None else now
        values: dict[str, Value] = {
            **outputs,
            "valid": "valid" if valid else "invalid",
            "gateway_state": self.state,
            "bus_fault": kept.fault if kept else "none",
            "bus_fault_frame": kept.frame.frame_id & 0xFF if kept else 0.0,
            "answered_time": answered_s,
            CHALLENGE: float(self._challenges.issue(issued)),
            FRESHNESS: PROVEN if self._judge.proven and usable else NOT_PROVEN,
            "trust": float(self._trust),
            "probes_taken": float(self.probes.taken % COUNTED),
            **half_widths(outputs, known=known),
        }
        if not valid:
            values |= self._when_invalid
        if usable and not known:
            values["status"] = UNKNOWN
        if outputs.get("valid", False):
            self._followed = dict(outputs)
        length_mm = self.stepper.tool_length_mm
        self.answer = by_tool_length(outputs, self._followed, length_mm, self._unit.share) | values
        self._send(self._sender.messages(self.answer))

    def _fits(self, outputs: Mapping[str, float]) -> bool:
        """Whether the frames can carry the offsets."""
        return all(s.low <= outputs.get(s.name, nan) <= s.high for s in self._own_offsets)

    def _note(self, finding: Finding | None, now: float, *, done: bool) -> None:
        """Keep the last finding until the offsets are valid again or only lack a reference."""
        if finding is not None and self._finding is not None and self._finding.fault in LOSSES:
            # The loss could not be reported while it lasted; its consequences can wait.
            finding = self._finding if finding.fault in AFTER_LOSS else finding
        # Signals are reported separately, and a loss by the link.
        if finding is not None and not finding.signal and finding.fault not in LOSSES:
            kind = finding.fault, finding.frame.name
            before = self._finding and (self._finding.fault, self._finding.frame.name)
            if kind != before:
                self._mention({kind: finding.text}, now)
        if finding is not None or done:
            self._finding = finding

    def _tell_signals(self, wrong: Iterable[Finding], now: float) -> None:
        """Report the signals that have just lost their value, one line per kind of fault."""
        texts: dict[tuple[str, ...], str] = {
            (finding.fault, finding.signal): finding.text for finding in wrong if finding.signal
        }
        for fault in dict.fromkeys(key[0] for key in texts):
            new = {k: texts[k] for k in texts if k[0] == fault and k not in self._without}
            self._mention(new, now)
        self._without = set(texts)

    def _mention(self, texts: Mapping[tuple[str, ...], str], now: float) -> None:
        """Report new problems, each not too often; the first part of a key is the kind of fault."""
        due = {
            key: text
            for key, text in texts.items()
            if now - self._said.get(key, -inf) >= WORD_HOLDS_S
        }
        if due:
            fault = next(iter(due))[0].replace("_", " ")
            self._say(f"{fault}: {', '.join(due.values())}")
            self._said |= dict.fromkeys(due, now)


def by_tool_length(
    outputs: Mapping[str, float],
    followed: Mapping[str, float],
    tool_length_mm: float,
    share: float,
) -> dict[str, Value]:
    """Return per axis the offset [um], its change per tool length [um/m] and the tool length [mm].

    An axis' offset changes with the tool length by the tilt, with the opposite sign, times the
    share that is sent; 1 urad is 1 um/m. While the offset is ramped to zero or back, so is its
    slope. Z does not depend on the tool length, to first order.

    Parameters
    ----------
    outputs : mapping of str to float
        The compensator's outputs [um, urad].
    followed : mapping of str to float
        Its outputs when they last followed the model [um].
    tool_length_mm : float
        The tool length for which they hold [mm].
    share : float
        The share of the predicted drift that is sent [1].
    """
    tilts = {"X": outputs.get("yaw", nan), "Y": outputs.get("pitch", nan), "Z": 0.0}
    values: dict[str, Value] = {}
    for axis in AXES:
        offset, whole = outputs.get(f"d{axis}", nan), followed.get(f"d{axis}", nan)
        left = min(max(offset / whole, 0.0), 1.0) if whole else 0.0
        in_force = share if outputs.get("valid", False) else share * left
        values[f"d{axis}_at_tool_length"] = offset
        values[f"d{axis}_per_tool_length"] = 0.0 - in_force * tilts[axis]
        values[f"d{axis}_tool_length"] = tool_length_mm
    return values


def half_widths(outputs: Mapping[str, float], *, known: bool) -> dict[str, float]:
    """Return the uncertainty of each axis [um]; NaN if it is unbounded.

    Parameters
    ----------
    outputs : mapping of str to float
        The compensator's outputs; -1 means unknown [um].
    known : bool
        Whether the reference of the drift is known.
    """
    widths = {name: outputs.get(name, nan) if known else nan for name in HALF_WIDTHS}
    return {name: width if width >= 0.0 else nan for name, width in widths.items()}
