"""With two effects missing, the first was chosen while the second was not known: ask again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gap_finder.candidates import beyond_usual_range, given_values, widened, with_effect
from gap_finder.design import RunSensitivities
from gap_finder.keys import law_of
from gap_finder.observations import Observations
from gap_finder.refit import CandidateFit, fit_effects, refit_in_full
from gap_finder.selection import RIVAL_ODDS, SelectionRound, odds_among
from plant_model.machine import Machine


def swapped(
    first: SelectionRound, after: CandidateFit, sensitivities: Sequence[RunSensitivities]
) -> tuple[SelectionRound, CandidateFit]:
    """Choose anew among the effects that the first round could not tell apart.

    Parameters
    ----------
    first : SelectionRound
        The first round, which named one or one of several.
    after : CandidateFit
        With the first round's best and the second round's effect in force.
    sensitivities : sequence of RunSensitivities
        About *after*.

    Returns
    -------
    first : SelectionRound
        With those of the set that are left beside the second effect, the best first.
    after : CandidateFit
        With the best of them and the second effect in force.
    """
    key = after.added[-1]
    rivals = [name for name in first.one_of[1:] if law_of(name) != law_of(key)]
    if not rivals:
        return first, after
    options = {first.one_of[0]: after}
    for name in rivals:
        alone = next(one for one in first.fits if one.added[-1] == name)
        observed = [_of_both(*pair) for pair in zip(alone.observed, after.observed, strict=True)]
        start = with_effect(alone.machine, key, _values(after.machine, key))
        base = with_effect(alone.base, key, given_values(key, _values(after.machine, key)))
        if beyond_usual_range(after.machine, key):
            base = widened(base, key)
        options[name] = fit_effects(base, (*alone.added, key), observed, [start], sensitivities)
    left = [name for name, odd in odds_among(options).items() if odd >= RIVAL_ODDS]
    best = options[left[0]]
    if best is not after:
        best, _ = refit_in_full(best)
    chosen = replace(first, one_of=tuple(left))
    share = 1.0 - float(chosen.best.loro_cost.sum()) / float(first.baseline.loro_cost.sum())
    return replace(chosen, explained_share=share), best


def _values(machine: Machine, key: str) -> dict[str, float]:
    """Return the values of an effect's parameters."""
    return {name: parameter.value for name, parameter in machine.effects[key].items()}


def _of_both(one: Observations, other: Observations) -> Observations:
    """Return a run's observations with what is said of it alone by either."""
    held = {**one.drive.held, **other.drive.held}
    return replace(
        other,
        drive=replace(other.drive, held=held),
        absent=one.absent | other.absent,
        own={**one.own, **other.own},
    )
