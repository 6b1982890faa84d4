"""Runs to plant faults into: groups of runs of one machine, and what is known to be broken."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.gap.case import TruthCase
from benchmarks.gap.truth.case import simulate_case
from measurement.faults import Fault
from measurement.runs import Run, read_run
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate

GROUP = 4
"""Runs looked at together [1]."""
Group = list[Run]


def setting(lathe: Path | None, cases: int, seed: int) -> Iterator[tuple[str, Group]]:
    """Yield source and group of what the thresholds were set on."""
    for number in range(cases):
        yield "simulated jig borer", _jig_borer(seed + number)
    if lathe is not None:
        yield from (("lathe, even runs", group) for group in _lathe(lathe, 0))


def report(
    lathe: Path | None, spindle: Path | None, cases: int, seed: int
) -> Iterator[tuple[str, Group]]:
    """Yield source and group of what the figures are reported on."""
    if lathe is not None:
        yield from (("lathe, odd runs", group) for group in _lathe(lathe, 1))
    if spindle is not None:
        yield "electric spindle", _pieces(read_run(spindle))
    for number in range(cases):
        names = ("run_1", "run_2", "run_3", "run_4")
        runs, _ = simulate_case(TruthCase(seed + number, runs=names))
        yield "independent simulator", [Run(run.name, run.frame) for run in runs]


def is_known(fault: Fault) -> bool:
    """Return whether a fault of the measured lathe is real: named with the data, or looked up.

    PT10 broke on 20200821; displacement stands during stops; another recording is joined on at the
    end of 20200706; the three motors' thermometers stand for the last 160 min of 20200907.
    """
    if fault.run == "20200706" and fault.start_s > 320 * 60.0:
        return True
    if fault.run == "20200907" and fault.column.endswith("motor_degC"):
        return fault.kind in ("frozen", "saturated")
    if fault.column == "PT10_degC":
        return "20200821" <= fault.run <= "20201005"
    return fault.column.startswith("disp_") and fault.kind in ("frozen", "saturated")


def is_sound(run: Run, column: str) -> bool:
    """Return whether nothing is known to be broken in a column of a measured run."""
    if column == "PT10_degC":
        return not "20200821" <= run.name <= "20201005"
    return not (run.name == "20200907" and column.endswith("motor_degC"))


def _lathe(folder: Path, parity: int) -> Iterator[Group]:
    paths = sorted(folder.glob("2*.csv"))[parity::2]
    for start in range(0, len(paths), GROUP):
        yield [read_run(path) for path in paths[start : start + GROUP]]


def _pieces(run: Run) -> Group:
    """Cut one long record into runs of equal length."""
    cuts = np.linspace(0, len(run.frame), GROUP + 1).astype(int)
    return [
        Run(f"{run.name}_{number}", run.frame.iloc[first:last])
        for number, (first, last) in enumerate(pairwise(cuts), 1)
    ]


def _jig_borer(seed: int) -> Group:
    """Return runs of random levels of speed in a random hall."""
    rng = np.random.default_rng(seed)
    machine = read_machine("jig_borer_lumps")
    every = float(rng.choice([20.0, 40.0, 60.0, 120.0]))
    runs = []
    for number in range(GROUP):
        time = np.arange(0.0, 3600.0 * rng.uniform(4.0, 8.0), every)
        levels = int(rng.integers(2, 8))
        starts = np.sort(rng.uniform(0.0, 0.9 * time[-1], levels))
        speeds = np.r_[0.0, rng.uniform(2000.0, 18000.0, levels) * (rng.random(levels) > 0.2)]
        hall = rng.uniform(18.0, 26.0) + rng.uniform(-2.0, 2.0) * np.sin(time / 8000.0)
        coolant = rng.uniform(19.0, 23.0) + rng.uniform(0.0, 2.0) * (1 - np.exp(-time / 5000.0))
        inputs = pd.DataFrame(
            {
                "time_s": time,
                "speed_rpm": speeds[np.searchsorted(starts, time)].round(-2),
                "T5_degC": hall,
                "T9_degC": coolant,
            }
        )
        frame = simulate(machine, inputs, noise_seed=seed + number).run_frame()
        runs.append(Run(f"run_{number}", frame))
    return runs
