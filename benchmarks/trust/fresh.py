"""Splits that nothing was set on: other days of the lathe, and jig borers drawn anew."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.trust.questions import JUDGED, TRAINING, Change, Question, lathe_runs, simulated
from measurement.rig import default_rig, rig_from_table
from plant_model.machine_file import read_machine

DRAWS = 7301
MACHINES = range(8301, 8307)
WITHIN = 0.3
"""Parameters of a machine drawn are those of the jig borer, within so much of them [1]."""


def fresh_lathe(folder: Path) -> Iterator[Question]:
    """Yield splits by days drawn at random, by blocks of days, and by how much the lathe warms."""
    runs = lathe_runs(folder)
    if not runs:
        return
    rig = default_rig(runs[0], read_machine("jig_borer_lumps").rig)
    places = np.arange(len(runs))
    rises = [
        np.nanmax(middle) - middle[0]
        for run in runs
        for middle in [np.nanmedian(run.frame[list(run.temperatures)].to_numpy(float), axis=1)]
    ]
    order = np.argsort(rises)
    draw = np.random.default_rng(DRAWS)

    def learnt(name: str, train: Sequence[int] | np.ndarray, unlike: bool = True) -> Question:
        known = sorted(int(place) for place in train)
        out = [place for place in places if place not in known]
        given = [[runs[place] for place in part] for part in (known, out)]
        return Question("lathe", name, unlike, *given, rig)

    for count, draws in ((12, 4), (6, 3)):
        for number in range(1, draws + 1):
            name = f"{count} days drawn, draw {number}"
            yield learnt(name, draw.permutation(len(runs))[:count], unlike=False)
    yield learnt("all but the middle ten", places[10:20])
    yield learnt("the middle ten", np.r_[places[:10], places[20:]])
    yield learnt("all but the last fifteen", places[15:])
    yield learnt("all but the last eight", places[-8:])
    yield learnt("the ten largest rises", order[:-10])
    yield learnt("the ten smallest rises", order[10:])


def fresh_simulated() -> Iterator[Question]:
    """Yield jig borers with other parameters, judged like, in another hall, and worn."""
    rig = rig_from_table(read_machine("jig_borer_lumps").rig, "rig")
    for seed in MACHINES:
        draw = np.random.default_rng(seed)
        count = draw.integers(3, 5)

        def drawn(name: str, seed: int = seed) -> float:
            letters = [ord(letter) for letter in name]
            return float(
                np.random.default_rng([seed, *letters]).uniform(1.0 - WITHIN, 1.0 + WITHIN)
            )

        def worn(name: str, own: Change = drawn) -> float:
            return own(name) * (1.3 if "bearing" in name else 1.0)

        train = [
            simulated(f"{base}{number}", base, 0.0, 0.0, drawn)
            for number, base in enumerate(draw.permutation(TRAINING)[:count])
        ]
        coolant, hall = float(draw.uniform(-4.0, 4.0)), float(draw.uniform(-8.0, 8.0))
        changed = f"coolant {coolant:+.1f} K, hall {hall:+.1f} K"
        cases = (("itself", 0.0, 0.0, drawn), (changed, coolant, hall, drawn), ("worn", 0, 0, worn))
        for what, coolant_k, hall_k, change in cases:
            judged = [simulated(base, base, coolant_k, hall_k, change) for base in JUDGED]
            unlike = what != "itself"
            yield Question("drawn machines", f"{seed}, {what}", unlike, train, judged, rig)
