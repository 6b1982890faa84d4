"""Gives runs distinct names."""

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
    found = [
        f"{folder}_{name}" if shared[name.casefold()] > 1 and folder else name
        for folder, name in zip(folders, names, strict=True)
    ]
    shared, given = Counter(map(str.casefold, found)), Counter[str]()
    for place, name in enumerate(found):
        if shared[name.casefold()] > 1:
            given[name.casefold()] += 1
            found[place] = f"{name}_{given[name.casefold()]}"
    return found
