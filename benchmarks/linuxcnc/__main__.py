"""Run a day at LinuxCNC, with the gateway beside it and with the compensator inside it.

``python -m benchmarks.linuxcnc [--write]``
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.linuxcnc.picture import TITLES, draw_days
from benchmarks.linuxcnc.study import COMPONENT, GATEWAY, Plan, run_days
from benchmarks.results_page import as_table, parser_of, tell
from scenarios.building import DEFAULT_MODEL
from scenarios.fmu_files import find_fmu

ROWS = {
    "hours": ("machine time", "{:.1f} h"),
    "drift_um": ("largest drift", "{:.1f} um"),
    "error_um": ("nose held within", "{:.2f} um"),
    "jump_um": ("largest jump at rest, at any fault or recovery", "{:.2f} um"),
    "left_after_clear_um": ("left on the axes after a clear", "{:.3f} um"),
    "blind_error_um": ("while offsets were held without a gateway", "{:.2f} um"),
}
"""Words and form of each figure of a day."""


def table(summary: Mapping[str, Mapping[str, float]]) -> str:
    """Return the figures of the days as Markdown."""
    rows = [
        [words, *(form.format(day[name]) if name in day else "" for day in summary.values())]
        for name, (words, form) in ROWS.items()
    ]
    return as_table(["", *(TITLES[kind] for kind in summary)], rows)


def main(argv: Sequence[str] | None = None) -> int:
    """Run both days at once, draw them and print their figures."""
    parser = parser_of(__doc__, "benchmarks.linuxcnc")
    add = parser.add_argument
    add("--parts", type=int, default=8, help="parts of the day (8)")
    add("--part", type=float, default=60.0, metavar="S", help="length of a part, on the wall (60)")
    text = "the way in: external offsets, or 'offset' with 'limit2' (external)"
    add("--offsets", choices=("external", "own"), default="external", help=text)
    add("--out", type=Path, default=Path("results/control"), metavar="DIR", help="results")
    args = parser.parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="spindle-drift-") as name:
        work = Path(name)
        plant, gateway = (
            find_fmu(fmu, Path("dist"), Path(), work, quiet=True, native=True)
            for fmu in ("plant.fmu", str(DEFAULT_MODEL))
        )
        kinds = {GATEWAY: gateway, COMPONENT: DEFAULT_MODEL}
        noses = run_days(work, kinds, plant, Plan(args.parts, args.part, way=args.offsets))
        for kind in noses:
            shutil.copy(work / kind / "run.csv", args.out / f"{kind}.csv")
            shutil.copy(work / kind / "events.json", args.out / f"{kind}_events.json")
    draw_days(noses, args.out / "nose.png")
    summary = {kind: nose.summary for kind, nose in noses.items()}
    (args.out / "summary.json").write_text(json.dumps(summary, indent=1))
    tell("linuxcnc", table(summary), write=args.write)
    return 0


if __name__ == "__main__":
    sys.exit(main())
