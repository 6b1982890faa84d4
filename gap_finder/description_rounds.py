"""Changes of the description, one after another, and those taken out that others made needless."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from gap_finder.by_channel import unseen_by_channel
from gap_finder.calibrate import Progress
from gap_finder.describe import LEAST_SHARE, NEARLY, select_change
from gap_finder.description import NamedChange
from gap_finder.design import RunSensitivities, all_sensitivities
from gap_finder.refit import CandidateFit, fit_effects, refit_in_full, score_fit
from gap_finder.selection import RIVAL_ODDS, clearly_better, cost_per_run_and_channel

SETTLED = 1.6
"""Cost per run and channel at which nothing more is looked for: empty cases leave about as much."""

LONG_ODDS = RIVAL_ODDS / 30.0
"""Odds below which effects give way to a change of the description: some thirty times as many
changes are tried as effects."""


def select_changes(
    pool: Executor,
    baseline: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    seed: int,
    most: int,
    progress: Progress,
    instead_of: CandidateFit | None = None,
) -> list[NamedChange]:
    """Look for changes of the description until none is found or *most* are.

    Parameters
    ----------
    pool : Executor
    baseline : CandidateFit
        With no effect added.
    sensitivities : sequence of RunSensitivities
        About its machine.
    seed : int
        Of the draws in which nothing is missing.
    most : int
    progress : callable
        Told what is being done.
    instead_of : CandidateFit, optional
        With effects that explain the same; then nothing is returned unless the first change leaves
        clearly less. There are many more changes than effects, so the odds must be longer.

    Returns
    -------
    list of NamedChange
        In the order in which they were found; ``after`` of each is with all up to it.
    """
    found: list[NamedChange] = []
    after = baseline
    while len(found) < most and not (found and cost_per_run_and_channel(after) < SETTLED):
        progress(f"looking for what the description lacks, {len(found) + 1}")
        one, grown = select_change(pool, after, sensitivities, seed)
        if one is None:
            break
        progress(f"calibrating with {one.key}")
        after, sensitivities = refit_in_full(grown)
        if (
            instead_of is not None
            and not found
            and not clearly_better(after, instead_of, LONG_ODDS)
        ):
            break
        found.append(replace(one, after=after))
        if len(found) > 1:
            progress("asking whether the earlier ones are still needed")
            for earlier in found[:-1]:
                if not _still_needed(baseline, found, earlier, sensitivities):
                    found = left_out(baseline, found, earlier)
                    after = found[-1].after
                    sensitivities = all_sensitivities(after.base, after.machine, after.observed)
    return found


def left_out(
    baseline: CandidateFit, found: Sequence[NamedChange], gone: NamedChange
) -> list[NamedChange]:
    """Return changes without one of them, all that came after it calibrated anew.

    Parameters
    ----------
    baseline : CandidateFit
        Before any of them.
    found : sequence of NamedChange
    gone : NamedChange
        One of them.
    """
    place = next(i for i, one in enumerate(found) if one is gone)
    kept = list(found[:place])
    for later in found[place + 1 :]:
        kept.append(replace(later, after=_with(baseline, [*kept, later], later.after)))
    return kept


def _with(
    baseline: CandidateFit,
    some: Sequence[NamedChange],
    start: CandidateFit,
    sensitivities: Sequence[RunSensitivities] | None = None,
) -> CandidateFit:
    """Calibrate the machine with some changes, from where another calibration left it."""
    base, machine = baseline.base, baseline.machine
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
    if sensitivities is None:
        sensitivities = all_sensitivities(base, begin, baseline.observed)
    found = fit_effects(base, baseline.added, baseline.observed, [begin], sensitivities)
    return score_fit(base, baseline.added, baseline.observed, found.calibration, sensitivities)


def _still_needed(
    baseline: CandidateFit,
    found: Sequence[NamedChange],
    one: NamedChange,
    sensitivities: Sequence[RunSensitivities],
) -> bool:
    """Tell whether a change still explains most of what it was named for, beside all others."""
    after = found[-1].after
    bare = _with(baseline, [other for other in found if other is not one], after, sensitivities)
    names = baseline.observed[0].channels
    parts = [unseen_by_channel(e.designs, e.position(), len(names)) for e in (after, bare)]
    some = slice(None) if not one.channel else names.index(one.channel)
    with_it, without_it = (float(part[:, some].sum()) for part in parts)
    return 1.0 - with_it / without_it >= NEARLY * LEAST_SHARE
