"""What a page is worth: ``python -m benchmarks.drawing --truth 2 --mistakes 2``.

``--truth N``: N machines of the independent fine simulator of ``benchmarks.gap.truth``, drawn
around the sections of the page `jig_borer` (masses and sections within 15 %, joints and
films within a factor of 1.5), nothing missing. The page, with thermometers where that simulator has
them, is calibrated on four runs; what it leaves on the fifth is told in units of sensor noise,
beside the page as it stands, a model that never moves, the machine in lumps (`jig_borer_lumps`)
calibrated on the same runs, and the simulator itself when it is told no more than the page.
``--mistakes N``: the same with a number of the page far from its machine's; which numbers does
calibration then say to look at, the farthest first?
``--around lumps`` draws the machines around those of the gap benchmark instead.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from typing import Any

from benchmarks.gap.agree import never_moves
from benchmarks.gap.around_page import PAGE, drawn_around, page_table
from benchmarks.gap.case import CaseRun, TruthCase
from benchmarks.gap.truth.case import simulate_case
from benchmarks.gap.truth.told import as_told
from gap_finder.calibrate import calibrate
from gap_finder.observations import Observations, observe
from gap_finder.regimes import RunResiduals, by_channel, gap_of, residuals
from measurement.runs import Run
from plant_model.drawing.expand import expanded
from plant_model.machine import Machine
from plant_model.machine_file import machine_from_table, machine_path, read_machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names


def simulator_as_told(machine: Machine, case: TruthCase, run: CaseRun) -> float:
    """Return what the simulator itself leaves on a run, told no more than its file says.

    In noise units.
    """
    frames = (run.frame, as_told(case, run))
    seen, done = (observe(machine, [Run(run.name, frame)])[0] for frame in frames)
    return gap_of(
        machine, [RunResiduals(seen, _from_zero(machine, done) - _from_zero(machine, seen))]
    )


def _from_zero(machine: Machine, observed: Observations) -> FloatArray:
    """Return an observation's values, displacements counted from their first."""
    values = observed.values.copy()
    lengths = set(displacement_names(machine))
    moved = [i for i, name in enumerate(observed.channels) if name in lengths]
    values[:, moved] -= values[0, moved]
    return values


def placed(edit: Callable[[dict[str, Any]], None] | None = None) -> Machine:
    """Return the page's machine with thermometers where the fine simulator has them."""
    path, page = machine_path(PAGE), page_table()
    if edit:
        edit(page)
    return machine_from_table(expanded(page, path), path)


def _half_the_friction(page: dict[str, Any]) -> None:
    page["bearings"][0]["f0"] = {"value": 0.265, "low": 0.15, "high": 0.45}


def _light_carriers(page: dict[str, Any]) -> None:
    for carrier in page["carriers"]:
        carrier["mass"] = {"value": 0.8 * carrier["mass"], "calibrate": True}


def _weak_motor(page: dict[str, Any]) -> None:
    page["motor"]["loss"] = {"value": 11.0, "low": 8.0, "high": 15.0}


def _stiff_bracket(page: dict[str, Any]) -> None:
    page["carriers"][0]["joint"] = {"value": 120.0, "low": 80.0, "high": 180.0}


MISTAKES = {
    "front friction half its machine's": (_half_the_friction, ("sources.front.f0",)),
    "carriers a fifth lighter": (
        _light_carriers,
        ("nodes.pedestal.capacity", "nodes.column.capacity"),
    ),
    "motor loss half its machine's": (_weak_motor, ("sources.motor.loss",)),
    "the pedestal's joint three times its machine's": (
        _stiff_bracket,
        ("numbers.pedestal_holds",),
    ),
}
"""What is wrong in a page: the change, and the numbers to look at."""


def slips(seed: int) -> None:
    """Print to which numbers calibration points when a page has one of the mistakes."""
    runs = [Run(run.name, run.frame) for run in simulate_case(TruthCase(seed))[0]]
    for name, (edit, asked) in {"nothing": (None, ()), **MISTAKES}.items():
        machine = placed(edit)
        observed = observe(machine, runs)
        found = calibrate(machine, observed[:4], starts=1)
        gap = gap_of(machine, [residuals(found.machine, one) for one in observed[4:]])
        far = sorted(
            (entry for entry in found.parameters if entry.is_far),
            key=lambda entry: -abs(entry.deviations),
        )
        told = [
            f"{'*' if entry.name in asked else ''}{entry.name} {entry.deviations:+.1f}"
            for entry in far
        ]
        print(f"machine {seed}, wrong: {name}: leaves {gap:.1f}; look at {', '.join(told)}")


def against_truth(machine: Machine, seed: int) -> None:
    """Print what the page leaves on the run that it never saw."""
    case = TruthCase(seed)
    simulated = simulate_case(case)[0]
    runs = [Run(run.name, run.frame) for run in simulated]
    observed = observe(machine, runs)
    begun = time.process_time()
    found = calibrate(machine, observed[:4], starts=1)
    took = time.process_time() - begun
    unseen = observed[4:]
    none = never_moves(machine, unseen)
    gaps = [
        gap_of(which, [residuals(which, one) for one in unseen])
        for which in (machine, found.machine)
    ]
    lumps = read_machine("jig_borer_lumps")
    seen_by_lumps = observe(lumps, runs)
    calibrated = calibrate(lumps, seen_by_lumps[:4], starts=1).machine
    by_lumps = gap_of(lumps, [residuals(calibrated, one) for one in seen_by_lumps[4:]])
    far = [entry for entry in found.parameters if entry.is_far]
    determined = sum(entry.prior_contraction >= 0.5 for entry in found.parameters)
    print(
        f"machine {seed}: never moves {none:.1f}, page as it stands {gaps[0]:.1f}, calibrated"
        f" {gaps[1]:.1f} noise units; {determined} of {len(found.parameters)} free numbers"
        f" determined, {len(far)} far from usual; {took:.0f} s of one core; the machine in lumps,"
        f" calibrated, {by_lumps:.1f}; the simulator itself, told as much,"
        f" {simulator_as_told(machine, case, simulated[4]):.1f}"
    )
    told = (f"{entry.name} {entry.value:.3g} ({entry.deviations:+.1f})" for entry in far)
    print("   far from usual (deviations): " + ", ".join(told))
    left = by_channel(found.machine, [residuals(found.machine, one) for one in unseen])
    print("   " + ", ".join(f"{name} {value:.2f}" for name, value in left.items()))


def main(argv: list[str] | None = None) -> int:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--truth", type=int, default=0, metavar="N")
    parser.add_argument("--mistakes", type=int, default=0, metavar="N")
    parser.add_argument("--around", choices=("page", "lumps"), default="page")
    args = parser.parse_args(argv)
    with drawn_around(args.around):
        for seed in range(1, args.truth + 1):
            against_truth(placed(), seed)
        for seed in range(1, args.mistakes + 1):
            slips(seed)
    return 0


if __name__ == "__main__":
    sys.exit(main())
