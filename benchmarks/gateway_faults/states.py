"""Restarts: is the reference known, and is a state that cannot be used left alone?"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.gateway_faults.harness import Episode, Outcome
from gateway.database import Database
from gateway.state import OLDEST_S, Saved, StateFile

FMU = "an FMU"


def _warm(
    database: Database,
    rng: np.random.Generator,
    *,
    age_s: Callable[[np.random.Generator], float] | None = None,
    fmu: str = FMU,
) -> Outcome:
    """A gateway that is started in a warm-up, beside a state that cannot be used, or none."""
    saved = _restored(100.0, 50.0, float(age_s(rng)), fmu) if age_s else None
    episode = Episode(database, rng, warm=saved, cold=False)
    # Whether a state may be used is what is asked here; the bench knows the answer.
    episode.reference_known = False
    episode.begin()
    for _ in range(int(rng.integers(5, 40))):
        episode.cycle()
    return episode.outcome


def _looks_young(database: Database, rng: np.random.Generator, *, machine_anew: bool) -> Outcome:
    """A computer without a clock battery: hours went by, and the state is of two seconds ago."""
    episode = Episode(database, rng, cold=False)
    gone_s = float(rng.uniform(1.2, 10.0)) * OLDEST_S
    then_s = episode.time_s
    episode.start_gateway(_restored(100.0, then_s, float(rng.uniform(0.0, 60.0))))
    episode.time_s = round(float(rng.uniform(0.0, 60.0)) if machine_anew else then_s + gone_s, 1)
    episode.reference_known = False
    episode.begin()
    for _ in range(40):
        episode.cycle()
    return episode.outcome


def _restored(time_s: float, machine_time_s: float, age_s: float, fmu: str = FMU) -> Saved | None:
    """Write a state that is so old by the time of day, and read it again, for an FMU."""
    with tempfile.TemporaryDirectory() as folder:
        store = StateFile(Path(folder) / "state.json", FMU, lambda: 1e9)
        store.write(1e9 - age_s, time_s, machine_time_s, b"state")
        return StateFile(store.path, fmu, lambda: 1e9).read()[0]


def _either_side(database: Database, rng: np.random.Generator) -> Outcome:
    """Gateway and machine start anew in any order, with the gateway's state of a moment ago."""
    episode = Episode(database, rng)
    episode.settle()
    for _ in range(int(rng.integers(1, 5))):
        for _ in range(int(rng.integers(0, 30))):
            episode.cycle()
        if rng.random() < 0.5:
            episode.start_machine(float(rng.choice([0.0, episode.time_s])))
            continue
        begun = episode.node.begun
        saved = (episode.glass.time_s, episode.node.stepper.machine_time_at(episode.now))
        away_s = round(float(rng.uniform(0.5, 600.0)), 1)
        episode.now += away_s
        # The machine goes on, or was started anew in the meantime.
        episode.time_s = round(episode.time_s + away_s if rng.random() < 0.7 else away_s / 2.0, 3)
        episode.start_gateway(_restored(*saved, away_s) if begun else None)
        if rng.random() < 0.3:
            episode.start_machine(episode.time_s)
    return episode.finish()


WARM = "started in a warm-up, "
RESTARTS: dict[str, Callable[[Database, np.random.Generator], Outcome]] = {
    WARM + "no state": _warm,
    WARM + "state too old": partial(_warm, age_s=lambda rng: rng.uniform(3601, 1e6)),
    WARM + "state from the future": partial(_warm, age_s=lambda rng: -rng.uniform(1, 1e6)),
    WARM + "state of another FMU": partial(_warm, age_s=lambda rng: 10.0, fmu="another"),
    WARM + "a state that looks young": partial(_looks_young, machine_anew=False),
    WARM + "a state that looks young, machine anew": partial(_looks_young, machine_anew=True),
    "restarts of either side": _either_side,
}
