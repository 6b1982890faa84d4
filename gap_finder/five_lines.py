"""The gap finder's answer in five lines for a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gap_finder.reference import START

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

IN_DOUBT = (
    "In doubt: the model with it still leaves more than its tolerance, so something else is "
    "missing too, or this only stands for it."
)


def five_lines(table: dict[str, Any]) -> list[str]:
    """Return what a machine engineer wants to know, in five lines.

    Parameters
    ----------
    table : dict
        The content of ``gap.json``.
    """
    where = table["where"]
    worst = "residuals are within tolerance"
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
            + (f", driven by {entry['driver_in_words']}" if "driver" in entry else "")
            + _place_in_words(entry)
            + (f" from {entry['runs'][0]} on" if "runs" in entry else "")
            + (", larger than usual" if entry["larger_than_usual"] else "")
            for entry in table["effects"]
        )
        sure = table["effects"][0]
        lines.append(
            f"What {'may be' if table['in_doubt'] else 'is'} missing: {titles}; {sure['evidence']}."
            + (" " + IN_DOUBT) * table["in_doubt"]
            + (f" Something else remains: {_left(table)}." * _remains(table))
        )
    elif table["verdict"] == "unknown":
        left = _left(table)
        lines.append(
            "What is missing: something that no effect of the catalogue explains"
            + _best(table["runners_up"], evidence["share_explained"])
            + f" {left[:1].upper()}{left[1:]}."
        )
    else:
        lines.append(f"What is missing: nothing that these runs prove{_hint(table)}.")
    alike = (
        " Something that no catalogue holds may act alike: check it on the machine."
        if table["effects"]
        else ""
    )
    if len(table["one_of_keys"]) > 1:
        others = ", ".join(table["one_of_keys"][1:])
        run = " (next_run.toml)" if table["next_run"] else ""
        lines.append(f"Rivals: {others}. To tell: {table['separate_by']}{run}.{alike}")
    else:
        rivals = ", ".join(
            f"{one['name']}{' on ' + one['channel'] if 'channel' in one else ''}"
            f"{' by ' + one['driver'] if 'driver' in one else ''}"
            f" ({one['probability']:.0%})"
            for one in table["runners_up"][:2]
        )
        lines.append(f"Rivals: none; next best: {rivals or 'none'}.{alike}")
    added = "; ".join(
        f"{entry['name']}: "
        + ", ".join(
            f"{name} = {p['value']:.3g} ({p['low']:.3g} to {p['high']:.3g}) {p['unit']}"
            for name, p in entry["parameters"].items()
        )
        + "".join(
            f", {name} = {p['value']:.3g} {p['unit']}"
            for name, p in entry.get("switched_at", {}).items()
        )
        for entry in table["effects"]
    )
    lines.append(f"Added: {added or 'nothing; the machine is calibrated'} -> {table['machine']}.")
    gap = table["gap"]["holdout"]
    both = table.get("cosimulation")
    fmu = f" The plant FMU: {both['before']:.2f}, then {both['after']:.2f}." if both else ""
    if both and not both["agrees"]:
        fmu += " It differs from the simulation by more than allowed: see the report."
    lines.append(
        f"Gap on the held-out run: {gap['before']:.2f} before, {gap['after']:.2f} after, in "
        f"units of sensor noise; a regression on the inputs leaves {gap['reference']:.2f}, noise "
        f"alone {gap['floor']:.2f}.{_taken_back(table)}{fmu}"
    )
    assert all(np.isfinite([gap["before"], gap["after"]]))
    return lines


def _remains(table: Mapping[str, Any]) -> bool:
    """Tell whether more is missing than what was named.

    A change that is about one part leaves all that other parts are wrong by.
    """
    remaining = table["remaining"]
    local = any(entry.get("shows_in") for entry in table["effects"])
    return bool(remaining["is_reducible"] or (local and remaining["above_tolerance"]))


def _place_in_words(entry: Mapping[str, Any]) -> str:
    """Return where the description was changed, if it was."""
    if "place" not in entry:
        return ""
    at = f" at {entry['starts_at']}" if "starts_at" in entry else ""
    others = [" and ".join(place) for place in entry["other_places"]]
    others += [f"{one['name']} {' and '.join(one['place'])}" for one in entry["or_else"]]
    more = f", or {' or '.join(others)}" if others else ""
    return f" ({' and '.join(entry['place'])}{at}{more})"


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
        one["name"]
        + (f" on {one['channel']}" if "channel" in one else "")
        + (f" by {one['driver']}" if "driver" in one else "")
        + (f" ({' and '.join(one['place'])})" if "place" in one else "")
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


def _hint(table: Mapping[str, Any]) -> str:
    """Return in words how little is left, and what explains more of it than chance would."""
    within = "; residuals are within tolerance, all channels together"
    share, chance = (table["evidence"][key] for key in ("share_explained", "share_by_chance"))
    if not table["runners_up"] or share <= chance or table["withdrawn"]:
        return within
    best = table["runners_up"][0]["name"]
    return (
        f"{within}. {best} explains {share:.0%} of them, chance up to {chance:.0%}: too little is"
        " left to be sure"
    )


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
