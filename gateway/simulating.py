"""The simulated machine at work: the control, its plant, its bus, its state file."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gateway.database import Database
from gateway.link import Link
from gateway.machine import MachineNode, Pace
from gateway.plant import MachinePlant


def simulate_on_bus(
    database: Database,
    plant: MachinePlant,
    link: Link,
    pace: Pace,
    *,
    state_file: Path | None = None,
    save_every_s: float = 10.0,
    stopped: Callable[[], bool] = lambda: False,
    say: Callable[[str], None] = lambda line: None,
    key: bytes | None = None,
) -> dict[str, Any]:
    """Run a machine to the end of its scenario, and return a summary.

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
    state_file : Path, optional
        Where the plant's state is kept.
    save_every_s : float, optional
        How often [s].
    stopped : callable, optional
        Says when to end early.
    say : callable, optional
        Takes a line for people.
    key : bytes, optional
        What its proofs of freshness are made with.

    Raises
    ------
    BadInput
        If the state file is none.
    FmuError
        If the FMU fails.
    """
    store, saved = plant.slave.kept(state_file, say)
    plant.start(saved)
    if saved is not None:
        say(f"goes on at {plant.time_s:g} s from the state of {saved.age_s:.0f} s ago")
    begun, first = time.monotonic(), plant.time_s
    saved_at = begun

    def save() -> None:
        nonlocal saved_at
        if store is not None and time.monotonic() - saved_at >= save_every_s:
            store.write(store.now(), plant.time_s, plant.time_s, plant.slave.saved())
            saved_at = time.monotonic()

    node = MachineNode(database, plant, link, pace, save, stopped, key=key)
    node.run()
    return {
        "steps": plant.point - round(first / plant.step_s),
        "answered": node.answered,
        "simulated_s": plant.time_s - first,
        "seconds": time.monotonic() - begun,
        "frames": dict(node.answers.reception.counts),
    }
