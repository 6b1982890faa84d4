"""Runs the gateway: its node, bus, FMU and state file."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

from gateway.background import Background
from gateway.clocks import steady
from gateway.codec import Value
from gateway.database import MACHINE, Database
from gateway.link import Link
from gateway.node import RUNNING, GatewayNode, GatewaySettings, half_widths
from gateway.protocols.base import Participant, Report, Send
from gateway.state import StateFile
from gateway.systemd import ServiceManager
from gateway.timebase import WORD_HOLDS_S
from gateway.unit import CompensatorUnit
from measurement.errors import BadInput
from measurement.stops import LOOK_S


@dataclass
class Service:
    """Runs a gateway until it is stopped.

    Parameters
    ----------
    database : Database
        The frames.
    fmu : Path
        The compensator.
    unit : CompensatorUnit
        The compensator, loaded.
    link : Link
        The bus, open.
    settings : GatewaySettings
        How the gateway runs.
    state_file : Path or None
        The file that keeps the compensator's state.
    save_every_s : float
        Period of saving the state [s].
    until_off : bool
        End when the machine announces that it is off.
    duration_s : float or None
        End after this time (default: when interrupted) [s].
    stopped : callable
        Returns whether to end.
    say : callable
        Takes a line for people.
    renewed : callable
        Returns, once, that a user has declared the machine cold.
    manager : ServiceManager
        Receives the gateway's signs of life.
    participants : list of Participant
        The protocols that take part.
    """

    database: Database
    fmu: Path
    unit: CompensatorUnit
    link: Link
    settings: GatewaySettings
    state_file: Path | None = None
    save_every_s: float = 10.0
    until_off: bool = False
    duration_s: float | None = None
    stopped: Callable[[], bool] = lambda: False
    say: Callable[[str], None] = lambda line: None
    clock: Callable[[], float] = steady
    wall: Callable[[], float] = time.time
    renewed: Callable[[], bool] = lambda: False
    manager: ServiceManager = field(default_factory=ServiceManager)
    participants: list[Participant] = field(default_factory=list)
    node: GatewayNode | None = None
    _unsaved: bool = False
    _shown: tuple[int, int] | None = None
    _said: dict[tuple[int, int], float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Pass lines for people on to the participants."""
        say = self.say

        def tell_all(line: str) -> None:
            say(line)
            for participant in self.participants:
                participant.hear(line)

        self.say = tell_all

    def run(self) -> dict[str, Any]:
        """Serve, and return a summary.

        Raises
        ------
        BadInput
            If the ambient temperature is not an input, or the state file is not one.
        FmuError
            If the FMU fails. Before any exception is raised, it is announced on the bus.
        """
        self._fit()
        rate = 1.0 if self.settings.machine_clock else self.settings.speed_up
        store, warm = self.unit.slave.kept(self.state_file, self.say, rate)
        self.unit.start(warm)
        if warm is not None:
            self.say(f"goes on from the state of {warm.age_s:.0f} s ago")
        begun = self.clock()
        send: Send = self.link.send
        for participant in self.participants:
            send = participant.gated(send)
        self.node = node = GatewayNode(
            *(self.database, self.unit, send, self.settings, begun, warm, self.say),
            self.clock,
            self.wall,
        )
        if warm is None and not self.settings.proof.said:
            self.say("offsets are zero and invalid until the machine is known to be cold")
        self.manager.tell("READY=1")
        # The state is written in the background, and only the newest one.
        saver = Background(2)
        try:
            self._loop(node, store, saver, begun)
        except (KeyboardInterrupt, SystemExit):
            self._leave(node, "stopping")
            raise
        except BaseException:
            self._leave(node, "error")
            raise
        self._leave(node, "stopping")
        if store is not None and node.begun:
            self._save(node, store, saver)
        if not saver.close():
            self.say("the state could not be saved in time")
        return {
            "steps": node.steps,
            "seconds": self.clock() - begun,
            "frames": dict(node.reception.counts),
            "junk": self.link.junk,
            "trust": self.database.trust,
            "probes": node.probes.taken,
        }

    def _leave(self, node: GatewayNode, state: str) -> None:
        """Announce on the bus that this node leaves, even after other failures."""
        self.manager.tell("STOPPING=1")
        with contextlib.suppress(Exception):
            node.farewell(state)

    def _fit(self) -> None:
        ambient = self.settings.proof.ambient
        inputs = [name for name in self.unit.inputs if self.unit.unit_of(name) == "degC"]
        if ambient and ambient not in inputs:
            raise BadInput("--ambient", ambient, f"is not one of {', '.join(inputs)}")
        probed = {name for frame in self.database.events(MACHINE) for name in frame.signals}
        lost = [name for name in self.unit.probed if name not in probed]
        if probed and lost:
            self.say(f"no probe can be taken: no frame carries {lost[0]}")

    def _loop(
        self, node: GatewayNode, store: StateFile | None, saver: Background, begun: float
    ) -> None:
        saved_at, lost = begun, False
        while not self._over(node, begun):
            message = self.link.receive(min(node.deadline() - self.clock(), LOOK_S))
            now = self.clock()
            if lost and not self.link.lost:
                node.reconnected()
            lost = bool(self.link.lost)
            if not all(participant.operational for participant in self.participants):
                message = None
            closed = message is not None and node.handle(message, now, self.link.waited_s)
            wait = node.grace_s if message is not None else 0.0
            if closed or (node.state == RUNNING and not lost):
                self.link.trust()
            if not closed and now >= node.deadline() + wait:
                node.tick(now, self.link.lost)
            for participant in self.participants:
                participant.update(now, lambda: self._report(node))
            self._notice(node)
            self.manager.alive(now)
            if self.renewed():
                self._renew(node)
            if store is not None and node.begun and now - saved_at >= self.save_every_s:
                self._save(node, store, saver)
                saved_at = now

    def _renew(self, node: GatewayNode) -> None:
        if not self.unit.slave.can_save:
            self.say("no new reference: this FMU cannot go back to how it was when it started")
            return
        self.say("the drift is counted from now: somebody says that the machine is cold")
        node.renew_reference()

    def _report(self, node: GatewayNode) -> Report:
        answer, outputs = node.answer, self.unit.outputs
        shown = outputs | half_widths(outputs, known=node.reference_known)
        state: dict[str, Value | bool] = {
            "valid": answer.get("valid") == "valid",
            "status": node.status,
            "status_text": node.status_text,
            "status_sensor": int(outputs.get("status_sensor", 0)),
            "reference_known": node.reference_known,
            "gateway_state": node.state,
            "bus_fault": answer.get("bus_fault", "none"),
            "trust": self.database.trust,
            "machine_time": node.stepper.machine_time_s,
            "steps": node.steps,
            "compensator": self.fmu.name,
            "compensator_sha256": self.unit.slave.sha256,
        }
        return Report(answer, node.given, shown, state)

    def _over(self, node: GatewayNode, begun: float) -> bool:
        late = self.duration_s is not None and self.clock() - begun >= self.duration_s
        return self.stopped() or late or (self.until_off and node.machine_off)

    def _save(self, node: GatewayNode, store: StateFile, saver: Background) -> None:
        state = self.unit.slave.saved()
        machine_time_s = node.stepper.machine_time_at(self.clock())
        taken = (store.now(), self.unit.time_s, machine_time_s, state)

        def write() -> None:
            try:
                store.write(*taken)
            except BadInput as error:  # a full disk does not stop the gateway
                if not self._unsaved:
                    self.say(f"{error}; the gateway goes on without saving")
                self._unsaved = True
            else:
                self._unsaved = False

        saver.do(write)

    def _notice(self, node: GatewayNode) -> None:
        """Report changes of the status, each one not too often."""
        time_s, now = node.stepper.machine_time_s, self.clock()
        status = node.status, int(self.unit.outputs.get("status_sensor", 0))
        if status == self._shown or now - self._said.get(status, -inf) < WORD_HOLDS_S:
            return
        self._shown, self._said[status] = status, now
        text = f"status {node.status} at {time_s:.1f} s: {node.status_text}"
        self.manager.tell(f"STATUS={text}")
        self.say(text)
