"""Right or wrong: an answer of the gap finder, or of another method, against what is hidden."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any

RIGHT, ONE_OF, MORE, WRONG = "right", "one of", "right and another", "wrong"
BROKEN, UNKNOWN, NONE = "left out as broken", "unknown", "none"
OUTCOMES = (RIGHT, ONE_OF, MORE, BROKEN, UNKNOWN, NONE, WRONG)
"""What can be said where one effect of the catalogue is missing."""

NAMED = "named"
OPEN_OUTCOMES = (UNKNOWN, NONE, NAMED)
"""What can be said where nothing of the catalogue is missing; naming an effect is false."""

BOTH, FIRST = "both", "one of the two"
PAIR_OUTCOMES = (BOTH, FIRST, MORE, UNKNOWN, NONE, WRONG)
"""What can be said of a pair; the third is one or both of them and a wrong name."""

SILENT = {"none_missing": NONE, "unknown": UNKNOWN}

Group = tuple[str, ...]
"""One named effect as ``name`` or ``name:channel``, or several that cannot be told apart."""


def groups_of(answer: dict[str, Any]) -> list[Group]:
    """Return what the content of ``gap.json`` names: a group for each effect that was added."""
    groups = []
    for number, effect in enumerate(answer["effects"]):
        key = ":".join(filter(None, (effect["name"], effect.get("channel", ""))))
        rivals = (
            answer.get("one_of_keys", answer["one_of"]) if number == 0 else effect.get("one_of", [])
        )
        groups.append((key, *(name for name in rivals if name not in (key, effect["name"]))))
    return groups


def holds(group: Group, effect: dict[str, Any]) -> bool:
    """Return whether a group holds an effect, on its own channel if it acts on one."""
    return any(
        name == effect["name"] and channel in ("", effect["channel"])
        for name, _, channel in (key.partition(":") for key in group)
    )


def outcome(
    kind: str,
    truth: Sequence[dict[str, Any]],
    groups: list[Group],
    verdict: str,
    broken: Collection[str] = (),
) -> str:
    """Return the outcome of one question.

    Parameters
    ----------
    kind : str
        Of the question.
    truth : sequence of dict
        The hidden effects.
    groups : list of Group
        What is named.
    verdict : str
        As in ``gap.json``; matters where nothing is named.
    broken : collection of str
        Channels that were reported as broken and left out before anything was compared.
    """
    if not groups:
        told = kind == "effect" and truth[0]["channel"] in broken
        return BROKEN if told else SILENT[verdict]
    if kind == "pair":
        return _of_pair(truth, groups)
    if kind != "effect":
        return NAMED
    (effect,) = truth
    hits = [holds(group, effect) for group in groups]
    if not any(hits):
        return WRONG
    if not all(hits):
        return MORE
    return RIGHT if all(len(group) == 1 for group in groups) else ONE_OF


def _of_pair(truth: Sequence[dict[str, Any]], groups: list[Group]) -> str:
    found = sum(any(holds(group, effect) for group in groups) for effect in truth)
    false = sum(not any(holds(group, effect) for effect in truth) for group in groups)
    if not found:
        return WRONG
    if false:
        return MORE
    return BOTH if found == len(truth) else FIRST


def tally(outcomes: Sequence[str], of: Sequence[str]) -> dict[str, int]:
    """Return how often each outcome occurs, those that do not included."""
    counted = Counter(outcomes)
    return {name: counted[name] for name in of}
