"""The gap finder's answer in five readable lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gap_finder.advice import unit_after
from gap_finder.priors import FAR
from gap_finder.reference import LAGS_MIN, LEAST_PREDICTED, START
from gap_finder.report import MACHINE_BEFORE

KINDS = {
    "level_jump": "wrong level",
    "never_right": "wrong level",
    "runaway": "runs away",
    "saturated": "at the end of its range",
    "step": "slipped",
    "one_run": "wrong in one run only",
    "probe_step": "slipped, zeroed again",
    "spikes": "jumping",
    "jump": "another recording appended",
}
"""Kinds of data faults in words, if the kind is not a plain word itself."""


def five_lines(table: dict[str, Any]) -> list[str]:
    """Return the answer for a machine engineer, in five lines.

    Parameters
    ----------
    table : dict
        The content of ``gap.json``.
    """
    worst_of: dict[str, dict[str, Any]] = {}
    for place in table["where"]:
        worst_of.setdefault(place["channel"], place)
    worst = "; ".join(
        f"{p['channel']} {p['regime']} ({p['run']}, {p['rms']:.2g} {p['unit']})"
        for p in list(worst_of.values())[:3]
    )
    gap = table["gap"]["holdout"]
    assert all(np.isfinite([gap["before"], gap["after"]]))
    return [
        _what(table),
        f"Where the model {'was' if table['effects'] else 'is'} wrong: "
        f"{worst or 'residuals are within tolerance'}."
        f"{_left_out(table['data_faults'])}",
        _rivals(table),
        f"Added: {_added(table) or 'nothing; the machine is calibrated'} -> {table['machine']}.",
        f"Gap on the held-out run: {gap['before']:.2f} before, {gap['after']:.2f} after, in "
        f"units of sensor noise; for comparison: regression on the inputs {gap['reference']:.2f}, "
        f"noise alone {gap['floor']:.2f}.{_worse(table)}",
    ]


def _what(table: Mapping[str, Any]) -> str:
    """Return what is missing; if that is in doubt, also what it may be instead."""
    look = f" Check: {table['look_at'][0]}." if table["look_at"] else ""
    off = table["remaining"]["numbers_off"]
    if off >= FAR:
        look = f" The file's numbers are off by {off:.1f} deviations on average.{look}"
    left = _left(table)
    if table["effects"]:
        names = "; and ".join(map(_title, table["effects"]))
        evidence = table["effects"][0]["evidence"]
        if not table["in_doubt"]:
            return f"What is missing: {names}; {evidence}."
        named = _rivals_named(table)
        others = [said for said in map(_in_words, table["runners_up"]) if said not in named][:2]
        instead = f"{', '.join(others)}, or " if others else ""
        return (
            f"What may be missing: {names}. In doubt: {table['evidence']['doubt']}, so the cause "
            f"may instead, or also, be {instead}something not in the catalogue; {left}. "
            f"{evidence[:1].upper()}{evidence[1:]}.{look}"
        )
    if table["verdict"] == "unknown":
        best = table["runners_up"][:1]
        closest = f"; the closest is {_in_words(best[0])}" if best else ""
        return (
            f"Nothing is named: error remains, but nothing on the list explains it{closest}."
            f"{look} {left[:1].upper()}{left[1:]}."
        )
    return f"What is missing: nothing that these runs show; residuals are within tolerance.{look}"


def _title(entry: Mapping[str, Any]) -> str:
    return (
        str(entry["title"])
        + (f" on {entry['channel']}" if "channel" in entry else "")
        + (f", driven by {entry['driver_in_words']}" if "driver" in entry else "")
        + _place_in_words(entry)
        + (f" from {entry['runs'][0]} on" if "runs" in entry else "")
        + "".join(f", with unusual {name}" for name in entry["larger_than_usual"])
        + "".join(f", or {_in_words(other)}" for other in _others(entry))
    )


def _others(entry: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the rivals that are more than another driver or place, which the title tells."""
    rivals: list[Mapping[str, Any]] = entry["rivals"]
    return [other for other in rivals if "channel" in entry or other["name"] != entry["name"]]


def _rivals_named(table: Mapping[str, Any]) -> list[str]:
    """Return the rivals of all that is named, in words, each once."""
    rivals = (_in_words(other) for entry in table["effects"] for other in entry["rivals"])
    return list(dict.fromkeys(rivals))


def _in_words(entry: Mapping[str, Any]) -> str:
    """Return a rival or runner-up in words."""
    place = f" ({' and '.join(entry['place'])})" if "place" in entry else ""
    channel = f" on {entry['channel']}" if "channel" in entry else ""
    driver = f" by {entry['driver']}" if "driver" in entry else ""
    return f"{entry['name']}{channel}{driver}{place}"


def _rivals(table: Mapping[str, Any]) -> str:
    others = _rivals_named(table)
    if others:
        return f"Rivals: {', '.join(others)}. To tell: {table['separate_by']}."
    best = table["runners_up"][:2]
    if table["in_doubt"] or table["verdict"] == "unknown":
        # Odds are those among the list, from which the truth may be missing.
        said = ", ".join(map(_in_words, best))
    else:
        said = ", ".join(f"{_in_words(entry)} ({entry['probability']:.0%})" for entry in best)
    return f"Rivals: none; next best: {said or 'none'}."


def _added(table: Mapping[str, Any]) -> str:
    return "; ".join(
        f"{entry['name']}: "
        + ", ".join(
            f"{name} = {p['value']:.3g} ({p['low']:.3g} to {p['high']:.3g}){unit_after(p['unit'])}"
            for name, p in entry["parameters"].items()
        )
        + "".join(
            f", {name} = {p['value']:.3g}{unit_after(p['unit'])}"
            for name, p in entry.get("set_at", {}).items()
        )
        + _start(entry.get("behind_at_start_K", {}))
        for entry in table["effects"]
    )


def _start(behind: Mapping[str, float]) -> str:
    """Return in words in which run a law started farthest from where it settles."""
    if not behind:
        return ""
    run, most = max(behind.items(), key=lambda pair: abs(pair[1]))
    return f", at most {abs(most):.2g} K {'behind' if most > 0.0 else 'ahead'} at a start ({run})"


def _worse(table: Mapping[str, Any]) -> str:
    """Return in words which channels got worse on the held-out run by more than their noise."""
    worse = [
        f"{name} ({channel['before']:.3g} -> {channel['after']:.3g} {channel['unit']})"
        for name, channel in table["channels"].items()
        if channel["after"] > channel["before"] + channel["noise"]
    ]
    said = f" Worse with it: {', '.join(worse)}." if worse else ""
    gap = table["gap"]["holdout"]
    if gap["after"] > gap["before"]:
        said += f" It is predicted worse than before: keep {MACHINE_BEFORE}."
    return said


def _place_in_words(entry: Mapping[str, Any]) -> str:
    """Return where the description was changed; empty if it was not."""
    if "place" not in entry:
        return ""
    at = f" at {entry['starts_at']}" if "starts_at" in entry else ""
    others = [" and ".join(place) for place in entry["other_places"]]
    more = f", or {' or '.join(others)}" if others else ""
    return f" ({' and '.join(entry['place'])}{at}{more})"


def _left(table: Mapping[str, Any]) -> str:
    """Return in words where the remaining error can be predicted, and from what."""
    remaining = table["remaining"]
    if not remaining["where"] or remaining["share"] < LEAST_PREDICTED:
        return "no input explains any of the remaining error in the same way in every run"
    where = "; ".join(f"{p['channel']} {p['regime']}" for p in remaining["where"][:2])
    by = " and ".join(map(_source, remaining["predicted_by"][:2]))
    share = f"{remaining['share']:.0%} of the remaining error can be predicted from the inputs"
    return f"{share}{f', by {by}' if by else ''}, mostly in {where}"


def _source(source: Mapping[str, Any]) -> str:
    if source["input"] == START:
        return "how warm the machine started"
    if source["lag_min"] == LAGS_MIN[-1]:
        return f"{source['input']} added up since the start"  # longer than most runs
    return f"{source['input']} with a lag of {source['lag_min']:.0f} min"


def _left_out(faults: Sequence[Mapping[str, Any]]) -> str:
    """Return in words what was left out as broken, each channel and kind once."""
    runs: dict[tuple[str, str], list[str]] = {}
    for fault in faults:
        names = runs.setdefault((fault["channel"], fault["kind"]), [])
        if fault["run"] not in names:
            names.append(fault["run"])
    parts = [
        f"{channel} ({KINDS.get(kind, kind)} in {', '.join(names) if len(names) < 4 else names[0]}"
        + (f" and {len(names) - 1} more" if len(names) >= 4 else "")
        + ")"
        for (channel, kind), names in runs.items()
    ]
    return f" Left out as broken: {'; '.join(parts)}." if parts else ""
