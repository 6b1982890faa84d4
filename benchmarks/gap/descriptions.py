"""Right or wrong, where what is missing is a mistake of the machine's description."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

RIGHT, ONE_OF, PLACE, SILENT, WRONG = "right", "one of", "right place", "silent", "wrong"

Named = list[Any]
"""A kind of change and its place, or an effect and its channel."""


def named_in(answer: dict[str, Any]) -> tuple[list[Named], list[Named]]:
    """Return what the content of ``gap.json`` names, and what it says may as well be."""
    effects = answer["effects"]

    def told(one: dict[str, Any]) -> Named:
        return [one["name"], one.get("place", one.get("channel"))]

    named = [told(one) for one in effects]
    rivals = [told(one) for entry in effects for one in entry.get("or_else", [])]
    rivals += [
        [entry["name"], place] for entry in effects for place in entry.get("other_places", [])
    ]
    return named, rivals


def outcome_of(
    mistake: tuple[str, Sequence[str]], named: list[Named], rivals: list[Named], verdict: str
) -> str:
    """Return ``right``, ``one of``, ``right place``, ``silent`` or ``wrong``.

    ``right place`` is another kind at one of the same parts.
    """
    kind, place = mistake
    if not named:
        return RIGHT if kind == "nothing" and verdict == "none_missing" else SILENT
    # A path has no direction.
    true = (kind, frozenset(place))
    told, others = ([_unordered(*one) for one in part] for part in (named, rivals))
    if told == [true]:
        return ONE_OF if others else RIGHT
    if true in told or true in others:
        return ONE_OF
    return PLACE if any(true[1] & where for _, where in told) else WRONG


def says(effect: dict[str, Any], mistake: dict[str, Any]) -> bool:
    """Return whether an entry of ``effects`` names a mistake, alone or among others."""
    named, rivals = named_in({"effects": [effect]})
    told = outcome_of((mistake["kind"], mistake["place"]), named, rivals, "effect")
    return told in (RIGHT, ONE_OF)


def _unordered(name: str, place: list[str] | str | None) -> tuple[str, frozenset[str]]:
    return name, frozenset(place if isinstance(place, list) else [])
