"""Mistakes in a machine's description: ``python -m benchmarks.gap.mistakes --out DIR``.

The shipped lathe is simulated in six invented runs; the gap finder calibrates on five of them.
Either the simulated machine has something that the machine file does not contain, or an owner's
file lacks one of its items. The gap finder is given the file and the whole catalogue. Because the
truth is a lumped model of the same kind, this shows that a mistake of each kind can be found, and
what calibration absorbs, but not how often that happens on a real machine.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from benchmarks.gap.clock import clocked
from benchmarks.gap.outcome import NONE, RIGHT, named_in, outcome_of_mistake
from benchmarks.results_page import as_table
from gap_finder.find import answer
from gap_finder.kinds.base import Change, fixed
from gap_finder.kinds.coarse_part import CoarsePart
from gap_finder.kinds.conductance_with_motion import ConductanceWithMotion
from gap_finder.kinds.heat_source import HeatSource
from gap_finder.kinds.hidden_mass import HiddenMass
from gap_finder.kinds.moves_axis import MovesAxis
from gap_finder.kinds.sensor_place import SensorPlace
from gap_finder.report import report_of
from gap_finder.search import Search
from measurement.files import write_atomically
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate

HOURS = 5.0

RUNS = {
    "fast_slow": ([0.0, 2.5], [2000, 1000], [5000, 5000], 20.0, 0.0),
    "stop": ([0.0, 1.5, 2.5], [1000, 0, 2000], [5000, 0, 5000], 25.0, -1.0),
    "axes_only": ([0.0, 1.2, 3.0], [1500, 500, 2000], [3000, 5000, 0], 22.0, 1.2),
    "spindle_only": ([0.0, 2.0, 3.5], [800, 1800, 0], [2000, 5000, 5000], 26.0, 0.0),
    "steps": ([0.0, 1.0, 2.0, 4.0], [1000, 2000, 0, 1500], [5000, 0, 2000, 4000], 19.0, 1.0),
    "unseen": ([0.0, 2.0, 3.0], [2000, 0, 1200], [5000, 0, 4000], 18.0, 1.0),
}
"""Hours at which speed [r/min] and feed [mm/min] change, the initial hall temperature [degC] and
its rate [K/h]; the last run is held out."""


@dataclass(frozen=True)
class Mistake:
    """A mistake in the machine file.

    Attributes
    ----------
    kind : str
    place : tuple of str
    truth, told : Machine
        The true machine, and the machine in the file.
    """

    kind: str
    place: tuple[str, ...]
    truth: Machine
    told: Machine

    def outcome(self, answer: dict[str, Any]) -> str:
        """Return the outcome of an answer; if nothing is missing, saying so is right."""
        told = outcome_of_mistake({"kind": self.kind, "place": self.place}, answer)
        return RIGHT if (self.kind, told) == ("nothing", NONE) else told


def mistakes(given: Machine) -> list[Mistake]:
    """Return all mistakes, after a first entry without any."""
    mass = {node.name: node.capacity.value for node in given.nodes}
    found = [Mistake("nothing", (), given, given)]

    def put(change: Change, **numbers: float) -> None:
        found.append(Mistake(change.name, change.place, change.put_into(given, numbers), given))

    put(HeatSource(("z_nut",)), power=40.0)
    put(HeatSource(("tray", "speed")), power=200.0, exponent=1.0)
    put(HeatSource(("bed_end", "feed")), power=400.0, exponent=1.0)
    put(ConductanceWithMotion(("z_nut", "air", "feed")), conductance=10.0)
    put(ConductanceWithMotion(("headstock", "ambient", "speed")), conductance=25.0)
    put(HiddenMass(("z_nut",), mass["z_nut"]), conductance=15.0, capacity=50000.0)
    put(HiddenMass(("tray",), mass["tray"]), conductance=20.0, capacity=60000.0)
    put(CoarsePart(("z_screw",), mass["z_screw"], ("PT05",), False), conductance=3.0)
    put(CoarsePart(("carriage",), mass["carriage"], ("PT13",), False), conductance=5.0)
    put(SensorPlace(("PT08", "bed"), "z_nut", False), share=0.6)
    put(SensorPlace(("TC02", "spindle"), "tray", False), share=0.3)
    put(MovesAxis(("carriage", "X"), 1.0), length=400.0)
    for kind, place, item in (
        ("moves_axis", ("bed", "Z"), ("structure", "bed_length")),
        ("heat_path", ("headstock", "ambient"), ("links", "headstock-ambient")),
        ("heat_path", ("tray", "air"), ("links", "tray-air")),
    ):
        items = tuple(one for one in given.items if (one.family, one.name) != item)
        found.append(Mistake(kind, place, given, replace(given, items=items)))
    # The shipped file lets calibration move the bearing; an owner's says where it is.
    rear = {"at": fixed(20.0, "mm")}
    items = tuple(
        replace(one, parameters=one.parameters | rear) if one.kind == "located" else one
        for one in given.items
    )
    found.append(Mistake("locating_bearing", ("to_nose",), given, replace(given, items=items)))
    return found


def runs_of(machine: Machine, seed: int = 0) -> list[Run]:
    """Return simulated runs of a machine that is not quite in equilibrium at their start."""
    found = []
    for number, (name, (hours, speed, feed, hall, rise)) in enumerate(RUNS.items()):
        time = np.arange(0.0, HOURS * 3600.0 + 1.0, 60.0)
        at = np.searchsorted(np.array(hours) * 3600.0, time, side="right") - 1
        wander = 0.3 * np.sin(time / 1500.0 + number)
        frame = pd.DataFrame(
            {
                "time_s": time,
                "speed_rpm": np.array(speed, dtype=np.float64)[at],
                "feed_mm_min": np.array(feed, dtype=np.float64)[at],
                "TC08_degC": hall + rise * time / 3600.0 + wander,
            }
        )
        generator = np.random.default_rng([seed, number])
        starts = {node.name: hall + generator.normal(0.0, 0.4) for node in machine.nodes}
        for sensor in machine.sensors:
            if sensor.of in starts:
                frame[f"{sensor.name}_degC"] = starts[sensor.of]
        shown = simulate(machine, frame, noise_seed=100 * seed + number)
        found.append(Run(name, shown.run_frame()))
    return found


def asked(mistake: Mistake) -> dict[str, Any]:
    """Run the gap finder on a mistake and return its answer and outcome."""
    runs = runs_of(mistake.truth)
    with clocked() as spent:
        judged, faults = answer(mistake.told, runs[:-1], runs[-1:], Search(workers=1))
    table = report_of(judged, faults)
    named, rivals = named_in(table)
    return {
        "kind": mistake.kind,
        "place": list(mistake.place),
        "verdict": table["verdict"],
        "named": named,
        "or_else": rivals,
        "outcome": mistake.outcome(table),
        "gap": table["gap"]["holdout"],
        "data_faults": [one["text"] for one in table["data_faults"]],
        "seconds": spent["cpu"],
    }


def main(arguments: list[str] | None = None) -> int:
    """Run the gap finder on every mistake, and print a table."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.mistakes", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--kinds", nargs="+", metavar="KIND", help="only mistakes of these")
    args = parser.parse_args(arguments)
    given = read_machine("lathe")
    chosen = [one for one in mistakes(given) if not args.kinds or one.kind in args.kinds]
    answers = []
    args.out.mkdir(parents=True, exist_ok=True)
    for mistake in tqdm(chosen, unit="mistake"):
        answers.append(asked(mistake))
        write_atomically(args.out / "mistakes.json", json.dumps(answers, indent=1) + "\n")
    rows = []
    for one in answers:
        said = (
            "; ".join(f"{name} {_words(place)}" for name, place in one["named"]) or one["verdict"]
        )
        more = f" (or {len(one['or_else'])} more)" if one["or_else"] else ""
        gaps = [f"{one['gap'][when]:.2f}" for when in ("before", "after")]
        made = f"{one['kind']} {_words(one['place'])}"
        rows.append([made, said + more, one["outcome"], *gaps, f"{one['seconds']:.0f}"])
    print(as_table(["Mistake", "Named", "", "Gap before", "after", "CPU [s]"], rows))
    return 0


def _words(place: Any) -> str:
    return " ".join(place) if isinstance(place, list) else str(place)


if __name__ == "__main__":
    sys.exit(main())
