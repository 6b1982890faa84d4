"""Checks that a simulator and its owner's file describe the same machine.

``python -m benchmarks.gap.agree --truth belt --cases 3`` hides nothing, gives the owner exact
masses and surfaces, calibrates that file on four runs, and prints the residual on the fifth, in
units of sensor noise and by channel. If it is far above noise, simulator and file disagree where
they should not, and this affects every other answer of the gap finder. ``--careless`` does the
same with the owner's guesses in the benchmark.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.gap.case import TruthCase
from benchmarks.gap.make import OWNERS_FILE
from benchmarks.gap.truths import TRUTHS
from gap_finder.calibrate import calibrate
from gap_finder.observations import Observations, observe
from gap_finder.regimes import by_channel, floor_of, gap_of, residuals
from measurement.files import write_atomically
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine

FIRST = 500_000
"""First seed, outside of all splits."""


def never_moves(machine: Machine, observed: Sequence[Observations]) -> float:
    """Return the gap of a model that never moves, in noise units."""
    still = np.concatenate([one.values - one.values[:1] for one in observed])
    noise = observed[0].noise
    return float(np.sqrt(np.nanmean((still / noise) ** 2)))


def agreement(name: str, seed: int, *, careless: bool) -> None:
    """Print the residuals of calibration in one case with nothing hidden."""
    truth = TRUTHS[name]
    case = TruthCase(truth.first + seed, careless=careless)
    begun = time.perf_counter()
    runs = [Run(run.name, run.frame) for run in truth.shop.simulate(case)[0]]
    simulated = time.perf_counter() - begun
    with tempfile.TemporaryDirectory() as folder:
        path = write_atomically(Path(folder) / OWNERS_FILE, truth.shop.owners_file(case))
        machine = read_machine(str(path))
    observed = observe(machine, runs)
    begun = time.process_time()
    found = calibrate(machine, observed[:4])
    took = time.process_time() - begun
    unseen = observed[4:]
    left = [residuals(found.machine, one) for one in unseen]
    gaps = [
        gap_of([residuals(machine, one) for one in unseen]),
        gap_of([residuals(found.machine, one) for one in observed[:4]]),
        gap_of(left),
        gap_of(floor_of(left)),
    ]
    print(
        f"machine {seed}, {len(machine.nodes)} lumps: never moves"
        f" {never_moves(machine, unseen):.1f}, page as it stands {gaps[0]:.1f},"
        f" calibrated {gaps[1]:.2f}, on the unseen run {gaps[2]:.2f}, noise"
        f" {gaps[3]:.2f}; simulated in {simulated:.0f} s, calibrated in {took:.0f} s"
    )
    channels = by_channel(left).items()
    print("   " + ", ".join(f"{channel} {value:.2f}" for channel, value in channels))
    bound = [one.name for one in found.parameters if one.at_bound]
    print(f"   of {len(found.parameters)} free numbers at an end: {', '.join(bound) or 'none'}")


def main(arguments: list[str] | None = None) -> int:
    """Print the agreement of a few machines."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.agree", description=__doc__)
    owned = [name for name, truth in TRUTHS.items() if truth.shop.file_of is not None]
    parser.add_argument("--truth", choices=owned, required=True)
    parser.add_argument("--cases", type=int, default=3, help="how many (3)")
    parser.add_argument("--careless", action="store_true", help="with the owner's guesses")
    args = parser.parse_args(arguments)
    for seed in range(FIRST, FIRST + args.cases):
        agreement(args.truth, seed, careless=args.careless)
    return 0


if __name__ == "__main__":
    sys.exit(main())
