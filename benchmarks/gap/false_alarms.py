"""Whether the search for broken channels is silent where none is broken.

``python -m benchmarks.gap.false_alarms DIR/cases`` looks at every case that ``benchmarks.gap.make``
wrote: as recorded, thinned to 120 s and 240 s, and with a tenth of the rows dropped at random. No
sensor of these cases is broken, though some are a little wrong, late or drifting.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from benchmarks.gap.ask import MACHINE
from benchmarks.gap.variants import variants
from gap_finder.probe_steps import probe_steps
from measurement.faults import GROSS, LEVELS, find_faults, unusable
from measurement.runs import read_run
from plant_model.machine_file import read_machine

THINNED_S = (120.0, 240.0)


def main(arguments: list[str] | None = None) -> int:
    """Print every alarm, and how many there were."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.false_alarms", description=__doc__)
    parser.add_argument("cases", type=Path, help="folder of cases")
    args = parser.parse_args(arguments)
    folders = sorted(path for path in args.cases.iterdir() if path.is_dir())
    machine = read_machine(MACHINE)
    alarms = slips = looked_at = 0
    for number, folder in enumerate(tqdm(folders, unit="case")):
        runs = [read_run(path) for path in sorted(folder.glob("*.csv"))]
        for how, some in variants(runs, number, THINNED_S):
            looked_at += len(some)
            for fault in unusable(find_faults(some), (*GROSS, *LEVELS)):
                alarms += 1
                print(f"{folder.name}, {how}: {fault.line()}")
            for run, steps in zip(some, probe_steps(machine, some), strict=True):
                for one in steps:
                    slips += 1
                    print(f"{folder.name}, {how}: {one.text(run.name)}")
    print(f"{alarms} alarms and {slips} slips in {looked_at} runs of {len(folders)} cases")
    return 0


if __name__ == "__main__":
    sys.exit(main())
