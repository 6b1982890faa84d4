"""What the tables of docs/studies.md say, as sentences made of their cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.studies.entrants import ENTRANTS
from benchmarks.studies.tables import NAMES, SEEDS_THAT_REACH, UNSEEN_PROTOCOLS

Rows = Mapping[str, Sequence[str]]
"""Cells by the title of their row, the heads by the empty text."""
MOST_NAMED = 4
"""So many winners of a column are named; more stand in the table."""


def rows_of(table: str) -> dict[str, list[str]]:
    """Return a Markdown table's cells by the first of their row; the heads by the empty text."""
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return {"": lines[0][1:], **{cells[0]: cells[1:] for cells in lines[2:]}}


def means(cell: str) -> list[float]:
    """Return the means of a cell such as ``91/97 (82/96)``."""
    return [float(mean) for mean in cell.split()[0].split("/")]


def goal_claim(compensation: str, seeds: int) -> str:
    """Return, by machine and protocol, how many models reach the goal in every seed; few by name.

    Parameters
    ----------
    compensation : str
        The table that counts the seeds.
    seeds : int
        How many there are.
    """
    rows = rows_of(compensation)
    memory = {entrant.title: entrant.memory for entrant in ENTRANTS.values()}
    lines = []
    for place, head in enumerate(rows[""]):
        if not head.endswith(SEEDS_THAT_REACH):
            continue
        counts = {title: cells[place].split("/") for title, cells in rows.items() if cells[place]}
        del counts[""]
        free = {title for title in counts if memory.get(title) is False}
        for k, protocol in enumerate(UNSEEN_PROTOCOLS):
            won = [title for title, won in counts.items() if int(won[k]) == seeds]
            names = f" ({'; '.join(won)})" if 0 < len(won) <= MOST_NAMED else ""
            lines.append(
                f"- **{head.partition(':')[0]}, {NAMES[protocol]}**: {len(won)} of {len(counts)}"
                f"{names}, {len(free & {*won})} of {len(free)} without memory"
            )
    return "\n".join(lines)


def network_claim(table: str) -> str:
    """Return by how many points GA-BP's predictive ability differs from BP's, by protocol."""
    rows = rows_of(table)
    bp, genetic = (rows[ENTRANTS[name].title] for name in ("bp_study", "ga_bp_study"))
    parts = []
    for head, ours, theirs in zip(rows[""][:4], genetic, bp, strict=False):
        gaps = [a - b for a, b in zip(means(ours), means(theirs), strict=True)]
        parts.append(f"{head.split()[-1]} {'/'.join(f'{gap:+.0f}' for gap in gaps)}")
    return f"GA-BP less BP, both as GA, eta of E/yaw/pitch in points: {'; '.join(parts)}."


def convergence_claim(table: str) -> str:
    """Return the networks by the median of the iterations that they need."""
    rows = rows_of(table)
    place = rows[""].index("iterations to within 1 % of it")

    def middle(title: str) -> float:
        return float(rows[title][place].split()[0])

    order = sorted((title for title in rows if title), key=middle)
    told = "; ".join(f"{title} {middle(title):.0f}" for title in order)
    return f"Iterations, median, soonest first: {told}."


def tau_claim(table: str) -> str:
    """Return with which time constants the hybrid beats all its parts most often."""
    rows = rows_of(table)
    parts = []
    for place, head in enumerate(rows[""]):
        if head.endswith("beats all parts"):
            wins = {name: int(cells[place].split()[0]) for name, cells in rows.items() if name}
            seeds = next(cells[place].split()[-1] for name, cells in rows.items() if name)
            best = max(wins.values())
            where = ", ".join(name for name, count in wins.items() if count == best)
            first = next(iter(wins))
            parts.append(
                f"{head.partition(':')[0]}: {wins[first]} of {seeds} with tau from {first}, at "
                f"most {best} of {seeds} ({where})"
            )
    return f"The hybrid beats all three parts in all three figures: {'; '.join(parts)}."
