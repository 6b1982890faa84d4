"""Which effects are hidden in which case: a fixed order that mixes all kinds at any length.

Every simulator (`benchmarks.gap.truths`) has its own plan.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import count as count_up
from itertools import islice

import numpy as np

from benchmarks.gap.case import TruthCase
from benchmarks.gap.hidden import SIZES
from benchmarks.gap.truths import TRUTHS, USUAL

SPLITS = {
    name: 1_000_000 * number
    for number, name in enumerate(
        (
            *("development", "reported", "second", "third", "fourth", "fifth", "sixth", "seventh"),
            *("eighth", "ninth", "tenth", "eleventh", "twelfth", "thirteenth", "fourteenth"),
            *("fifteenth", "sixteenth", "seventeenth", "eighteenth", "nineteenth", "twentieth"),
            *("twenty-first", "twenty-second", "twenty-third", "twenty-fourth", "twenty-fifth"),
            *("twenty-sixth", "twenty-seventh", "twenty-eighth", "twenty-ninth", "thirtieth"),
            *("thirty-first", "thirty-second", "thirty-third", "thirty-fourth"),
            *("thirty-fifth", "thirty-sixth"),
        ),
        start=1,
    )
}
"""First seed of each split; no machine, run or disturbance is in two of them.

The second and third were drawn to ask two versions of the gap finder the same questions, once each;
the fourth to test the version with one list on cases that none of its rules was set on; the fifth
to the fifteenth and the seventeenth to the thirty-sixth for the same, after the earlier ones had
been examined; the sixteenth to judge compensators (`benchmarks.trust.drawn`)."""
KINDS = ("none", "effect", "outside", "pair", "beyond", "mistake")
NONE_SHARE, PAIRS = 25, 25

DELETED, EMPTY = "deleted", "empty"
TRIALS = (*KINDS, DELETED)
"""Kinds of questions to the gap finder: the cases, and some again with their effect deleted."""

DELETED_SIZES = ("medium", "strong")
"""Sizes of single effects for which a case is asked again with the effect deleted."""

FLAWED = 0.25
"""Share of cases with a hidden effect whose owner's file also has a mistake [1]."""

BLOCKS = 20
"""Number of blocks searched before giving up on finding a matching case."""


@dataclass(frozen=True)
class Planned:
    """A case and what kind it is.

    Attributes
    ----------
    number : int
    kind : str
        One of `TRIALS`, or ``empty``: machine and runs of a case with nothing hidden.
    case : TruthCase
    without : tuple of str
        Effects removed from the gap finder's catalogue.
    truth : str
        The simulator that makes its runs.
    """

    number: int
    kind: str
    case: TruthCase
    without: tuple[str, ...] = ()
    truth: str = USUAL

    @property
    def name(self) -> str:
        """Name of its record."""
        return f"{self.files}_{DELETED}" if self.kind == DELETED else self.files

    @property
    def files(self) -> str:
        """Name of its runs' folder; a case with its effect deleted has the same runs."""
        return f"{self.number:04d}_{EMPTY}" if self.kind == EMPTY else f"{self.number:04d}"

    def emptied(self) -> Planned:
        """Return the same machine and runs with nothing hidden.

        A mistake in the owner's file stays, unless it is the question itself.
        """
        if self.kind == "none":
            return self
        case = replace(self.case, hidden=())
        if self.kind == "mistake":
            case = replace(case, mistake="")
        return replace(self, kind=EMPTY, case=case, without=())


def trials(
    split: str,
    count: int,
    *,
    kinds: Collection[str] = TRIALS,
    effect: str | None = None,
    size: str | None = None,
    truth: str = USUAL,
) -> list[list[Planned]]:
    """Return the questions to the gap finder in *count* cases of a split, by case.

    A case with one effect that is not weak is asked twice, the second time with the effect deleted
    from the catalogue.

    Raises
    ------
    ValueError
        If there are no such cases.
    """
    wanted = (one for one in _cases(split, truth) if _holds(one, effect, size))
    asked = (_asked(one, kinds) for one in wanted)
    found = list(islice(filter(None, asked), count))
    if not found:
        raise ValueError("no case is of that kind")
    return found


def balanced(split: str, each: int, truth: str = USUAL) -> list[list[Planned]]:
    """Return the first *each* cases of every kind in a split, single effects in every size.

    Effects that are not weak are asked again with the effect deleted. Causes outside of the
    catalogue are left out.
    """
    found: dict[int, list[Planned]] = {}
    wishes = [(kind, None) for kind in KINDS if kind not in ("effect", "outside")]
    for kind, size in [*wishes, *(("effect", size) for size in SIZES)]:
        kinds = (kind, DELETED) if kind == "effect" else (kind,)
        try:
            some = trials(split, each, kinds=kinds, size=size, truth=truth)
        except ValueError:
            continue  # Not every simulator has all kinds.
        found.update((asked[0].number, asked) for asked in some)
    return list(found.values())


def _asked(planned: Planned, kinds: Collection[str]) -> list[Planned]:
    found = [planned] if planned.kind in kinds else []
    if planned.kind == "effect" and DELETED in kinds:
        ((name, size, _),) = planned.case.hidden
        if size in DELETED_SIZES:
            found.append(replace(planned, kind=DELETED, without=(name,)))
    return found


def _holds(planned: Planned, effect: str | None, size: str | None) -> bool:
    hidden = planned.case.hidden
    return (effect is None or effect in [name for name, _, _ in hidden]) and (
        size is None or size in [one for _, one, _ in hidden]
    )


def _cases(split: str, truth: str) -> Iterator[Planned]:
    """Yield the cases of a split in order."""
    number = count_up()
    first = SPLITS[split] + TRUTHS[truth].first
    for block in range(BLOCKS):
        for kind, hidden, mistake in _block(truth, first, block):
            at = next(number)
            yield Planned(at, kind, TruthCase(first + at, hidden, mistake=mistake), truth=truth)


Entry = tuple[str, tuple[tuple[str, str | float, str], ...], str]


def _block(truth: str, first: int, block: int) -> list[Entry]:
    """Return one block of the plan: every effect in every size, and the rest, shuffled."""
    rng = np.random.default_rng([first, 7, block])
    hides = TRUTHS[truth]
    entries: list[Entry] = [
        ("effect", ((name, size, ""),), "") for name in hides.catalogue for size in SIZES
    ]
    entries += [("none", (), "")] * NONE_SHARE
    entries += [("outside", ((name, size, ""),), "") for name in hides.outside for size in SIZES]
    names = sorted(hides.catalogue)
    for _ in range(PAIRS):
        one, other = rng.choice(len(names), 2, replace=False)
        sizes = rng.choice(SIZES[1:], 2)
        pair = ((names[one], str(sizes[0]), ""), (names[other], str(sizes[1]), ""))
        entries.append(("pair", pair, ""))
    entries += [("beyond", ((name, size, ""),), "") for name, size in hides.beyond.items()]
    if hides.shop.mistakes:
        mistakes = sorted(hides.shop.mistakes)
        entries = [
            (kind, hidden, str(rng.choice(mistakes)))
            if hidden and rng.random() < FLAWED
            else (kind, hidden, "")
            for kind, hidden, _ in entries
        ]
        entries += [("mistake", (), name) for name in mistakes]
    rng.shuffle(entries)  # type: ignore[arg-type]
    return entries
