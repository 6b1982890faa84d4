"""A network times temperatures as C: loops over nodes whose neighbours lie alike.

A processor takes several numbers at once where they stand side by side: the conductances of nodes
in a row, and their neighbours' temperatures, where the neighbours lie at the same distance or are
one and the same. So a network's rows are cut into stretches that share such terms. An element of
the matrix stands where each of the two rows that need it reads it; where a row of a stretch lacks a
term there is a nought. What no stretch shares is added by itself, as is a row with many neighbours
side by side.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

LANES = 4
"""Numbers that are taken at once, and then cost as much as one: given by AVX, the widest that most
processors have."""

LONGEST = 8 * LANES
"""Rows of a stretch; half as many neighbours side by side have a loop of their own. Set on a page,
by instructions counted: 8 to 24 neighbours are within 5 %."""

PLUS = "\n           + "
Place = tuple[int, int]
Term = tuple[bool, int]
"""Whether the neighbour is the same for all rows, and which it is, else how far off it lies."""


@dataclass(frozen=True)
class Stretch:
    """Rows from the first to before the end, the terms that they share, and places left over.

    A term has the places that it takes: another one may have taken some before.
    """

    first: int
    end: int
    terms: tuple[tuple[Term, frozenset[Place]], ...]
    left: tuple[Place, ...]

    @property
    def cost(self) -> int:
        """Operations, of which a loop takes two, and so does each round of it besides its terms."""
        alone = len(self.left) + len({i for i, _ in self.left})
        return 2 + (2 + len(self.terms)) * _rounds(self.first, self.end) + alone

    @classmethod
    def of(cls, rows: Sequence[set[int]], first: int, end: int) -> Stretch:
        """Let rows share what saves operations, the most frequent terms first."""
        found = defaultdict[Term, set[Place]](set)
        for i in range(first, end):
            for j in rows[i]:
                found[True, j].add((i, j))
                if first + j - i >= 0 and end + j - i <= len(rows):
                    found[False, j - i].add((i, j))
        left = {(i, j) for i in range(first, end) for j in rows[i]}
        terms, rounds = [], _rounds(first, end)
        for term, places in sorted(found.items(), key=lambda pair: (-len(pair[1]), pair[0])):
            taken = frozenset(places & left)
            if len(taken) > rounds:
                terms.append((term, taken))
                left -= taken
        return cls(first, end, tuple(terms), tuple(sorted(left)))


def _rounds(first: int, end: int) -> int:
    """Return how often a loop over rows runs: those that do not fill the lanes go one by one."""
    return sum(divmod(end - first, LANES))


def stretches(rows: Sequence[set[int]]) -> list[Stretch]:
    """Return the cheapest cut of a matrix's rows, each the places beside its diagonal, in order."""
    best: list[tuple[int, list[Stretch]]] = [(0, [])]
    for end in range(1, len(rows) + 1):
        tried = (Stretch.of(rows, first, end) for first in range(max(0, end - LONGEST), end))
        last = min(tried, key=lambda stretch: best[stretch.first][0] + stretch.cost)
        cost, before = best[last.first]
        best.append((cost + last.cost, [*before, last]))
    return best[-1][1]


class Product:
    """The C function, and the matrix's elements beside the diagonal in the order it reads them.

    Parameters
    ----------
    nodes : int
    edges : iterable of (int, int)
        Nodes that exchange heat, each pair once.

    Attributes
    ----------
    entries : list of (int, int) or None
        Row and column of every element; None: a nought.
    """

    def __init__(self, nodes: int, edges: Iterable[Place]) -> None:
        self.entries: list[Place | None] = []
        self._rows = [set[int]() for _ in range(nodes)]
        for one, other in edges:
            self._rows[one].add(other)
            self._rows[other].add(one)
        self._alone = defaultdict[int, list[str]](list)
        runs = [(i, run) for i, row in enumerate(self._rows) for run in _runs(row)]
        for i, run in runs:
            self._rows[i] -= set(run)
        loops = [line for stretch in stretches(self._rows) for line in self._loop(stretch)]
        sums = [line for i, run in runs for line in self._sum(i, run)]
        rest = [f"    rates[{i}] += share[{i}] * ({_sum(self._alone[i])});" for i in self._alone]
        head = (
            "WIDE void equations_product(\n    const double *diagonal, const double *entries, "
            "const double *share, const double *T,\n    double *restrict rates)"
        )
        unused = [] if self.entries else ["    (void)entries;"]
        self.text = "\n".join([head, "{", *unused, *sums, *loops, *rest, "}", ""])

    def _loop(self, stretch: Stretch) -> Iterator[str]:
        first, rows = stretch.first, range(stretch.first, stretch.end)
        parts = [f"diagonal[{first} + i] * T[{first} + i]"]
        for (same, x), taken in stretch.terms:
            neighbour = f"T[{x}]" if same else f"T[{first + x} + i]"
            parts.append(f"entries[{len(self.entries)} + i] * {neighbour}")
            places = [(i, x if same else i + x) for i in rows]
            self.entries += [place if place in taken else None for place in places]
        yield f"    for (int i = 0; i < {len(rows)}; i++) {{"
        yield f"        rates[{first} + i] = share[{first} + i]"
        yield f"        * ({_sum(parts)}) - rates[{first} + i];"
        yield "    }"
        for i, j in stretch.left:
            self._alone[i].append(self._entry(i, j))

    def _sum(self, i: int, run: range) -> Iterator[str]:
        """Yield the sum of a row's neighbours side by side, in lanes; what is over stands alone."""
        name, whole, at = f"s{i}_{run[0]}", len(run) // LANES * LANES, len(self.entries)
        yield f"    double {name}[{LANES}] = {{0.0}};"
        yield f"    for (int i = 0; i < {whole}; i += {LANES}) {{"
        yield f"        for (int j = 0; j < {LANES}; j++) {{"
        yield f"            {name}[j] += entries[{at} + i + j] * T[{run[0]} + i + j];"
        yield "        }"
        yield "    }"
        self.entries += [(i, j) for j in run[:whole]]
        self._alone[i] += [f"{name}[{lane}]" for lane in range(LANES)]
        self._alone[i] += [self._entry(i, j) for j in run[whole:]]

    def _entry(self, i: int, j: int) -> str:
        self.entries.append((i, j))
        return f"entries[{len(self.entries) - 1}] * T[{j}]"


def _runs(row: set[int]) -> Iterator[range]:
    """Yield neighbours side by side that are worth a loop of their own."""
    for first in sorted(row):
        if first - 1 not in row:
            end = first
            while end in row:
                end += 1
            if end - first >= LONGEST // 2:
                yield range(first, end)


def _sum(parts: Sequence[str]) -> str:
    """Return a sum of few that do not wait for each other."""
    groups = [parts[k : k + LANES] for k in range(0, len(parts), LANES)]
    return PLUS.join(f"({' + '.join(group)})" for group in groups)
