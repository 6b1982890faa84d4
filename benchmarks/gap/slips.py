"""How many slips of one displacement probe are found, and where none is.

``python -m benchmarks.gap.slips DIR/cases`` takes every case that ``benchmarks.gap.make`` wrote,
looks at its runs as they are, and then lets one probe of one run slip at a random instant, by each
size in turn. Near a switch of the machine nothing is looked for, so that not all can be found.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from benchmarks.gap.ask import MACHINE
from gap_finder.probe_steps import probe_steps
from measurement.runs import Run, read_run
from plant_model.machine_file import read_machine
from plant_model.sensors import column_of, displacement_names

SIZES_UM = (2.5, 4.0, 6.0, 12.0, 24.0)


def main(arguments: list[str] | None = None) -> int:
    """Count, and print what was found."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.slips", description=__doc__)
    parser.add_argument("cases", type=Path, help="folder of cases")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(arguments)
    machine, random = read_machine(MACHINE), np.random.default_rng(args.seed)
    probes = displacement_names(machine)
    found = dict.fromkeys(SIZES_UM, 0)
    false = looked_at = cases = 0
    for folder in sorted(path for path in args.cases.iterdir() if path.is_dir()):
        runs = [read_run(path) for path in sorted(folder.glob("*.csv"))]
        cases, looked_at = cases + 1, looked_at + len(runs)
        false += sum(len(steps) for steps in probe_steps(machine, runs))
        for size in SIZES_UM:
            run = runs[int(random.integers(len(runs)))]
            probe = probes[int(random.integers(len(probes)))]
            row = int(random.integers(len(run.time_s) // 20, len(run.time_s) * 19 // 20))
            column = column_of(machine, probe)
            leap = size * random.choice([-1.0, 1.0]) * (np.arange(len(run.time_s)) >= row)
            slipped = Run(run.name, run.frame.assign(**{column: run.frame[column] + leap}))
            at = [(s.channel, s.time_s) for s in probe_steps(machine, [slipped])[0]]
            found[size] += (probe, float(run.time_s[row])) in at
    print(f"as recorded: {false} slips in {looked_at} runs of {cases} cases")
    for size, count in found.items():
        print(f"{size:4g} um: {count} of {cases} found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
