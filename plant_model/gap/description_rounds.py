"""Changes of the description, one after another, and those taken out that others made needless."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from plant_model.gap.by_channel import unseen_by_channel
from plant_model.gap.calibrate import Progress
from plant_model.gap.describe import LEAST_SHARE, NEARLY, look
from plant_model.gap.description import Described
from plant_model.gap.design import Surroundings, all_surroundings
from plant_model.gap.judge import RIVAL, left_over, odds_of, unit_of
from plant_model.gap.refit import Explained, explain, refined, scored

SETTLED = 1.6
"""Cost per run and channel at which nothing more is looked for: empty cases leave about as much."""

LONG_ODDS = RIVAL / 30.0
"""Odds below which effects give way to a change of the description: some thirty times as many
changes are tried as effects."""


def describe(
    pool: Executor,
    now: Explained,
    around: Sequence[Surroundings],
    seed: int,
    most: int,
    progress: Progress,
    instead_of: Explained | None = None,
) -> list[Described]:
    """Look for changes of the description until none is found or *most* are.

    Parameters
    ----------
    pool : Executor
    now : Explained
        With no effect added.
    around : sequence of Surroundings
        About its machine.
    seed : int
        Of the draws in which nothing is missing.
    most : int
    progress : callable
        Told what is being done.
    instead_of : Explained, optional
        With effects that explain the same; then nothing is returned unless the first change leaves
        clearly less. There are many more changes than effects, so the odds must be longer.

    Returns
    -------
    list of Described
        In the order in which they were found; ``after`` of each is with all up to it.
    """
    found: list[Described] = []
    after = now
    channels = len(now.observed[0].channels)
    while len(found) < most and not (found and left_over(after, channels) < SETTLED):
        progress(f"looking for what the description lacks, {len(found) + 1}")
        one, grown = look(pool, after, around, seed)
        if one is None:
            break
        progress(f"calibrating with {one.key}")
        after, around = refined(grown)
        if instead_of is not None and not found and not _clearly_better(after, instead_of):
            break
        found.append(replace(one, after=after))
        if len(found) > 1:
            progress("asking whether the earlier ones are still needed")
            for earlier in found[:-1]:
                if not _still_needed(now, found, earlier, around):
                    found = left_out(now, found, earlier)
                    after = found[-1].after
                    around = all_surroundings(after.base, after.machine, after.observed)
    return found


def _clearly_better(one: Explained, other: Explained) -> bool:
    """Tell whether a change of the description explains the runs better than effects do."""
    costs = np.array([float(one.unseen.sum()), float(other.unseen.sum())])
    pieces = len(one.unseen) * len(one.observed[0].channels)
    return bool(odds_of(costs, unit_of(float(costs.min()), pieces))[1] < LONG_ODDS)


def left_out(now: Explained, found: Sequence[Described], gone: Described) -> list[Described]:
    """Return changes without one of them, all that came after it calibrated anew.

    Parameters
    ----------
    now : Explained
        Before any of them.
    found : sequence of Described
    gone : Described
        One of them.
    """
    place = next(i for i, one in enumerate(found) if one is gone)
    kept = list(found[:place])
    for later in found[place + 1 :]:
        kept.append(replace(later, after=_with(now, [*kept, later], later.after)))
    return kept


def _with(
    now: Explained,
    some: Sequence[Described],
    start: Explained,
    around: Sequence[Surroundings] | None = None,
) -> Explained:
    """Calibrate the machine with some changes, from where another calibration left it."""
    base, machine = now.base, now.machine
    for one in some:
        numbers = one.change.read(start.machine)
        base, machine = one.change.put_into(base, numbers), one.change.put_into(machine, numbers)
    shared = {
        name: value.value
        for name, value in start.machine.parameters.items()
        if name in machine.parameters and not value.tied and value.calibrate
    }
    limits = machine.parameters
    values = {
        name: float(np.clip(value, limits[name].low, limits[name].high))
        for name, value in shared.items()
    }
    begin = machine.with_values(values)
    if around is None:
        around = all_surroundings(base, begin, now.observed)
    found = explain(base, now.added, now.observed, [begin], around)
    return scored(base, now.added, now.observed, found.calibration, around)


def _still_needed(
    now: Explained,
    found: Sequence[Described],
    one: Described,
    around: Sequence[Surroundings],
) -> bool:
    """Tell whether a change still explains most of what it was named for, beside all others."""
    after = found[-1].after
    bare = _with(now, [other for other in found if other is not one], after, around)
    names = now.observed[0].channels
    parts = [unseen_by_channel(e.designs, e.pull(), len(names)) for e in (after, bare)]
    some = slice(None) if not one.channel else names.index(one.channel)
    with_it, without_it = (float(part[:, some].sum()) for part in parts)
    return 1.0 - with_it / without_it >= NEARLY * LEAST_SHARE
