"""The same runs, recorded otherwise: thinned, or with rows lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from measurement.runs import Run

LOST = 0.1
"""Share of the rows that are dropped at random [1]."""


def variants(
    runs: Sequence[Run], seed: int, thinned_s: Sequence[float]
) -> Iterator[tuple[str, list[Run]]]:
    """Return the runs as recorded, thinned to each interval [s], and with rows dropped."""
    yield "as recorded", list(runs)
    for every_s in thinned_s:
        thinned = []
        for run in runs:
            every = max(1, round(every_s / float(np.median(np.diff(run.time_s)))))
            thinned.append(Run(run.name, run.frame.iloc[::every]))
        yield f"every {every_s:g} s", thinned
    random = np.random.default_rng(seed)
    dropped = [Run(run.name, run.frame[random.random(len(run.frame)) > LOST]) for run in runs]
    yield "a tenth dropped", dropped
