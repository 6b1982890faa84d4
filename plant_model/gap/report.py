"""The gap finder's answer as data: what ``gap.json`` holds, and five lines for a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from plant_model.effects import catalogue
from plant_model.gap.candidates import larger
from plant_model.gap.data_faults import DataFault
from plant_model.gap.description import place_of
from plant_model.gap.find import Found
from plant_model.gap.further_run import further_run
from plant_model.gap.judge import Judged
from plant_model.gap.observations import Observations
from plant_model.gap.periods import in_step
from plant_model.gap.reference import LEFT, START, Reference
from plant_model.gap.regimes import (
    Residuals,
    by_channel,
    floor_of,
    gap_of,
    noise_of,
    places,
    residuals,
)
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

MACHINE_AFTER = "machine_after.toml"

KINDS = {
    "level_jump": "wrong level",
    "never_right": "wrong level",
    "runaway": "runs away",
    "saturated": "at the end of its range",
    "step": "slipped",
    "one_run": "wrong in one run alone",
    "probe_step": "slipped, its zero taken anew",
    "spikes": "jumping",
    "jump": "another recording joined on",
}
"""Kinds of data faults in words, where the kind itself is none."""


class Comparison:
    """Residuals of the machine before and after, on some runs.

    Parameters
    ----------
    before, after : Machine
    observed : sequence of Observations
    """

    def __init__(self, before: Machine, after: Machine, observed: Sequence[Observations]) -> None:
        self.machine = before
        self.before: list[Residuals] = [residuals(before, one) for one in observed]
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

    def gap_beside(self, reference: Sequence[FloatArray]) -> dict[str, float]:
        """Return the gap with what the reference leaves, (K, C) of each run, and the rest of it."""
        table = self.gap()
        least = gap_of(self.machine, self._with(reference))
        return table | {"reference": least, "reducible": max(table["after"] - least, 0.0)}

    def _with(self, values: Sequence[FloatArray]) -> list[Residuals]:
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
        """Return the channels with what the reference leaves of each, and the rest of it."""
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
    found: Found,
    unseen: Comparison,
    faults: Sequence[DataFault] = (),
    cosimulation: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the content of ``gap.json``.

    Parameters
    ----------
    found : Found
    unseen : Comparison
        On the runs that were not used; the channels' table is of these.
    faults : sequence of DataFault
        What was left out of the runs beforehand.
    cosimulation : mapping, optional
        The gap of the plant FMUs on the runs that were not used.
    """
    before, after = found.before.machine, found.after.machine
    calibration = Comparison(before, after, found.observed)
    reference = Reference(after, calibration.after, unseen.after)
    at_first = Reference(before, calibration.before)
    first = found.rounds[0]
    table = {
        "verdict": found.verdict,
        "effects": [
            *(
                one.entry(found.after) | {"evidence": _evidence(one.judged)}
                for one in found.described
            ),
            *(_effect(judged, found) for judged in found.rounds if judged.named),
        ],
        "one_of": list(dict.fromkeys(_name(key) for key in first.one_of)),
        "one_of_keys": list(first.one_of),
        "separate_by": _separate(first, found),
        "runners_up": [
            {**_named(one.added[-1]), "probability": p, "beyond_its_range": list(one.beyond)}
            for one, p in zip(first.tried, first.probability, strict=True)
            if not first.named or one is not first.best
        ],
        "where": [_place(asdict(place)) for place in places(before, calibration.before)],
        "gap": {
            "calibration": calibration.gap_beside(reference.known),
            "holdout": unseen.gap_beside(reference.unseen),
        },
        "channels": _channels(unseen, reference),
        "remaining": _remaining(at_first, reference),
        "withdrawn": [_named(one.key) | {"runs": list(one.runs)} for one in found.withdrawn],
        "machine": MACHINE_AFTER,
        "data_faults": [asdict(fault) for fault in faults],
        "evidence": {
            "share_explained": first.share,
            "share_by_chance": first.chance,
            "cost_per_run_and_channel": float(
                first.now.unseen.sum() / (len(found.observed) * len(found.observed[0].channels))
            ),
        },
    }
    return table if cosimulation is None else table | {"cosimulation": dict(cosimulation)}


def _channels(unseen: Comparison, reference: Reference) -> dict[str, dict[str, Any]]:
    """Return the channels' table, with what predicts most of what is left of each."""
    table = unseen.channels_beside(reference.unseen)
    for name, entry in table.items():
        entry["predicted_by"] = [asdict(one) for one in reference.sources_of(name)]
    return table


def _remaining(before: Reference, reference: Reference) -> dict[str, Any]:
    """Return what of the runs used can still be explained: whether, how much, where, by what."""
    return {
        "is_reducible": reference.is_left,
        "squared_tolerances": reference.reducible,
        "before": before.reducible,
        "share": reference.share,
        "limit": LEFT,
        "where": [asdict(place) for place in reference.places()],
        "predicted_by": [asdict(one) for one in reference.sources()],
    }


def _name(key: str) -> str:
    return key.partition(":")[0]


def _named(key: str) -> dict[str, Any]:
    """Return an effect's name, and its channel or place if it has one."""
    name, _, channel = key.partition(":")
    if name not in catalogue():
        return {"name": name, "place": place_of(key)}
    return {"name": name, "channel": channel} if channel else {"name": name}


def _place(table: dict[str, Any]) -> dict[str, Any]:
    table.pop("tolerances")
    return table


def _effect(judged: Judged, found: Found) -> dict[str, Any]:
    key = judged.best.added[-1]
    prefix = f"effects.{key}."
    entry: dict[str, Any] = {**_named(key), "title": catalogue()[_name(key)].title}
    since = [one.run.name for one in judged.best.observed if key not in one.absent]
    if len(since) < len(judged.best.observed):
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
    entry["larger_than_usual"] = list(larger(found.after.machine, key))
    place = next(i for i, one in enumerate(judged.tried) if one is judged.best)
    entry["probability"] = judged.probability[place]
    entry["evidence"] = _evidence(judged)
    return entry


def _evidence(judged: Judged) -> str:
    return (
        f"explains {judged.share:.0%} of what is left on runs predicted from the others; "
        f"chance explains {judged.chance:.0%} or less in 99 of 100 cases"
    )


def _separate(first: Judged, found: Found) -> str:
    """Return the further run that would tell the two best explanations apart."""
    if len(first.one_of) < 2:
        return ""
    rival = next(one for one in first.tried if one.added[-1] == first.one_of[1])
    return further_run(first.best.machine, rival.machine, list(found.observed))


def five_lines(table: dict[str, Any]) -> list[str]:
    """Return what a machine engineer wants to know, in five lines."""
    where = table["where"]
    worst = "nowhere by more than the tolerance"
    if where:
        worst = "; ".join(
            f"{p['channel']} {p['regime']} ({p['run']}, {p['rms']:.2g} {p['unit']})"
            for p in where[:3]
        )
    evidence = table["evidence"]
    lines = [f"Where the model is wrong: {worst}.{_left_out(table['data_faults'])}"]
    if table["effects"]:
        titles = " and ".join(
            entry["title"]
            + (f" on {entry['channel']}" if "channel" in entry else "")
            + _place_in_words(entry)
            + (f" from {entry['runs'][0]} on" if "runs" in entry else "")
            + (", larger than usual" if entry["larger_than_usual"] else "")
            for entry in table["effects"]
        )
        sure = table["effects"][0]
        lines.append(
            f"What is missing: {titles}; {sure['evidence']}."
            + (f" Something else remains: {_left(table)}." * table["remaining"]["is_reducible"])
        )
    elif table["verdict"] == "unknown":
        lines.append(
            "What is missing: something that no effect of the catalogue explains"
            + _best(table["runners_up"], evidence["share_explained"])
            + f" {_left(table).capitalize()}."
        )
    else:
        lines.append("What is missing: nothing; what is left is within the tolerance.")
    if len(table["one_of_keys"]) > 1:
        others = ", ".join(table["one_of_keys"][1:])
        lines.append(f"Rivals: {others}. To tell: {table['separate_by']}.")
    else:
        rivals = ", ".join(
            f"{one['name']}{' on ' + one['channel'] if 'channel' in one else ''}"
            f" ({one['probability']:.0%})"
            for one in table["runners_up"][:2]
        )
        lines.append(f"Rivals: none that the data leaves open; next were {rivals or 'none'}.")
    added = "; ".join(
        f"{entry['name']}: "
        + ", ".join(
            f"{name} = {p['value']:.3g} ({p['low']:.3g} to {p['high']:.3g}) {p['unit']}"
            for name, p in entry["parameters"].items()
        )
        for entry in table["effects"]
    )
    lines.append(f"Added: {added or 'nothing; the machine is calibrated'} -> {table['machine']}.")
    gap = table["gap"]["holdout"]
    both = table.get("cosimulation")
    fmu = f" The plant FMU: {both['before']:.2f}, then {both['after']:.2f}." if both else ""
    if both and not both["agrees"]:
        fmu += " It is further from the simulation in one process than it may be: see the report."
    lines.append(
        f"Gap on the run never used: {gap['before']:.2f} before, {gap['after']:.2f} after, in "
        f"units of sensor noise; a regression on the inputs leaves {gap['reference']:.2f}, noise "
        f"alone {gap['floor']:.2f}.{_taken_back(table)}{fmu}"
    )
    assert all(np.isfinite([gap["before"], gap["after"]]))
    return lines


def _place_in_words(entry: Mapping[str, Any]) -> str:
    """Return where the description was changed, if it was."""
    if "place" not in entry:
        return ""
    at = f" at {entry['starts_at']}" if "starts_at" in entry else ""
    others = " or ".join(" and ".join(place) for place in entry["other_places"])
    return f" ({' and '.join(entry['place'])}{at}{f', or {others}' if others else ''})"


def _left(table: Mapping[str, Any]) -> str:
    """Return in words where something can still be explained, and what predicts it."""
    remaining = table["remaining"]
    if not remaining["where"] or remaining["share"] < 0.1:
        return "none of it follows from the inputs in the same way in every run"
    where = "; ".join(f"{p['channel']} {p['regime']}" for p in remaining["where"][:2])
    by = " or ".join(_source(one) for one in remaining["predicted_by"][:2])
    share = f"{remaining['share']:.0%} of it can be predicted from the inputs"
    return f"{share}{f', by {by}' if by else ''}, most in {where}"


def _source(one: Mapping[str, Any]) -> str:
    name = "how warm the machine started" if one["input"] == START else one["input"]
    return f"{name} with a lag of {one['lag_min']:.0f} min ({one['share']:.0%})"


def _taken_back(table: Mapping[str, Any]) -> str:
    names = ", ".join(
        one["name"] + (f" on {one['channel']}" if "channel" in one else "")
        for one in table["withdrawn"]
    )
    return f" Not added, because this run was worse with it: {names}." if names else ""


def _best(tried: Sequence[Mapping[str, Any]], share: float) -> str:
    """Return in words how far the best effect went that was not named."""
    if not tried:
        return "."
    best = tried[0]
    words = f"; the best of them, {best['name']}, explains {max(share, 0.0):.0%}"
    if best["beyond_its_range"]:
        words += f", and would have to leave its range ({', '.join(best['beyond_its_range'])})"
    return words + "."


def _left_out(faults: Sequence[Mapping[str, Any]]) -> str:
    """Return in words what was left out as broken, each channel once."""
    runs: dict[tuple[str, str], list[str]] = {}
    for fault in faults:
        found = runs.setdefault((fault["channel"], fault["kind"]), [])
        if fault["run"] not in found:
            found.append(fault["run"])
    parts = [
        f"{channel} ({KINDS.get(kind, kind)} in {', '.join(names) if len(names) < 4 else names[0]}"
        + (f" and {len(names) - 1} more" if len(names) >= 4 else "")
        + ")"
        for (channel, kind), names in runs.items()
    ]
    return f" Left out as broken: {'; '.join(parts)}." if parts else ""
