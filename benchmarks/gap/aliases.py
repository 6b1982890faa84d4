"""What the gap finder calls heat that practitioners know by a name of its own.

``python -m benchmarks.gap.aliases`` puts contact seals, a rotary union and what is on in standby
into the shipped jig borer as plain heat in the parts concerned, simulates three runs with the
sensors' noise, and asks what the shipped machine lacks. The truth is the lumped model itself, and
it is one draw: it shows what such heat looks like, not how often it is found.
"""

from __future__ import annotations

import argparse
import os
import sys

# Before numpy is there: the finder's processes keep the cores busy.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402

from gap_finder.find import find_gap  # noqa: E402
from gap_finder.kinds.heat_source import HeatSource  # noqa: E402
from measurement.runs import Run  # noqa: E402
from plant_model.machine import Machine  # noqa: E402
from plant_model.machine_file import read_machine  # noqa: E402
from plant_model.simulate import simulate  # noqa: E402

HOUSING = tuple(f"housing_front_{side}" for side in ("xp", "xm", "yp", "ym"))
KNOWN: dict[str, tuple[tuple[str, str, float], ...]] = {
    "contact seals": (
        ("shaft_front", "speed", 100.0),
        *((part, "speed", 25.0) for part in HOUSING),
    ),
    "rotary union": (("shaft_rear", "speed", 100.0),),
    "standby": (("pedestal", "", 150.0),),
}
"""Parts, what drives the heat (nothing: always on), and how much at full speed [W]."""

RUNS = {
    "down": ((0.0, 12000.0), (1.2, 7000.0), (2.2, 0.0)),
    "stairs": ((0.0, 3000.0), (0.8, 6000.0), (1.6, 9000.0), (2.4, 13000.0)),
    "stops": ((0.0, 10000.0), (0.7, 0.0), (1.1, 14000.0), (1.9, 0.0), (2.4, 8000.0)),
}
"""Hours and speeds [r/min] from then on; each lasts three hours."""


def with_heat(machine: Machine, sources: tuple[tuple[str, str, float], ...]) -> Machine:
    """Return the machine with heat in some parts."""
    for part, driver, power in sources:
        change = HeatSource((part, driver) if driver else (part,))
        machine = change.put_into(machine, change.points()[0] | {"power": power})
    return machine


def recorded(machine: Machine, name: str, seed: int) -> Run:
    """Return one run as the machine shows it."""
    time = np.arange(0.0, 3.0 * 3600.0 + 1.0, 30.0)
    hours, speeds = zip(*RUNS[name], strict=True)
    at = np.searchsorted(np.array(hours) * 3600.0, time, side="right") - 1
    inputs = pd.DataFrame(
        {
            "time_s": time,
            "speed_rpm": np.array(speeds)[at],
            "T5_degC": 21.0 + 0.5 * np.sin(time / 2500.0),
            "T9_degC": 21.0 + 1.5 * (1.0 - np.exp(-time / 5000.0)),
        }
    )
    return Run(name, simulate(machine, inputs, noise_seed=seed).run_frame())


def main(arguments: list[str] | None = None) -> int:
    """Plant, ask, and print what was answered."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.aliases", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--known", nargs="+", choices=KNOWN, default=list(KNOWN))
    args = parser.parse_args(arguments)
    machine = read_machine("jig_borer_lumps")
    for known in args.known:
        truth = with_heat(machine, KNOWN[known])
        runs = [recorded(truth, name, args.seed + i) for i, name in enumerate(RUNS)]
        found = find_gap(machine, runs)
        named = [*found.after.added, *(change.key for change in found.changes)]
        before, after = (float(one.loro_cost.sum()) for one in (found.before, found.after))
        told = " and ".join(named) or "-"
        print(f"{known:<16}{found.verdict:<16}{told:<32}cost {before:.1f} -> {after:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
