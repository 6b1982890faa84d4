"""Which driver a named law has: asked of the calibrations, for the screening cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from gap_finder.candidates import with_effect
from gap_finder.design import RunSensitivities
from gap_finder.keys import law_of
from gap_finder.refit import CandidateFit, refit_in_full
from gap_finder.selection import RIVAL_ODDS, SelectionRound, odds_among
from plant_model.effects import catalogue
from plant_model.machine import Machine

WORSE = 0.5
"""Share of what a law explains on its best driver that it must explain on another, so that the
other is calibrated in full, too [1]. A law of temperatures is on each: on borrowed derivatives the
right driver may not move at all."""


def other_drivers(
    explained: Sequence[CandidateFit],
    baseline: CandidateFit,
    null_q99: float,
    best: dict[str, int],
) -> list[int]:
    """Return what else to calibrate: the other drivers of the law that explains most.

    Parameters
    ----------
    explained : sequence of CandidateFit
        The best effects, each on the driver that does most in the screening.
    baseline : CandidateFit
    null_q99 : float
        Null 99 % quantile: a law that explains less than chance is not asked for its driver.
    best : dict of str to int
        All keys, and where each does most.

    Notes
    -----
    Where a law is far from linear, the right driver shows only when everything else has moved with
    it. That costs one calibration a driver, and only where something may be named.
    """
    if not explained:
        return []
    first = min(explained, key=lambda one: float(one.loro_cost.sum()))
    share = 1.0 - float(first.loro_cost.sum()) / float(baseline.loro_cost.sum())
    key = first.added[-1]
    others = [i for other, i in best.items() if law_of(other) == law_of(key) and other != key]
    return others if share >= null_q99 else []


def on_its_driver(
    pool: Executor, selection: SelectionRound
) -> tuple[SelectionRound, CandidateFit, list[RunSensitivities]]:
    """Calibrate a named law in full, on each driver that was tried, and choose among these.

    Parameters
    ----------
    pool : Executor
    selection : SelectionRound
        In which something is named.

    Returns
    -------
    selection : SelectionRound
        Its ``one_of`` begins with the law on the best driver, then on every one that cannot be
        excluded, then the other laws.
    after : CandidateFit
        With that best one in force.
    sensitivities : list of RunSensitivities
        About it.
    """
    law = law_of(selection.best.added[-1])
    # An error of one sensor has no driver; when a part switches something is measured, so that the
    # screening has told the parts apart.
    if law not in catalogue() or catalogue()[law].switched:
        return selection, *refit_in_full(selection.best)
    tried = [one for one in selection.fits if law_of(one.added[-1]) == law]
    before = float(selection.baseline.loro_cost.sum())
    gains = [before - float(one.loro_cost.sum()) for one in tried]
    needed = -np.inf if catalogue()[law].temperature_dependent else WORSE * max(gains)
    same = [one for one, gain in zip(tried, gains, strict=True) if gain >= needed]
    if len(same) < 2:
        return selection, *refit_in_full(selection.best)
    first = min(same, key=lambda one: float(one.loro_cost.sum()))
    leading = refit_in_full(first)
    jobs = {
        one.added[-1]: pool.submit(refit_in_full, one, [_driven_by(leading[0], one.added[-1])])
        for one in same
        if one is not first
    }
    full = {
        one.added[-1]: leading if one is first else jobs[one.added[-1]].result() for one in same
    }
    odds = odds_among({key: found for key, (found, _) in full.items()})
    left = [key for key, odd in odds.items() if odd >= RIVAL_ODDS]
    others = [key for key in selection.one_of if law_of(key) != law]
    calibrated = {one.added[-1]: replace(full[one.added[-1]][0], acts=one.acts) for one in same}
    chosen = replace(
        selection,
        one_of=(*left, *others),
        fits=tuple(calibrated.get(one.added[-1], one) for one in selection.fits),
    )
    after, sensitivities = full[left[0]]
    return chosen, after, sensitivities


def _driven_by(leading: CandidateFit, key: str) -> Machine:
    """Return the machine calibrated on one driver, with the same law on another instead.

    Everything else has moved with the law there, which is where the other one may begin.
    """
    machine, known = leading.machine, leading.added[-1]
    values = {name: parameter.value for name, parameter in machine.effects[known].items()}
    rest = {other: table for other, table in machine.effects.items() if other != known}
    return with_effect(replace(machine, effects=rest), key, values)
