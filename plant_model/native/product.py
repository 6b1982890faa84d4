"""Product of a network's matrix and temperatures in C: loops over nodes with similar neighbours.

A processor handles several adjacent numbers at once. So the matrix's rows are cut into groups of
that many rows. A term is what rows of a group have in common: the same neighbour, neighbours at the
same distance, or mirrored ones. If a row lacks a term, its element is zero. If several rows of a
group exchange heat with one node, or with one neighbour each in another group, the elements are
stored once and used in both directions in the same loop. Other elements are added one by one.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence

LANES = 4
"""Numbers handled at once, at the cost of one: given by AVX, the widest that most processors have.
Sums are also split into parts of as many terms, so that the parts do not wait for each other."""

PLUS = "\n           + "
Place = tuple[int, int]


class Product:
    """The C function, and the matrix's off-diagonal elements in the order in which it reads them.

    Parameters
    ----------
    nodes : int
    edges : iterable of (int, int)
        Nodes that exchange heat, each pair once.

    Attributes
    ----------
    entries : list of (int, int) or None
        Row and column of every element; None for a zero.
    """

    def __init__(self, nodes: int, edges: Iterable[Place]) -> None:
        self.entries: list[Place | None] = []
        self._rows = [set[int]() for _ in range(nodes)]
        for node, other in edges:
            self._rows[node].add(other)
            self._rows[other].add(node)
        self._left = {(i, j) for i, row in enumerate(self._rows) for j in row}
        self._terms = defaultdict[int, list[tuple[str, str, set[Place]]]](list)
        self._groups = groups(self._rows)
        self._share_between_groups()
        self._share_with_nodes()
        for first in self._groups:
            for neighbour, places in terms(self._rows, first, self._left):
                self._take(first, neighbour, "", places)
        self._begun = set[str]()
        lines = [line for first in self._groups for line in self._loop(first)]
        grouped = {i for first in self._groups for i in _lanes(first)}
        lines += [line for i in range(nodes) for line in self._row(i, i in grouped)]
        head = (
            "WIDE void equations_product(\n    const double *diagonal, const double *entries, "
            "const double *share, const double *T,\n    const double *last, double weight, "
            "double *restrict next, double *restrict sum)"
        )
        unused = [] if self.entries else ["    (void)entries;"]
        # Rows follow the entries in memory: with this padding most groups are in one cache line.
        begin = Counter(first % LANES for first in self._groups).most_common(1)
        self.entries += [None] * (-(len(self.entries) + sum(place for place, _ in begin)) % LANES)
        sums = [f"    double {name}[{LANES}];" for name in sorted(self._begun)]
        self.text = "\n".join([head, "{", *unused, *sums, *lines, "}", ""])

    def _take(self, first: int, neighbour: str, back: str, places: set[Place]) -> None:
        """Give a group a term, and with *back* use the same elements for its neighbours."""
        self._terms[first].append((neighbour, back, places))
        self._left -= places
        if back:
            self._left -= {(j, i) for i, j in places}

    def _share_between_groups(self) -> None:
        for group in self._groups:
            for other in self._groups:
                pairs = set(zip(_lanes(group), _lanes(other), strict=True)) & self._left
                if group < other and 2 * len(pairs) > LANES:
                    self._take(group, f"T[{other} + i]", f"g{other}", pairs)

    def _share_with_nodes(self) -> None:
        """Share elements if that is worth a final sum over the lanes, busiest nodes first."""
        blocks_of = defaultdict[int, dict[int, set[Place]]](dict)
        for first in self._groups:
            beside = {j for i in _lanes(first) for j in self._rows[i]} - {*_lanes(first)}
            for j in beside:
                blocks_of[j][first] = {(i, j) for i in _lanes(first)}
        for j, blocks in sorted(blocks_of.items(), key=lambda item: (-len(item[1]), item[0])):
            shared = {first: places & self._left for first, places in blocks.items()}
            shared = {first: places for first, places in shared.items() if len(places) > 1}
            if sum(map(len, shared.values())) >= LANES:
                for first, places in shared.items():
                    self._take(first, f"T[{j}]", f"s{j}", places)

    def _loop(self, first: int) -> Iterator[str]:
        parts, backs = [f"diagonal[{first} + i] * t"], []
        if f"g{first}" in self._begun:
            parts.append(f"g{first}[i]")
        for neighbour, back, places in self._terms[first]:
            at, where = len(self.entries), dict(places)
            self.entries += [(i, where[i]) if i in where else None for i in _lanes(first)]
            parts.append(f"entries[{at} + i] * {neighbour}")
            if back:
                sign = "+=" if back in self._begun else "="
                backs.append(f"        {back}[i] {sign} entries[{at} + i] * t;")
                self._begun.add(back)
        yield f"    for (int i = 0; i < {LANES}; i++) {{"
        yield f"        double t = T[{first} + i];"
        yield f"        next[{first} + i] = share[{first} + i]"
        yield f"        * ({_sum(parts)}) - last[{first} + i];"
        yield from backs
        yield f"        sum[{first} + i] += weight * t;"
        yield "    }"

    def _row(self, i: int, grouped: bool) -> Iterator[str]:
        """Yield a single row, or a row's elements outside its group's terms."""
        parts = [] if grouped else [f"diagonal[{i}] * T[{i}]"]
        if f"s{i}" in self._begun:
            parts.append(f"((s{i}[0] + s{i}[2]) + (s{i}[1] + s{i}[3]))")
        for j in sorted(self._rows[i]):
            if (i, j) in self._left:
                parts.append(f"entries[{len(self.entries)}] * T[{j}]")
                self.entries.append((i, j))
        if not grouped:
            yield f"    next[{i}] = share[{i}] * ({_sum(parts)}) - last[{i}];"
            yield f"    sum[{i}] += weight * T[{i}];"
        elif parts:
            yield f"    next[{i}] += share[{i}] * ({_sum(parts)});"


def groups(rows: Sequence[set[int]]) -> list[int]:
    """Return the first row of each group, for the cut of the rows with the fewest operations.

    A term counts as one operation, and so do a single element, a row and a group. A row with more
    single elements than lanes will share them.
    """
    best: list[tuple[int, list[int]]] = [(0, [])]
    for end in range(1, len(rows) + 1):
        cost, before = best[-1]
        tried = [(cost + 1 + min(LANES, len(rows[end - 1])), before)]
        if end >= LANES:
            first = end - LANES
            cost, before = best[first]
            left = {(i, j) for i in _lanes(first) for j in rows[i]}
            shared = terms(rows, first, left)
            left.difference_update(*(places for _, places in shared))
            alone = sum(min(LANES, sum(i == row for row, _ in left)) for i in _lanes(first))
            tried.append((cost + 1 + len(shared) + alone, [*before, first]))
        best.append(min(tried))
    return best[-1][1]


def terms(rows: Sequence[set[int]], first: int, among: set[Place]) -> list[tuple[str, set[Place]]]:
    """Return the terms of a group: the neighbour in C, and the places, of each."""
    left = {place for place in among if place[0] in _lanes(first)}
    shared: list[tuple[str, set[Place]]] = []
    while True:
        tried = defaultdict[str, set[Place]](set)
        for i, j in left:
            tried[f"T[{j}]"].add((i, j))
            if 0 <= first + j - i <= len(rows) - LANES:
                tried[f"T[{first + j - i} + i]"].add((i, j))
            if LANES - 1 <= i + j - first < len(rows):
                tried[f"T[{i + j - first} - i]"].add((i, j))
        best = max(tried, key=lambda term: (len(tried[term]), term), default="")
        if len(tried[best]) < 2:
            return shared
        shared.append((best, tried[best]))
        left -= tried[best]


def _lanes(first: int) -> range:
    return range(first, first + LANES)


def _sum(parts: Sequence[str]) -> str:
    """Return a sum split into parts that do not wait for each other."""
    groups = [parts[k : k + LANES] for k in range(0, len(parts), LANES)]
    return PLUS.join(f"({' + '.join(group)})" for group in groups)
