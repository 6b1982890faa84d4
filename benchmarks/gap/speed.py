"""What the gap finder's shortcuts save, each against the plain way, in the same process.

``python -m benchmarks.gap.speed`` simulates two runs of a shipped machine and asks for the same
answers twice. Printed is processor time of the plain way over that of the shortcut, the median of
``--times`` repetitions, and how far the answers differ, in sensor tolerances.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402

from benchmarks.gap.clock import clocked  # noqa: E402
from gap_finder import directions  # noqa: E402
from gap_finder.calibrate import calibrate  # noqa: E402
from gap_finder.candidates import candidates, with_effect  # noqa: E402
from gap_finder.design import all_sensitivities  # noqa: E402
from gap_finder.kinds.base import CalibratedRun, Change  # noqa: E402
from gap_finder.kinds.hidden_mass import HiddenMass  # noqa: E402
from gap_finder.observations import Observations, observe  # noqa: E402
from gap_finder.refit import score_fit  # noqa: E402
from measurement.runs import Run  # noqa: E402
from plant_model import trajectory  # noqa: E402
from plant_model.effects import catalogue  # noqa: E402
from plant_model.machine import Machine  # noqa: E402
from plant_model.machine_file import read_machine  # noqa: E402
from plant_model.parameters import FloatArray  # noqa: E402
from plant_model.simulate import simulate  # noqa: E402


@dataclass(frozen=True)
class Shortcut:
    """One shortcut: its name, what is asked for, and how the plain way is forced."""

    name: str
    ask: Callable[[], FloatArray]
    plainly: Callable[[], Any]


def runs_of(machine: Machine, hours: float) -> list[Run]:
    """Return two runs of a machine as it is: speeds in steps, and a hall that swings."""
    time = np.arange(0.0, hours * 3600.0 + 1.0, 60.0)
    found = []
    for number in (1, 2):
        frame = pd.DataFrame({"time_s": time})
        for entry in machine.inputs:
            still = max(entry.low, 0.0) if entry.default is None else entry.default
            frame[entry.column] = 21.0 + np.sin(time / 4000.0) if entry.is_boundary else still
            if entry.unit == "rpm":
                level = np.array([0.3, 0.8, 0.0, 0.6])[(time // 2700.0 * number).astype(int) % 4]
                frame[entry.column] = level * entry.high
        found.append(Run(f"run_{number}", simulate(machine, frame, noise_seed=number).run_frame()))
    return found


def shortcuts(machine: Machine, observed: Sequence[Observations]) -> Iterator[Shortcut]:
    """Return what is asked both ways."""

    def answers(grown: Machine, name: str) -> FloatArray:
        found = candidates(grown, observed, catalogue()[name])
        return np.concatenate([np.concatenate(one.answers) for one in found])

    def every_set() -> Any:
        def apart(values: Any, others: Any, start: FloatArray) -> tuple[Any, Any]:
            return np.arange(len(start)), np.arange(len(start))

        return patch.object(trajectory, "_distinct", apart)

    preloaded = with_effect(machine, "thermal_preload")
    yield Shortcut(
        "structures beside thermal_preload: temperatures stepped once, not for every set",
        lambda: answers(preloaded, "slow_structure"),
        every_set,
    )
    thermostat = catalogue()["coolant_thermostat"]
    if machine.of_kind("links", "coolant_flow"):
        stepped = property(lambda self: False, lambda self, value: None)
        yield Shortcut(
            "a chiller's swing: computed ahead, not stepped",
            lambda: answers(machine, thermostat.name),
            lambda: patch.object(thermostat, "known_ahead", stepped),
        )
    sensitivities = all_sensitivities(machine, machine, observed)
    known = [
        CalibratedRun(machine, one, part) for one, part in zip(observed, sensitivities, strict=True)
    ]
    masses = list(HiddenMass.all_of(known))[:8]
    one_by_one = classmethod(Change.answers.__func__)  # type: ignore[attr-defined]
    yield Shortcut(
        "eight hidden masses: as paths, not one after another",
        lambda: np.concatenate(HiddenMass.answers(masses, known[0])).ravel(),
        lambda: patch.object(HiddenMass, "answers", one_by_one),
    )
    calibration = calibrate(machine, observed, starts=1, iterations=1)
    with patch.object(directions, "LOST", -1.0):
        every_column = all_sensitivities(machine, machine, observed)
    chosen = {"now": sensitivities}

    @contextmanager
    def all_columns() -> Iterator[None]:
        chosen["now"] = every_column
        yield
        chosen["now"] = sensitivities

    yield Shortcut(
        "a calibrated machine scored run by run: directions that move something, not every column",
        lambda: score_fit(machine, (), observed, calibration, chosen["now"]).loro_cost,
        all_columns,
    )


def compared(one: Shortcut, times: int) -> tuple[float, float]:
    """Return how many times longer the plain way takes, and how far its answers are off."""
    ratios, off = [], 0.0
    for _ in range(times):
        with clocked() as spent:
            quick = one.ask()
        with one.plainly(), clocked() as plain_spent:
            plain = one.ask()
        ratios.append(plain_spent["cpu"] / spent["cpu"])
        off = max(off, float(np.abs(quick - plain).max()))
    return float(np.median(ratios)), off


def main(arguments: list[str] | None = None) -> int:
    """Ask both ways and print the ratios."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.speed", description=__doc__)
    parser.add_argument("machine", nargs="?", default="jig_borer", help="file or shipped name")
    parser.add_argument("--hours", type=float, default=4.0, metavar="H", help="of each run")
    parser.add_argument("--times", type=int, default=3, metavar="N")
    args = parser.parse_args(arguments)
    machine = read_machine(args.machine)
    observed = observe(machine, runs_of(machine, args.hours))
    print(f"{machine.name}: {len(machine.nodes)} parts, two runs of {args.hours:g} h")
    print("plain / shortcut   off by   what")
    for one in shortcuts(machine, observed):
        ratio, off = compared(one, args.times)
        print(f"{ratio:12.1f}   {off:10.2g}   {one.name}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
