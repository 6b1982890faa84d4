"""Gives runs distinct names, and writes names within sentences."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence


def distinct(names: Sequence[str], folders: Sequence[str]) -> list[str]:
    """Return distinct names: equal ones get their folder's name, or else a number.

    >>> distinct(["log", "log", "day1"], ["mon", "tue", "tue"])
    ['mon_log', 'tue_log', 'day1']
    >>> distinct(["log", "Log"], ["", ""])
    ['log_1', 'Log_2']

    Parameters
    ----------
    names : sequence of str
        Case does not make names distinct, because some disks ignore it.
    folders : sequence of str
        Folder of each; empty if there is none.
    """
    shared = Counter(map(str.casefold, names))
    distinct_names = [
        f"{folder}_{name}" if shared[name.casefold()] > 1 and folder else name
        for folder, name in zip(folders, names, strict=True)
    ]
    shared, given = Counter(map(str.casefold, distinct_names)), Counter[str]()
    for place, name in enumerate(distinct_names):
        if shared[name.casefold()] > 1:
            given[name.casefold()] += 1
            distinct_names[place] = f"{name}_{given[name.casefold()]}"
    return distinct_names


def lowered(text: str) -> str:
    """Return a title as written within a sentence.

    >>> lowered("Tool length 100 mm"), lowered("FMI version")
    ('tool length 100 mm', 'FMI version')

    Parameters
    ----------
    text : str
        May begin with an abbreviation.
    """
    return text if text[1:2].isupper() else text[:1].lower() + text[1:]
