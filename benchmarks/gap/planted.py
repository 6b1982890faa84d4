"""Effects planted into a real machine's model, on its real schedules and its real hall.

``python -m benchmarks.gap.planted lathe --runs RUN... --holdout RUN --out DIR`` calibrates the
machine to measured runs, puts one effect at a time into it, simulates the same runs (recorded
commands and hall temperature, the sensors' noise and resolution), and asks the gap finder what is
missing in the machine without it. The first case plants nothing. The truth here is the lumped model
itself: this shows what such runs can tell at all, not how the finder does on a real machine.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

# Before numpy is there: the finder's processes keep the cores busy.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

from tqdm import tqdm  # noqa: E402

from gap_finder.calibrate import calibrate  # noqa: E402
from gap_finder.candidates import with_effect  # noqa: E402
from gap_finder.data_faults import without_faults  # noqa: E402
from gap_finder.find import answer  # noqa: E402
from gap_finder.keys import driver_of  # noqa: E402
from gap_finder.observations import observe  # noqa: E402
from gap_finder.report import report_of  # noqa: E402
from gap_finder.search import Search  # noqa: E402
from measurement.errors import BadInput  # noqa: E402
from measurement.files import write_atomically  # noqa: E402
from measurement.runs import Run, read_run  # noqa: E402
from plant_model.effects import catalogue  # noqa: E402
from plant_model.machine import Machine  # noqa: E402
from plant_model.machine_file import read_machine  # noqa: E402
from plant_model.simulate import simulate  # noqa: E402

USUAL = ("", "centrifugal_shift", "column_bending", "forced_convection", "friction_speed_exponent")
"""What is planted unless something else is asked for; "" is nothing."""


def planted(machine: Machine, key: str, runs: list[Run], seed: int) -> list[Run]:
    """Return the runs as the machine with an effect in force would have shown them."""
    truth = machine
    if key:
        nominal = catalogue()[key.partition(":")[0]].parameters
        truth = with_effect(machine, key, {name: p.value for name, p in nominal.items()})
    return [
        Run(run.name, simulate(truth, run.frame, noise_seed=seed + place).run_frame())
        for place, run in enumerate(runs)
    ]


def _said(effect: dict[str, Any]) -> str:
    """Return an effect's name, with what drives it if that is one of several."""
    driver = effect.get("driver", "")
    return f"{effect['name']} by {driver}" if driver else str(effect["name"])


def asked(machine: Machine, key: str, runs: list[Run], held_out: int, seed: int) -> dict[str, Any]:
    """Plant an effect and ask; the last *held_out* runs are kept back."""
    shown = planted(machine, key, runs, seed)
    used, unseen = shown[:-held_out], shown[-held_out:]
    judged, faults = answer(machine, used, unseen, Search(seed=seed))
    table = report_of(judged, faults)
    effects = [_said(one) for one in table["effects"]]
    name = key.partition(":")[0]
    planted_key = _said({"name": name, "driver": driver_of(machine, key)[0]})
    right = effects == [planted_key] if key else table["verdict"] == "none_missing"
    return {
        "planted": key or "nothing",
        "verdict": table["verdict"],
        "named": effects,
        "other_drivers": [one.get("other_drivers", []) for one in table["effects"]],
        "one_of": table["one_of"],
        "right": right,
        "share_explained": table["evidence"]["share_explained"],
        "gap": table["gap"]["holdout"],
        "runners_up": table["runners_up"][:3],
    }


def main(arguments: list[str] | None = None) -> int:
    """Plant, ask, and print what was answered."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.planted", description=__doc__)
    parser.add_argument("machine", help="machine file or shipped name")
    parser.add_argument("--runs", nargs="+", type=Path, required=True, metavar="RUN")
    parser.add_argument("--holdout", nargs="+", type=Path, required=True, metavar="RUN")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--effects", nargs="+", default=list(USUAL), metavar="EFFECT")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(arguments)
    unknown = [k for k in args.effects if k and k.partition(":")[0] not in catalogue()]
    if unknown:
        parser.error(f"--effects: {unknown[0]} is not one of {', '.join(catalogue())}")
    try:
        machine = read_machine(args.machine)
        runs = [read_run(path) for path in (*args.runs, *args.holdout)]
        runs, _ = without_faults(machine, runs)
    except BadInput as error:
        parser.error(str(error))
    count = sum(run.name in {path.stem for path in args.holdout} for run in runs)
    fitted = calibrate(machine, observe(machine, runs[:-count]), starts=1).machine
    answers = []
    for key in tqdm(args.effects, unit="effect"):
        answers.append(asked(fitted, key, runs, count, args.seed))
        write_atomically(args.out / "planted.json", json.dumps(answers, indent=1) + "\n")
    print(f"{'planted':<28}{'answer':<16}{'named':<36}{'held-out gap':>14}")
    for one in answers:
        named = " and ".join(one["named"]) or "-"
        gap = f"{one['gap']['before']:.2f} -> {one['gap']['after']:.2f}"
        mark = "" if one["right"] else "  (wrong)"
        print(f"{one['planted']:<28}{one['verdict']:<16}{named:<36}{gap:>14}{mark}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
