"""The simulated machine at work: the control, its plant, its bus, its state file."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gateway.database import Database
from gateway.link import Link
from gateway.machine import MachineNode, Pace
from gateway.plant import MachinePlant


@dataclass
class Simulation:
    """Runs a machine to the end of its scenario.

    Parameters
    ----------
    database : Database
        The frames.
    plant : MachinePlant
        The machine, loaded.
    link : Link
        The bus, open.
    pace : Pace
        How fast.
    state_file : Path or None
        Where the plant's state is kept.
    save_every_s : float
        How often [s].
    stopped : callable
        Says when to end early.
    say : callable
        Takes a line for people.
    key : bytes or None
        What its proofs of freshness are made with.
    """

    database: Database
    plant: MachinePlant
    link: Link
    pace: Pace
    state_file: Path | None = None
    save_every_s: float = 10.0
    stopped: Callable[[], bool] = lambda: False
    say: Callable[[str], None] = lambda line: None
    clock: Callable[[], float] = time.monotonic
    key: bytes | None = None

    def run(self) -> dict[str, Any]:
        """Simulate, and return a summary.

        Raises
        ------
        BadInput
            If the state file is none.
        FmuError
            If the FMU fails.
        """
        self._store, saved = self.plant.slave.kept(self.state_file, self.say)
        self.plant.start(saved)
        if saved is not None:
            self.say(
                f"goes on at {self.plant.time_s:g} s from the state of {saved.age_s:.0f} s ago"
            )
        begun, first = self.clock(), self.plant.time_s
        self._saved_at = begun
        node = MachineNode(
            self.database,
            self.plant,
            self.link,
            self.pace,
            self._save,
            self.stopped,
            self.clock,
            self.key,
        )
        node.run()
        return {
            "steps": self.plant.point - round(first / self.plant.step_s),
            "answered": node.answered,
            "simulated_s": self.plant.time_s - first,
            "seconds": self.clock() - begun,
            "frames": dict(node.ear.reception.counts),
        }

    def _save(self) -> None:
        now = self.clock()
        if self._store is not None and now - self._saved_at >= self.save_every_s:
            time_s = self.plant.time_s
            state = self.plant.slave.saved()
            self._store.write(self._store.now(), time_s, time_s, state)
            self._saved_at = now
