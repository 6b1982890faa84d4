"""Plant faults, look for them, and count false alarms.

``python -m benchmarks.sensor_faults.run report --lathe DIR --spindle FILE`` prints the tables,
``--write`` puts them into docs/results.md; ``setting`` in place of ``report`` takes the runs on
which the thresholds were set. Without the measured data the simulated runs alone are used.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from tqdm import tqdm

from benchmarks.results_page import as_table, parser_of, tell
from benchmarks.sensor_faults.breaking import BREAKAGES, ODDITIES, Breakage, planted
from benchmarks.sensor_faults.plain import plain_faults
from benchmarks.sensor_faults.sources import Group, is_known, is_sound, report, setting
from measurement.faults import GROSS, LEVELS, Fault, find_faults, unusable
from measurement.faults.series import lengths_of
from measurement.runs import FloatArray, Run

GRAVE = (*GROSS, *LEVELS)
MOVED = {"degC": 2.0, "um": 5.0}
"""A standstill is planted where the reading would have moved by this much [K, um]: else nothing is
wrong with it."""
TRIES = 40
Detector = Callable[[Sequence[Run]], list[Fault]]


Place = tuple[str, str, str]
"""Of what was counted: its source, the row of its table, and the detector."""


def grave(faults: Sequence[Fault]) -> list[Fault]:
    """Return what is said to be broken and is not known to be."""
    return [one for one in unusable(faults, GRAVE) if not is_known(one)]


def breaks(
    group: Group, rng: np.random.Generator
) -> Iterator[tuple[Breakage, int, str, Run, tuple[float, float]]]:
    """Yield every breakage planted in a group: run, column, and when."""
    for how in BREAKAGES:
        for _ in range(TRIES):
            place = int(rng.integers(len(group)))
            run = group[place]
            names = run.temperatures if how.unit == "degC" else lengths_of(run)
            names = [name for name in names if is_sound(run, name)]
            if not names:
                break
            column = str(rng.choice(names))
            broken, span = planted(run, column, how, rng)
            if not how.name.startswith("frozen") or _moved(run, column, span) >= MOVED[how.unit]:
                yield how, place, column, broken, span
                break


def _moved(run: Run, column: str, span: tuple[float, float]) -> float:
    rows = (run.time_s >= span[0]) & (run.time_s <= span[1])
    values: FloatArray = run.frame[column].to_numpy()[rows]
    values = values[np.isfinite(values)]
    return float(np.ptp(values)) if values.size else 0.0


def judge(
    faults: Sequence[Fault], place: int, column: str, span: tuple[float, float]
) -> tuple[bool, float]:
    """Return whether a planted fault was found, and how much healthy time went with it [min]."""
    here = [one for one in faults if one.place == place and one.column == column]
    length = span[1] - span[0]
    covered = lost = 0.0
    for one in here:
        inside = min(one.end_s, span[1]) - max(one.start_s, span[0])
        if inside >= 0.0:
            covered += max(inside, 1.0)
            lost += max(one.end_s - one.start_s - max(inside, 0.0), 0.0)
    return bool(covered >= max(0.5 * length, 1.0)), float(lost) / 60.0


@dataclass
class Count:
    """Everything that was counted.

    Attributes
    ----------
    detectors : dict
        By name.
    cases, hits : Counter
        Runs looked at, and spans called broken that are not; or planted faults, and those found.
    lost_min : list of float
        Healthy time of a broken channel that the detector called broken, too [min].
    """

    detectors: dict[str, Detector]
    cases: Counter[Place] = field(default_factory=Counter)
    hits: Counter[Place] = field(default_factory=Counter)
    lost_min: list[float] = field(default_factory=list)

    def healthy(self, source: str, group: Group, rng: np.random.Generator) -> None:
        """Count the alarms in runs that are sound: all as recorded, one run of them in odd ways."""
        for run in group:
            self._alarms(f"{source}, alone", "as recorded", [run], [0])
        self._alarms(f"{source}, among others", "as recorded", group, range(len(group)))
        for how, change in ODDITIES.items():
            place = int(rng.integers(len(group)))
            run = group[place]
            column = str(rng.choice([n for n in run.temperatures if is_sound(run, n)]))
            for context, runs, at in _contexts(group, place, change(run, column, rng)):
                self._alarms(f"{source}, {context}", how, runs, [at])

    def _alarms(self, source: str, how: str, runs: Group, places: Sequence[int]) -> None:
        for name, detector in self.detectors.items():
            alarms = [one for one in grave(detector(runs)) if one.place in places]
            self.cases[source, f"healthy: {how}", name] += len(places)
            self.hits[source, f"healthy: {how}", name] += len(alarms)

    def broken(self, source: str, group: Group, rng: np.random.Generator) -> None:
        """Count what is found of faults planted one at a time."""
        for breakage, place, column, broken, span in breaks(group, rng):
            for context, runs, at in _contexts(group, place, broken):
                for name, detector in self.detectors.items():
                    seen, lost = judge(unusable(detector(runs), GRAVE), at, column, span)
                    self.cases[f"{source}, {context}", breakage.name, name] += 1
                    self.hits[f"{source}, {context}", breakage.name, name] += seen
                    if seen and name == "detector":
                        self.lost_min.append(lost)


def _contexts(group: Group, place: int, changed: Run) -> Iterator[tuple[str, Group, int]]:
    yield "alone", [changed], 0
    yield "among others", [*group[:place], changed, *group[place + 1 :]], place


def tables(count: Count) -> str:
    """Return Markdown tables: false alarms, then faults found."""
    sources = list(dict.fromkeys(source for source, _, _ in count.cases))
    lines = []
    for healthy in (True, False):
        rows = [what for _, what, _ in count.cases if what.startswith("healthy") == healthy]
        title = "Healthy, alarms per run" if healthy else "Planted, share found"
        cells = (
            [what.removeprefix("healthy: "), *(_cell(count, source, what) for source in sources)]
            for what in dict.fromkeys(rows)
        )
        lines += [as_table([title, *sources], cells), ""]
    if lost := count.lost_min:
        middle, most = np.percentile(lost, [50, 95])
        lines.append(
            f"Healthy time of a broken channel that is left out with it: median {middle:.0f} min, "
            f"95 % of {len(lost)} cases below {most:.0f} min."
        )
    return "\n".join(lines)


def _cell(count: Count, source: str, what: str) -> str:
    """Return detector and plain rule as one cell, the plain rule in brackets."""
    cases = count.cases[source, what, "detector"]
    hits = [count.hits[source, what, name] for name in count.detectors]
    if not cases:
        return "-"
    healthy = what.startswith("healthy")
    ours, plain = (f"{some / cases:.2f}" if healthy else f"{some}/{cases}" for some in hits)
    return f"{ours} ({plain})"


def main(arguments: list[str] | None = None) -> int:
    """Plant, look, count, print."""
    parser = parser_of(__doc__, "benchmarks.sensor_faults.run")
    parser.add_argument("part", choices=("setting", "report"))
    parser.add_argument("--lathe", type=Path, metavar="DIR", help="folder of the lathe's runs")
    parser.add_argument("--spindle", type=Path, metavar="FILE", help="electric spindle record")
    parser.add_argument("--cases", type=int, default=8, help="simulated machines (default: 8)")
    parser.add_argument("--seed", type=int, default=0, help="of machines and faults")
    args = parser.parse_args(arguments)
    first = 1_000_000 + 1000 * args.seed if args.part == "report" else 1000 * args.seed
    groups = list(
        setting(args.lathe, args.cases, first)
        if args.part == "setting"
        else report(args.lathe, args.spindle, args.cases, first)
    )
    count = Count({"detector": find_faults, "plain": plain_faults})
    for number, (source, group) in enumerate(tqdm(groups, unit="group", disable=None)):
        rng = np.random.default_rng([args.seed, number])
        count.healthy(source, group, rng)
        count.broken(source, group, rng)
    tell("sensor_faults", tables(count), write=args.write)
    return 0


if __name__ == "__main__":
    sys.exit(main())
