"""How much gap a hidden effect leaves: the calibrated model's residual, beside nothing hidden.

``python -m benchmarks.gap.sizes --cases 3 --effect windage`` prints, per effect and size, the RMS
residual over tolerance of the jig borer's model calibrated to the case, divided by that of the
same case with nothing hidden. The truth's effects have their sizes from this table: strong leaves
about twice the gap of nothing, weak hardly more than it.
"""

from __future__ import annotations

import argparse
import os
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from benchmarks.gap.truth.case import TruthCase, simulate_case
from benchmarks.gap.truth.effects import everything
from benchmarks.gap.truth.effects.base import SIZES
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate

Array = NDArray[np.float64]

TOLERANCE = {"degC": 0.1, "um": 1.0}
DRIVEN = {"T5_degC", "T9_degC"}


class GaussNewton:
    """Gauss-Newton in the logarithms of the parameters, which stay within their ranges."""

    def __init__(self, machine: Machine, frames: list[pd.DataFrame]) -> None:
        self.machine, self.frames = machine, frames
        self.names = [n for n, p in machine.parameters.items() if p.calibrate]
        chosen = [machine.parameters[name] for name in self.names]
        self.start = np.array([p.value for p in chosen])
        ends = np.array([[p.low, p.high] for p in chosen]) / self.start[:, None]
        self.low, self.high = np.sort(np.log(ends), axis=1).T
        self.prior = (self.high - self.low) / 4.0
        self.columns = [
            name
            for name in frames[0].columns
            if name.rsplit("_", 1)[-1] in TOLERANCE and name not in DRIVEN
        ]

    def residual(self, logs: Array, frames: list[pd.DataFrame] | None = None) -> Array:
        """Return (measured - model) / tolerance, shape (sets, samples)."""
        values = {
            name: np.clip(column, *sorted((p.low, p.high)))
            for name, column, p in zip(
                self.names,
                (self.start * np.exp(logs)).T,
                (self.machine.parameters[n] for n in self.names),
                strict=True,
            )
        }
        parts = []
        for frame in frames or self.frames:
            shown = simulate(self.machine, frame, values, step_s=60.0).readings
            every = max(1, round(60.0 / float(np.median(np.diff(frame["time_s"])))))
            for column in self.columns:
                name, unit = column.rsplit("_", 1)
                gap = (frame[column].to_numpy() - shown[name])[:, ::every]
                parts.append(gap / TOLERANCE[unit])
        return np.concatenate(parts, axis=1)

    def fit(self, rounds: int = 4) -> Array:
        """Return the fitted logarithms."""
        logs = np.zeros(len(self.names))
        weight = 1.0 / 20.0  # neighbouring samples say the same
        for _ in range(rounds):
            moved = np.vstack([logs, logs + 0.02 * np.eye(len(logs))])
            moved = np.where(moved > self.high, 2 * logs - moved, moved)
            all_of = self.residual(moved)
            change = np.diag(moved[1:] - logs)
            jacobian = (all_of[1:] - all_of[0]).T / change * weight
            rows = np.vstack([jacobian, np.diag(1.0 / self.prior)])
            right = -np.concatenate([all_of[0] * weight, logs / self.prior])
            bounds = (self.low - logs - 1e-9, self.high - logs + 1e-9)
            logs = np.clip(logs + lsq_linear(rows, right, bounds).x, self.low, self.high)
        return logs


def gap(case: TruthCase) -> tuple[float, float, dict[str, float]]:
    """Return the residual's RMS over tolerance: calibration, held-out, and by channel."""
    runs, _ = simulate_case(case)
    frames = [run.frame for run in runs]
    calibration = GaussNewton(read_machine("jig_borer_lumps"), frames[:4])
    logs = calibration.fit()[None, :]
    both = [
        float(np.sqrt(np.mean(calibration.residual(logs, some) ** 2)))
        for some in (frames[:4], frames[4:])
    ]
    one = calibration.residual(logs, frames[4:])[0]
    by_channel = np.sqrt(np.mean(one.reshape(len(calibration.columns), -1) ** 2, axis=1))
    return both[0], both[1], dict(zip(calibration.columns, by_channel.tolist(), strict=True))


def main(arguments: list[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.sizes", description=__doc__)
    parser.add_argument("--cases", type=int, default=3)
    parser.add_argument("--effect", nargs="*", default=list(everything()))
    parser.add_argument("--size", nargs="*", default=list(SIZES))
    args = parser.parse_args(arguments)
    seeds = [500_000 + k for k in range(args.cases)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        empty = list(pool.map(gap, [TruthCase(seed) for seed in seeds]))
        for (fitted, held, channels), seed in zip(empty, seeds, strict=True):
            shown = " ".join(f"{n.split('_')[0]} {v:.2f}" for n, v in channels.items())
            print(f"nothing hidden, {seed}: {fitted:.2f} held-out {held:.2f}  {shown}", flush=True)
        for name in args.effect:
            jobs = [TruthCase(seed, ((name, size, ""),)) for size in args.size for seed in seeds]
            found = np.array([one[:2] for one in pool.map(gap, jobs)])
            times = found.reshape(len(args.size), len(seeds), 2) / np.array(
                [one[:2] for one in empty]
            )
            cells = [
                f"{size} " + "/".join(f"{v:.2f}" for v in row[:, 1])
                for size, row in zip(args.size, times, strict=True)
            ]
            print(f"{name:24s} " + "   ".join(cells), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
