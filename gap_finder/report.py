"""The gap finder's answer as data: what ``gap.json`` holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from gap_finder.candidates import beyond_usual_range
from gap_finder.data_faults import DataFault
from gap_finder.description import place_of
from gap_finder.find import GapResult
from gap_finder.further_run import FurtherRun, further_run
from gap_finder.keys import driver_of, is_switched, law_of
from gap_finder.observations import Observations
from gap_finder.periods import in_step
from gap_finder.reference import LEFT, ReferenceModel
from gap_finder.regimes import (
    RunResiduals,
    by_channel,
    floor_of,
    gap_of,
    mean_squares,
    noise_of,
    places,
    residuals,
)
from gap_finder.selection import SelectionRound, above_tolerance, cost_per_run_and_channel
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

MACHINE_AFTER = "machine_after.toml"

WORSE = 1.0
"""Rise of a channel's mean square from which it counts as worse [tolerances squared]."""

HARM = 0.1
"""Share of what other channels gain that an addition may cost channels that get worse [1]."""


class GapComparison:
    """Residuals of the machine before and after, on some runs.

    Parameters
    ----------
    before, after : Machine
    observed : sequence of Observations
    """

    def __init__(self, before: Machine, after: Machine, observed: Sequence[Observations]) -> None:
        self.machine = before
        self.before: list[RunResiduals] = [residuals(before, one) for one in observed]
        self.after = self.before
        if after is not before:
            self.after = [residuals(after, in_step(after, one)) for one in observed]

    def gap(self) -> dict[str, float]:
        """Return the gap before and after and its floor [1]."""
        return {
            "before": gap_of(self.machine, self.before),
            "after": gap_of(self.machine, self.after),
            "floor": floor_of(self.before),
        }

    def made_worse(self) -> bool:
        """Tell whether what was added puts right some channels at the cost of another.

        An effect that was really missing makes no channel worse by much, and all of them together
        by next to nothing of what it makes better.
        """
        before, after = (
            mean_squares([one.values / one.observed.tolerance for one in part])
            for part in (self.before, self.after)
        )
        change = np.nan_to_num(after - before)
        harm, gain = change[change > 0.0].sum(), -change[change < 0.0].sum()
        return bool(change.max(initial=0.0) > WORSE and harm > HARM * gain)

    def gap_beside(self, reference: Sequence[FloatArray]) -> dict[str, float]:
        """Return the gap with what the reference leaves, (K, C) of each run, and the rest of it.

        Parameters
        ----------
        reference : sequence of array, each (K, C)
            Residuals of each run that no description of this machine could take away [K, um].

        Returns
        -------
        dict of str to float
            ``before``, ``after``, ``reference`` and ``reducible``, which is never below 0 [1].
        """
        table = self.gap()
        least = gap_of(self.machine, self._with(reference))
        return table | {"reference": least, "reducible": max(table["after"] - least, 0.0)}

    def _with(self, values: Sequence[FloatArray]) -> list[RunResiduals]:
        return [replace(one, values=other) for one, other in zip(self.after, values, strict=True)]

    def channels(self) -> dict[str, dict[str, Any]]:
        """Return every channel's residual before and after, its noise, and what noise leaves.

        ``no_model`` is how far it moves from its first reading: what is left if nothing is
        modelled.
        """
        names = self.before[0].observed.channels
        lengths = set(displacement_names(self.machine))
        noise, floor = noise_of(self.machine, names), floor_of(self.before)
        first, last = (by_channel(self.machine, part) for part in (self.before, self.after))
        return {
            name: {
                "before": first[name],
                "after": last[name],
                "noise": float(noise[i]),
                "floor": float(noise[i]) * floor,
                "no_model": _moved([one.observed.values[:, i] for one in self.before]),
                "unit": "um" if name in lengths else "K",
            }
            for i, name in enumerate(names)
            if name in first
        }

    def channels_beside(self, reference: Sequence[FloatArray]) -> dict[str, dict[str, Any]]:
        """Return the channels with what the reference leaves of each, and the rest of it.

        Parameters
        ----------
        reference : sequence of array, each (K, C)
            As in `gap_beside`.

        Returns
        -------
        dict of str to dict
            By channel [K, um].
        """
        table = self.channels()
        least = by_channel(self.machine, self._with(reference))
        for name, entry in table.items():
            entry["reference"] = least[name]
            entry["reducible"] = max(entry["after"] - least[name], 0.0)
        return table


def _moved(runs: Sequence[FloatArray]) -> float:
    """Return the root mean square of readings about each run's first one."""
    known = [values[np.isfinite(values)] for values in runs]
    away = np.concatenate([values - values[:1] for values in known])
    return float(np.sqrt(np.mean(away**2)))


def report_of(
    found: GapResult,
    unseen: GapComparison,
    faults: Sequence[DataFault] = (),
    cosimulation: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the content of ``gap.json``.

    Parameters
    ----------
    found : GapResult
    unseen : GapComparison
        On the runs that were not used; the channels' table is of these.
    faults : sequence of DataFault
        What was left out of the runs beforehand.
    cosimulation : mapping, optional
        The gap of the plant FMUs on the runs that were not used.
    """
    before, after = found.before.machine, found.after.machine
    calibration = GapComparison(before, after, found.observed)
    reference = ReferenceModel(after, calibration.after, unseen.after)
    at_first = ReferenceModel(before, calibration.before)
    first, keys = found.rounds[0], _one_of(found)
    proposed = proposed_run(found)
    table = {
        "verdict": found.verdict,
        "in_doubt": found.in_doubt,
        "effects": [
            *(
                one.entry(found.after) | {"evidence": _evidence(one.selection, one.channel)}
                for one in found.changes
            ),
            *(_effect(selection, found) for selection in found.rounds if selection.named),
        ],
        "one_of": list(dict.fromkeys(_name(key) for key in keys)),
        "one_of_keys": list(keys),
        "separate_by": _said(keys, proposed),
        "next_run": asdict(proposed) if proposed else None,
        "runners_up": [
            {
                **_named(one.added[-1], one.machine),
                "probability": p,
                "beyond_its_range": list(one.at_bounds),
            }
            for one, p in zip(first.fits, first.probability, strict=True)
            if not first.named or one is not first.best
        ],
        "where": [_place(asdict(place)) for place in places(before, calibration.before)],
        "gap": {
            "calibration": calibration.gap_beside(reference.known),
            "holdout": unseen.gap_beside(reference.unseen),
        },
        "channels": _channels(unseen, reference),
        "remaining": _remaining(at_first, reference, found),
        "withdrawn": [
            _named(one.key, before) | {"runs": list(one.runs)} for one in found.withdrawn
        ],
        "machine": MACHINE_AFTER,
        "data_faults": [asdict(fault) for fault in faults],
        "evidence": {
            "share_explained": first.explained_share,
            "share_by_chance": first.null_q99,
            "cost_per_run_and_channel": cost_per_run_and_channel(first.baseline),
        },
    }
    return table if cosimulation is None else table | {"cosimulation": dict(cosimulation)}


def _channels(unseen: GapComparison, reference: ReferenceModel) -> dict[str, dict[str, Any]]:
    """Return the channels' table, with what predicts most of what is left of each."""
    table = unseen.channels_beside(reference.unseen)
    for name, entry in table.items():
        entry["predicted_by"] = [asdict(one) for one in reference.sources_of(name)]
    return table


def _remaining(
    before: ReferenceModel, reference: ReferenceModel, found: GapResult
) -> dict[str, Any]:
    """Return what of the runs used can still be explained: whether, how much, where, by what."""
    return {
        "is_reducible": reference.is_left,
        "above_tolerance": above_tolerance(found.after),
        "squared_tolerances": reference.reducible,
        "before": before.reducible,
        "share": reference.share,
        "limit": LEFT,
        "where": [asdict(place) for place in reference.places()],
        "predicted_by": [asdict(one) for one in reference.sources()],
    }


def _said(keys: Sequence[str], proposed: FurtherRun | None) -> str:
    if len(keys) < 2:
        return ""
    none = "no run of those tried: the two differ by less than twice the sensors' noise in all"
    return proposed.said() if proposed else none


def _name(key: str) -> str:
    return key.partition(":")[0]


def _named(key: str, machine: Machine) -> dict[str, Any]:
    """Return an effect's name, and its channel, driver or place if it has one."""
    name, _, channel = key.partition(":")
    if name not in catalogue():
        return {"name": name, "place": place_of(key)}
    driver = driver_of(machine, key)[0]
    if driver:
        return {"name": name, "driver": driver}
    return {"name": name, "channel": channel} if channel else {"name": name}


def _place(table: dict[str, Any]) -> dict[str, Any]:
    table.pop("tolerances")
    return table


def _effect(selection: SelectionRound, found: GapResult) -> dict[str, Any]:
    key = selection.best.added[-1]
    prefix = f"effects.{key}."
    machine = found.after.machine
    entry: dict[str, Any] = {**_named(key, machine), "title": catalogue()[_name(key)].title}
    if "driver" in entry:
        same = [one for one in selection.one_of if law_of(one) == law_of(key) and one != key]
        words = [driver_of(machine, one) for one in (key, *same)]
        entry["driver_in_words"] = " or ".join(said for _, said in words)
        entry["other_drivers"] = [driver for driver, _ in words[1:]]
    since = [one.run.name for one in selection.best.observed if key not in one.absent]
    if len(since) < len(selection.best.observed):
        entry["runs"] = since
    entry["parameters"] = {
        one.name.removeprefix(prefix): {
            "value": one.value,
            "low": one.low,
            "high": one.high,
            "unit": one.unit,
        }
        for one in found.after.calibration.parameters
        if one.name.startswith(prefix)
    }
    if is_switched(machine, key):
        numbers = machine.effects[key]
        entry["switched_at"] = {
            name: {"value": numbers[name].value, "unit": numbers[name].unit}
            for name in catalogue()[_name(key)].switched
        }
    entry["larger_than_usual"] = list(beyond_usual_range(machine, key))
    place = next(i for i, one in enumerate(selection.fits) if one is selection.best)
    entry["probability"] = sum(
        p
        for i, (one, p) in enumerate(zip(selection.fits, selection.probability, strict=True))
        if i == place or ("driver" in entry and law_of(one.added[-1]) == law_of(key))
    )
    entry["evidence"] = _evidence(selection)
    return entry


def _evidence(selection: SelectionRound, channel: str = "") -> str:
    what = f"of {channel} " if channel else ""
    return (
        f"explains {selection.explained_share:.0%} of what is left {what}on runs predicted from "
        f"the others; "
        f"chance explains {selection.null_q99:.0%} or less in 99 of 100 cases"
    )


def _one_of(found: GapResult) -> tuple[str, ...]:
    """Return the keys that the data cannot tell apart, the best first."""
    told = [found.rounds[0].one_of, *(one.selection.one_of for one in found.changes if one.or_else)]
    return next((keys for keys in told if keys), ())


def proposed_run(found: GapResult) -> FurtherRun | None:
    """Return the further run that would tell apart what the data cannot; None if there is none.

    None also where one explanation stands alone.
    """
    keys = _one_of(found)
    if len(keys) < 2:
        return None
    selection = next(
        one
        for one in (*found.rounds, *(change.selection for change in found.changes))
        if one.one_of == keys
    )
    fits = [next(one for one in selection.fits if one.added[-1] == key) for key in keys]
    return further_run(fits, found.observed)
