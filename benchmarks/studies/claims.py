"""What the tables of docs/studies.md say, as sentences made of their cells."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from benchmarks.studies.entrants import ENTRANTS

Rows = Mapping[str, Sequence[str]]
"""Cells by the title of their row, the heads by the empty text."""
MOST_NAMED = 4
"""So many winners of a column are named; more stand in the table."""


def rows_of(table: str) -> dict[str, list[str]]:
    """Return a Markdown table's cells by the first of their row; the heads by the empty text."""
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return {"": lines[0][1:], **{cells[0]: cells[1:] for cells in lines[2:]}}


def means(cell: str) -> list[float]:
    """Return the means of a cell such as ``91 (82) / 97 (95)``."""
    return [float(part.split()[0]) for part in cell.split(" / ")]


def goal_claim(goal: str) -> str:
    """Return, for each column of the goal's table, how many reach it in every seed, few by name."""
    rows = rows_of(goal)
    models = [title for title in rows if title]
    memory = {entrant.title: entrant.memory for entrant in ENTRANTS.values()}
    free = [title for title in models if memory.get(title) is False]
    lines = []
    for place, head in enumerate(rows[""]):
        won = [title for title in models if re.fullmatch(r"(\d+) of \1", rows[title][place])]
        names = f" ({'; '.join(won)})" if 0 < len(won) <= MOST_NAMED else ""
        lines.append(
            f"- **{head}**: {len(won)} of {len(models)}{names}, {len({*free} & {*won})} of "
            f"{len(free)} baselines without memory"
        )
    return "\n".join(lines)


def network_claim(table: str) -> str:
    """Return by how many points GA-BP's predictive ability differs from BP's, by protocol."""
    rows = rows_of(table)
    bp, genetic = (rows[ENTRANTS[name].title] for name in ("bp_study", "ga_bp_study"))
    parts = []
    for head, ours, theirs in zip(rows[""][:4], genetic, bp, strict=False):
        gaps = [a - b for a, b in zip(means(ours), means(theirs), strict=True)]
        parts.append(f"{head} {' / '.join(f'{gap:+.0f}' for gap in gaps)}")
    return (
        "GA-BP less BP, both as the study trains them, eta of E / yaw / pitch in points: "
        f"{'; '.join(parts)}."
    )


def convergence_claim(table: str) -> str:
    """Return the networks by the median of the iterations that they need, and their nodes."""
    rows = rows_of(table)
    place = rows[""].index("iterations to within 1 % of it")

    def middle(title: str) -> float:
        return float(rows[title][place].split()[0])

    order = sorted((title for title in rows if title), key=middle)
    told = "; ".join(f"{title} {middle(title):.0f}" for title in order)
    nodes = "; ".join(
        f"{ENTRANTS[name].title} {rows[ENTRANTS[name].title][0]}"
        for name in ("ga_bp_nodes", "ga_bp_nodes_training")
    )
    return f"Iterations, median, soonest first: {told}. Nodes found: {nodes}."


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


def printed_claims(prediction: str, compensation: str) -> Iterable[Sequence[str]]:
    """Return rows of the studies' printed figures that stand in no other table, beside ours."""
    eta, left = rows_of(prediction), rows_of(compensation)
    at = next(k for k, head in enumerate(left[""]) if head.startswith("like coolant, axial max"))
    for name, study in (("bp_study", "6.483"), ("ga_bp_study", "3.903")):
        cell = left[ENTRANTS[name].title][at]
        ours = cell.split(",")[0].split(" to ")[1]
        yield ENTRANTS[name].title, "largest axial residual, unseen [um]", study, ours
    place = eta[""].index("unseen, like coolant")
    row = eta[ENTRANTS["arma_270"].title][place]
    yield ENTRANTS["arma_270"].title, "predictive ability, unseen, E / yaw / pitch [%]", "94", row
