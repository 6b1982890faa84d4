"""Restarts: is the reference known, and is a state that cannot be used left alone?"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.gateway_faults.harness import Episode, Wire
from gateway.unit import OLDEST_S, StateFile

FMU = "an FMU"


def _episode(wire: Wire, rng: np.random.Generator, age_s: float | None, fmu: str = FMU) -> Episode:
    """A gateway that is started in a warm-up, beside a state of an age, or none."""
    with tempfile.TemporaryDirectory() as folder:
        store = StateFile(Path(folder) / "state.json", FMU, lambda: 1e9)
        if age_s is not None:
            store.write(1e9 - age_s, 100.0, 50.0, b"state")
        saved, _ = StateFile(store.path, fmu, lambda: 1e9).read()
    episode = Episode(wire, rng, warm=saved, cold=False)
    # Whether a state may be used is what is asked here; the bench knows the answer.
    episode.reference_known = age_s is not None and 0.0 <= age_s <= OLDEST_S and fmu == FMU
    episode.begin()
    for _ in range(int(rng.integers(5, 40))):
        episode.cycle()
    return episode


RESTARTS: dict[str, Callable[[Wire, np.random.Generator], Episode]] = {
    "no state": lambda wire, rng: _episode(wire, rng, None),
    "state too old": lambda wire, rng: _episode(wire, rng, float(rng.uniform(3601, 1e6))),
    "state from the future": lambda wire, rng: _episode(wire, rng, -float(rng.uniform(1, 1e6))),
    "state of another FMU": lambda wire, rng: _episode(wire, rng, 10.0, "another"),
}
