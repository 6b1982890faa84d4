"""A sweep of 200 machines in C beside the same sweep in Python, side by side.

Both are the command of docs/sweeps.md, in fresh processes. The first finds both FMUs in both forms;
the second has those in Python alone and, by ``CC=none``, no compiler: plant, compensator and loop
are in Python. The ratio is that of the processor's time; on a computer that does other things, too,
the time on the wall says less.
``python -m benchmarks.native_sweep``
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import build_fmu

VARY = (
    "tool_length=60..240:4",
    "numbers.*_wall=x0.8..1.2",
    "numbers.*_film=x0.8..1.2",
    "numbers.*_seats=x0.8..1.2",
    "numbers.*_expansion=x0.95..1.05",
    "links.*.conductance=x0.8..1.2",
    "sources.*.preload=x0.7..1.3",
)
POINTS = 4
FIGURES = ("before_max_um", "before_mean_um", "after_max_um", "after_mean_um")


@dataclass(frozen=True)
class Cost:
    """What a command took [s]."""

    processor: float
    wall: float


def cost_of(command: list[str], **environment: str) -> Cost:
    """Run a command and return what it and its children took."""
    begun, before = time.perf_counter(), os.times()
    subprocess.run(command, check=True, env={**os.environ, **environment})
    after, wall = os.times(), time.perf_counter() - begun
    spent = (after.children_user - before.children_user) + (
        after.children_system - before.children_system
    )
    return Cost(spent, wall)


def sweep(fmus: Path, out: Path, repeat: int, **environment: str) -> Cost:
    """Run the sweep of docs/sweeps.md."""
    command = [sys.executable, "-m", "scenarios.cli", "sweep", "step_speed"]
    command += ["--variant", "short_tool", "--set", "step_s=10", "--repeat", str(repeat), "--quiet"]
    command += [word for entry in VARY for word in ("--vary", entry)]
    command += ["--fmu-dir", str(fmus), "--out", str(out)]
    return cost_of(command, **environment)


def difference(one: Path, other: Path) -> float:
    """Return the largest difference between two sweeps' tables [um]; they keep six decimals."""
    tables = [pd.read_csv(folder / "sweep.csv") for folder in (one, other)]
    assert list(tables[0]) == list(tables[1])
    first, second = (table[list(FIGURES)].to_numpy() for table in tables)
    return float(np.max(np.abs(first - second)))


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=50, help=f"machines, {POINTS} cases each")
    parser.add_argument("--turns", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="native_sweep_") as name:
        python, both = Path(name) / "python", Path(name) / "both"
        for kind, folder in (([], python), (["--native"], both)):
            if build_fmu.main([*kind, "--out", str(folder)]) != 0:
                sys.exit("the FMUs cannot be built")
        for path in python.glob("*.fmu"):
            shutil.copy(path, both)
        print(f"{POINTS * given.repeat} cases     processor [s]      wall [s]")
        print(f"{'':10}{'C':>8}{'Python':>9}{'C':>8}{'Python':>9}  ratio  wall  difference [um]")
        for turn in range(given.turns):
            outs = [Path(name) / f"{kind}_{turn}" for kind in ("c", "python")]
            fast = sweep(both, outs[0], given.repeat)
            slow = sweep(python, outs[1], given.repeat, CC="none")
            print(
                f"{'':10}{fast.processor:8.1f}{slow.processor:9.1f}{fast.wall:8.1f}{slow.wall:9.1f}"
                f"{slow.processor / fast.processor:7.1f}{slow.wall / fast.wall:6.1f}"
                f"  {difference(*outs):.1g}",
                flush=True,
            )


if __name__ == "__main__":
    main()
