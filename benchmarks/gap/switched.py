"""How often a cooler that a thermometer switches is found, with its part.

``python -m benchmarks.gap.switched --cases 6`` hides such a cooler in the first simulator, which
switches it by one of its own thermometers at a setting of its own, asks the gap finder about the
file ``jig_borer_lumps``, and asks again without the law. Machines, runs and settings are drawn.
"""

from __future__ import annotations

import argparse
import os
import sys

# Before numpy is there: cases are asked one after another, each in one process.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

from benchmarks.gap.ask import MACHINE, answered  # noqa: E402
from benchmarks.gap.case import TruthCase  # noqa: E402
from benchmarks.gap.clock import clocked  # noqa: E402
from benchmarks.gap.hidden import SIZES  # noqa: E402
from benchmarks.gap.outcome import groups_of  # noqa: E402
from benchmarks.gap.truth.case import simulate_case  # noqa: E402
from measurement.runs import Run  # noqa: E402
from plant_model.machine_file import read_machine  # noqa: E402

LAW = "coolant_thermostat"
FIRST = {"development": 1_600_000, "reported": 2_600_000}
"""First seed of each split; the plan of cases has others."""


def main(arguments: list[str] | None = None) -> int:
    """Ask about every case twice, and print what was answered."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.switched", description=__doc__)
    parser.add_argument("--split", choices=FIRST, default="development")
    parser.add_argument("--cases", type=int, default=6)
    parser.add_argument("--start", type=int, default=0, help="number of the first case")
    parser.add_argument("--size", choices=SIZES, default="strong")
    args = parser.parse_args(arguments)
    machine = read_machine(MACHINE)
    reads = {sensor.name: sensor.of for sensor in machine.sensors}
    for number in range(args.start, args.start + args.cases):
        case = TruthCase(FIRST[args.split] + number, (("coolant_switched", args.size, ""),))
        made, (hidden,) = simulate_case(case)
        runs = [Run(one.name, one.frame) for one in made]
        setting = f"{hidden.more['on_above_degC']:.1f} -{hidden.more['dead_band_K']:.1f}"
        print(f"{number:04d} {reads[hidden.channel]} {setting}")
        for without in ((), (LAW,)):
            with clocked() as spent:
                _, table = answered(machine, runs[:-1], runs[-1:], without)
            gap = table["gap"]["holdout"]
            named = [
                f"{keys[0]} {effect.get('driver', '')}".strip()
                for keys, effect in zip(groups_of(table), table["effects"], strict=True)
            ]
            print(
                f"  {'without it' if without else 'asked':<11}{table['verdict']:<14}"
                f"{', '.join(named) or '-':<60}{gap['before']:5.1f} -> {gap['after']:.1f}"
                f"{spent['cpu']:6.0f} s",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
