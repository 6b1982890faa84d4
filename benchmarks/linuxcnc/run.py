"""Run a working day at LinuxCNC by the gateway and by the component inside it, and draw the nose.

``python -m benchmarks.linuxcnc.run --write``; it takes eight minutes, and needs the packages
linuxcnc-uspace and linuxcnc-uspace-dev, neither hardware nor root.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.linuxcnc.picture import draw_days
from benchmarks.linuxcnc.study import COMPONENT, GATEWAY, Plan, run_days
from benchmarks.results_page import as_table, tell
from scenarios.building import DEFAULT_MODEL
from scenarios.fmu_files import find_fmu
from scenarios.results import results_folder, write_table

ROWS = {
    "machine time": ("hours", "{:.1f} h"),
    "largest drift": ("drift_um", "{:.1f} um"),
    "nose held within": ("error_um", "{:.2f} um"),
    "largest jump at rest, at any fault or recovery": ("jump_um", "{:.2f} um"),
    "left on the axes after a clear": ("left_after_clear_um", "{:.4f} um"),
    "while offsets were held without a gateway, 5 machine minutes": ("blind_error_um", "{:.2f} um"),
}


def table(summary: Mapping[str, Mapping[str, float]]) -> str:
    """Return the figures as Markdown."""
    heads = ["", "Gateway beside it", "Component inside it"]
    days = [summary[kind] for kind in (GATEWAY, COMPONENT)]
    rows = (
        [what, *(form.format(day[key]) if key in day else "" for day in days)]
        for what, (key, form) in ROWS.items()
    )
    return as_table(heads, rows)


def main(argv: Sequence[str] | None = None) -> int:
    """Run both days, print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", type=float, default=60.0, help="of eight, on the wall [s]")
    parser.add_argument("--offsets", choices=("external", "own"), default="external")
    parser.add_argument("--out", type=Path, default=Path("results/control"), metavar="DIR")
    parser.add_argument("--write", action="store_true", help="also write docs/results.md")
    args = parser.parse_args(argv)
    with (
        tempfile.TemporaryDirectory(prefix="spindle-drift-") as name,
        results_folder(args.out) as folder,
    ):
        work = Path(name)
        plant, fmu = (
            find_fmu(what, Path("dist"), Path(), work, quiet=True, native=True)
            for what in ("plant.fmu", str(DEFAULT_MODEL))
        )
        kinds = {GATEWAY: fmu, COMPONENT: DEFAULT_MODEL}
        noses = run_days(work, kinds, plant, Plan(part_s=args.part, way=args.offsets))
        for kind in noses:
            shutil.copy(work / kind / "run.csv", folder / f"{kind}.csv")
            shutil.copy(work / kind / "events.json", folder / f"{kind}_events.json")
        draw_days(noses, folder / "nose.png")
        summary = {kind: nose.summary for kind, nose in noses.items()}
        write_table([], {"control": summary}, folder, to_come=())
    tell("control", table(summary), write=args.write)
    return 0


if __name__ == "__main__":
    sys.exit(main())
