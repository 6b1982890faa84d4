"""Right or wrong: an answer of the gap finder, or of another method, against what is hidden."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any

from benchmarks.gap.descriptions import PLACE, SILENT, named_in, outcome_of, says

RIGHT, ONE_OF, MORE, WRONG = "right", "one of", "right and another", "wrong"
BROKEN, UNKNOWN, NONE = "left out as broken", "unknown", "none"
OUTCOMES = (RIGHT, ONE_OF, MORE, BROKEN, UNKNOWN, NONE, WRONG)
"""What can be said where one effect of the catalogue is missing."""

NAMED, SAME = "named", "in other words"
OPEN_OUTCOMES = (UNKNOWN, NONE, SAME, NAMED)
"""What can be said where nothing of the catalogue is missing; naming an effect is false. The third
is a change of the description that says the same as what is hidden: a heap of chips is a heat
source of the bed."""

BOTH, FIRST = "both", "one of the two"
PAIR_OUTCOMES = (BOTH, FIRST, MORE, UNKNOWN, NONE, WRONG)
"""What can be said of a pair; the third is one or both of them and a wrong name."""

MISTAKE_OUTCOMES = (RIGHT, ONE_OF, PLACE, UNKNOWN, NONE, WRONG)
"""What can be said where the machine's file has a mistake."""

HOLDING = (RIGHT, ONE_OF, BOTH, FIRST, SAME)
FALSE = (WRONG, MORE, NAMED, PLACE)
"""Outcomes of an answer that names something: nothing in it is false, or something is."""

SAYING_NOTHING = {"none_missing": NONE, "unknown": UNKNOWN}

ONE_EFFECT = ("effect", "beyond")
"""Kinds of questions in which one effect of the catalogue is missing."""

Group = tuple[str, ...]
"""One named effect as ``name``, ``name:channel`` or ``name:place``, or several, any of them."""


def groups_of(answer: dict[str, Any], mistakes: Sequence[dict[str, Any]] = ()) -> list[Group]:
    """Return what the content of ``gap.json`` names: a group for each effect that was added.

    Mistakes that the machine's file has are no part of it: naming them besides is neither asked
    for nor wrong.
    """
    groups = []
    for number, effect in enumerate(answer["effects"]):
        if any(says(effect, mistake) for mistake in mistakes):
            continue
        where = effect.get("channel") or "+".join(effect.get("place", ()))
        key = ":".join(filter(None, (effect["name"], where)))
        first = answer.get("one_of_keys", answer["one_of"]) if number == 0 else []
        rivals = effect.get("one_of", first)
        groups.append((key, *(other for other in rivals if not _is(other, key, effect["name"]))))
    return groups


def _is(other: str, key: str, name: str) -> bool:
    """Return whether another key is what was named, or the same effect by another driver."""
    return other in (key, name) or (key == name and other.partition(":")[0] == name)


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
        told = kind in ONE_EFFECT and truth[0]["channel"] in broken
        if told:
            return BROKEN
        # With a mistake of the file named and nothing else, nothing is said of what is hidden.
        return SAYING_NOTHING.get(verdict, NONE)
    if kind == "pair":
        return _of_pair(truth, groups)
    if kind not in ONE_EFFECT:
        return SAME if _in_other_words(truth, groups) else NAMED
    (effect,) = truth
    hits = [holds(group, effect) for group in groups]
    if not any(hits):
        return WRONG
    if not all(hits):
        return MORE
    return RIGHT if all(len(group) == 1 for group in groups) else ONE_OF


def outcome_of_mistake(mistake: dict[str, Any], answer: dict[str, Any]) -> str:
    """Return one of `MISTAKE_OUTCOMES`."""
    told = outcome_of(
        (mistake["kind"], mistake["place"]), *named_in(answer), verdict=answer["verdict"]
    )
    return SAYING_NOTHING[answer["verdict"]] if told == SILENT else told


def _in_other_words(truth: Sequence[dict[str, Any]], groups: list[Group]) -> bool:
    """Tell whether each group holds a change of the description that says what is hidden."""
    known = [one for effect in truth for one in effect.get("in_other_words", ())]
    return all(any(_says_so(key, one) for key in group for one in known) for group in groups)


def _says_so(key: str, change: dict[str, Any]) -> bool:
    name, _, where = key.partition(":")
    place, said = where.split("+"), change["place"]
    of_same_parts = {one for one in said if one != "*"} <= set(place)
    return name == change["kind"] and len(place) == len(said) and of_same_parts


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
