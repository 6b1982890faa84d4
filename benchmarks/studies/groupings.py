"""Groups of the eleven thermometers and the points chosen, as the studies' settings are swept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

from benchmarks.results_page import as_table
from benchmarks.studies.machines import truth
from benchmarks.studies.published import GA_POINTS, TS_GROUPS
from fmu_compensator.fit.survey import survey
from scenarios.pages.points_figures import draw_points
from scenarios.presets import PRESETS

GREY, TREE = "GA", "TS"
SETTINGS: Mapping[str, Sequence[Mapping[str, Any]]] = {
    GREY: [
        *({"threshold": value} for value in (0.8, 0.85, 0.9, 0.95, 0.98)),
        *({"theta": value} for value in (0.0, 0.25, 0.75, 1.0)),
    ],
    TREE: [{"clusters": count, "variables": max(count, 5)} for count in (2, 3, 4, 5, 6)],
}
"""What is swept; the rest is as the study prints it."""
WORDS = {"threshold": "lambda", "theta": "theta", "clusters": "C"}


@dataclass(frozen=True)
class Grouped:
    """What one setting gives on one machine with the noise of one seed.

    Attributes
    ----------
    machine : str
    study : str
        Whose way it is.
    place : int
        Of the setting among `SETTINGS`.
    seed : int
    groups : tuple of tuple of int
        Numbers of the thermometers.
    points : tuple of int
        Those chosen.
    """

    machine: str
    study: str
    place: int
    seed: int
    groups: tuple[tuple[int, ...], ...]
    points: tuple[int, ...]


def draw_grouped(machine: str, seed: int, folder: Path) -> list[Path]:
    """Draw dendrogram, map of degrees and loops of a machine's training run, all thermometers."""
    known = truth(machine)
    run = known.runs(seed)["fit"].measured
    preset = PRESETS[TREE]
    return draw_points(survey([run], known.rig, grouping=preset.points, **preset.grey), folder)


def grouped(machine: str, seed: int) -> list[Grouped]:
    """Group the thermometers of a machine's training run by every setting."""
    known = truth(machine)
    run = known.runs(seed)["fit"].measured
    found = []
    for study, settings in SETTINGS.items():
        preset = PRESETS[study]
        for place, setting in enumerate(settings):
            options = {"grouping": preset.points, **preset.grey, **setting}
            told = survey([run], known.rig, **options)
            numbers = [int(name.lstrip("T")) for name in told.sensors]
            way = next(one for one in told.groupings if one.startswith(preset.points))
            groups = sorted(tuple(sorted(numbers[i] for i in g)) for g in told.groupings[way])
            points = tuple(numbers[i] for i in told.points)
            found.append(Grouped(machine, study, place, seed, tuple(groups), points))
    return found


def agreement(groups: Iterable[Sequence[int]], others: Iterable[Sequence[int]]) -> float:
    """Return the share of pairs on which two groupings agree, Rand's index [1].

    Only thermometers that both have count.
    """
    mine, theirs = (
        {number: i for i, group in enumerate(some) for number in group} for some in (groups, others)
    )
    pairs = list(combinations(sorted(mine.keys() & theirs.keys()), 2))
    same = [(mine[a] == mine[b]) == (theirs[a] == theirs[b]) for a, b in pairs]
    return sum(same) / len(same)


def groupings_table(found: Sequence[Grouped], study: str) -> str:
    """Return groups and points by setting, of the first seed, and in how many seeds they are so.

    Settings that give the same share a row.
    """
    machines = list(dict.fromkeys(one.machine for one in found))
    rows: dict[tuple[str, ...], list[str]] = {}
    for place, setting in enumerate(SETTINGS[study]):
        cells: list[str] = []
        for machine in machines:
            some = [
                one
                for one in sorted(found, key=lambda one: one.seed)
                if (one.machine, one.study, one.place) == (machine, study, place)
            ]
            first = some[0]
            alike = sum(one.groups == first.groups for one in some)
            cells += [
                " ".join("(" + ",".join(map(str, group)) + ")" for group in first.groups),
                f"{alike} of {len(some)}",
                ",".join(f"T{number}" for number in first.points),
            ]
            if study == TREE:
                cells.append(f"{100.0 * agreement(first.groups, TS_GROUPS):.0f}")
        words = [f"{WORDS[key]} {value:g}" for key, value in setting.items() if key in WORDS]
        rows.setdefault(tuple(cells), []).append(", ".join(words))
    head = ["setting"]
    for machine in machines:
        title = truth(machine).title
        head += [f"{title}: groups", "so in seeds", "points"]
        head += ["pairs as the study has them [%]"] if study == TREE else []
    return as_table(head, [["; ".join(settings), *cells] for cells, settings in rows.items()])


def groupings_claim(found: Sequence[Grouped]) -> str:
    """Return whether any setting gives what the studies print."""
    printed = {tuple(sorted(group)) for group in TS_GROUPS}
    trees = [one for one in found if one.study == TREE]
    same = [one for one in trees if set(one.groups) == printed]
    best = max(trees, key=lambda one: agreement(one.groups, TS_GROUPS))
    share = 100.0 * agreement(best.groups, TS_GROUPS)
    count = SETTINGS[TREE][best.place]["clusters"]
    chosen = [one for one in found if one.study == GREY and one.points == GA_POINTS]
    return (
        f"TS's groups come out in {len(same)} of {len(trees)} cases; nearest is C = {count} on the "
        f"{truth(best.machine).title}, {share:.0f} % of the pairs. GA's four points come out in "
        f"{len(chosen)} of {len(found) - len(trees)}."
    )
