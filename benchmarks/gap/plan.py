"""Which effects are hidden in which case: a fixed order that mixes all kinds at any length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.gap.truth.case import Case
from benchmarks.gap.truth.effects import OUTSIDE, catalogue
from benchmarks.gap.truth.effects.base import SIZES

SPLITS = {"development": 1_000_000, "reported": 2_000_000}
"""First seed of each split; no machine, run or disturbance is in both."""
KINDS = ("none", "effect", "outside", "pair")
NONE_SHARE, PAIRS = 25, 25


@dataclass(frozen=True)
class Planned:
    """A case and what kind it is."""

    number: int
    kind: str
    case: Case


def plan(
    split: str,
    count: int,
    *,
    kind: str | None = None,
    effect: str | None = None,
    size: str | None = None,
) -> list[Planned]:
    """Return the first *count* cases of a split, of all kinds or only those asked for.

    A case keeps its number and its content whatever is asked for.
    """
    found: list[Planned] = []
    number = 0
    while len(found) < count:
        block, place = divmod(number, len(_block(split, 0)))
        one_kind, hidden = _block(split, block)[place]
        names = [name for name, _, _ in hidden]
        sizes = [one for _, one, _ in hidden]
        wanted = (
            (kind is None or kind == one_kind)
            and (effect is None or effect in names)
            and (size is None or size in sizes)
        )
        if wanted:
            case = Case(SPLITS[split] + number, hidden)
            found.append(Planned(number, one_kind, case))
        number += 1
        if number > 1000 and not found:
            raise ValueError("no case is of that kind")
    return found


Entry = tuple[str, tuple[tuple[str, str, str], ...]]


def _block(split: str, block: int) -> list[Entry]:
    """Return one block of the plan: every effect in every size, and the rest, shuffled."""
    rng = np.random.default_rng([SPLITS[split], 7, block])
    entries: list[Entry] = [
        ("effect", ((name, size, ""),)) for name in catalogue() for size in SIZES
    ]
    entries += [("none", ())] * NONE_SHARE
    entries += [("outside", ((name, size, ""),)) for name in OUTSIDE for size in SIZES]
    names = sorted(catalogue())
    for _ in range(PAIRS):
        first, second = rng.choice(len(names), 2, replace=False)
        sizes = rng.choice(SIZES[1:], 2)
        pair = ((names[first], str(sizes[0]), ""), (names[second], str(sizes[1]), ""))
        entries.append(("pair", pair))
    rng.shuffle(entries)  # type: ignore[arg-type]
    return entries
