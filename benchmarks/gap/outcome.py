"""Judges an answer of the gap finder against what is hidden, or against a mistake in the file."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

RIGHT, ONE_OF, MORE, WRONG = "right", "one of", "right and another", "wrong"
BROKEN, UNKNOWN, NONE = "left out as broken", "unknown", "none"
"""Outcomes if one effect of the catalogue is missing."""

NAMED, SAME = "named", "in other words"
"""Further outcomes if nothing of the catalogue is missing, so that naming an effect is false. The
second is a change of the description equivalent to what is hidden: a heap of chips is a heat source
of the bed."""

BOTH, FIRST = "both", "one of the two"
"""Further outcomes for a pair; `MORE` is one or both of them and a wrong name."""

PLACE = "right place"
"""Further outcome if the machine's file has a mistake: another kind at one of the same parts."""

HOLDING = (RIGHT, ONE_OF, BOTH, FIRST, SAME)
FALSE = (WRONG, MORE, NAMED, PLACE)
"""Outcomes of an answer that names something: without, and with something false in it."""

SAYING_NOTHING = {"none_missing": NONE, "unknown": UNKNOWN}

ONE_EFFECT = ("effect", "beyond")
"""Kinds of questions in which one effect of the catalogue is missing."""

Group = tuple[str, ...]
"""Alternative names of one effect: ``name``, ``name:channel`` or ``name:place``."""


def groups_of(answer: dict[str, Any], mistakes: Sequence[dict[str, Any]] = ()) -> list[Group]:
    """Return the names in the content of ``gap.json``, a group for each effect that was added.

    Mistakes in the machine's file are left out: also naming them is neither required nor wrong.
    """
    groups = []
    for number, effect in enumerate(answer["effects"]):
        alone = {"effects": [effect], "verdict": "effect"}
        if any(outcome_of_mistake(one, alone) in (RIGHT, ONE_OF) for one in mistakes):
            continue
        where = effect.get("channel") or "+".join(effect.get("place", ()))
        key = ":".join(filter(None, (effect["name"], where)))
        first = answer["one_of"] if number == 0 else []
        rivals = effect.get("one_of", first)
        groups.append((key, *(other for other in rivals if not _is(other, key, effect["name"]))))
    return groups


def _is(other: str, key: str, name: str) -> bool:
    """Whether another key is the named one, or the same effect with another driver."""
    return other in (key, name) or (key == name and other.partition(":")[0] == name)


def holds(group: Group, effect: dict[str, Any]) -> bool:
    """Whether a group contains an effect, on the right channel if it acts on one."""
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
    """Return the outcome of one question about effects.

    Parameters
    ----------
    kind : str
        Of the question.
    truth : sequence of dict
        The hidden effects.
    groups : list of Group
        Named effects.
    verdict : str
        As in ``gap.json``; used if nothing is named.
    broken : collection of str
        Channels reported as broken and left out.
    """
    if not groups:
        if kind in ONE_EFFECT and truth[0]["channel"] in broken:
            return BROKEN
        # If only a mistake of the file is named, the answer says nothing about what is hidden.
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
    """Return the outcome of one question about a mistake in the file: kind and place."""
    named, rivals = named_in(answer)
    if not named:
        return SAYING_NOTHING[answer["verdict"]]
    true = _change(mistake["kind"], mistake["place"])
    told, others = ([_change(*one) for one in part] for part in (named, rivals))
    if told == [true]:
        return ONE_OF if others else RIGHT
    if true in told or true in others:
        return ONE_OF
    return PLACE if any(true[1] & where for _, where in told) else WRONG


def named_in(answer: dict[str, Any]) -> tuple[list[list[Any]], list[list[Any]]]:
    """Return what an answer names, and its alternatives, each with its place."""
    effects = answer["effects"]

    def told(entry: dict[str, Any]) -> list[Any]:
        return [entry["name"], entry.get("place", entry.get("channel"))]

    rivals = [told(other) for entry in effects for other in entry.get("or_else", [])]
    rivals += [
        [entry["name"], place] for entry in effects for place in entry.get("other_places", [])
    ]
    return [told(entry) for entry in effects], rivals


def _change(name: str, place: Sequence[str] | str | None) -> tuple[str, frozenset[str]]:
    """Return a change for comparison: a path has no direction, and a channel is not a place."""
    return name, frozenset(() if place is None or isinstance(place, str) else place)


def _in_other_words(truth: Sequence[dict[str, Any]], groups: list[Group]) -> bool:
    """Whether each group contains a change of the description equivalent to what is hidden."""
    same = [words for effect in truth for words in effect.get("in_other_words", ())]
    return all(any(_says_so(key, words) for key in group for words in same) for group in groups)


def _says_so(key: str, change: dict[str, Any]) -> bool:
    name, _, where = key.partition(":")
    place, said = where.split("+"), change["place"]
    of_same_parts = {part for part in said if part != "*"} <= set(place)
    return name == change["kind"] and len(place) == len(said) and of_same_parts


def _of_pair(truth: Sequence[dict[str, Any]], groups: list[Group]) -> str:
    hits = sum(any(holds(group, effect) for group in groups) for effect in truth)
    if not hits:
        return WRONG
    if not all(any(holds(group, effect) for effect in truth) for group in groups):
        return MORE
    return BOTH if hits == len(truth) else FIRST
