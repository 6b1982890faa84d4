"""The spindle behind LinuxCNC: the plant FMU as a component, driven by what the control does.

The control's spindle speed and tool length drive it, its temperatures come out at pins, and every
step is written down together with where the axes really are: what the nose does.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gateway.database import OFFSETS
from gateway.linuxcnc.modules import linuxcnc_module
from gateway.options import stop_flag
from gateway.plant import MachinePlant
from scenarios.scenario import read_scenario

SCENARIO = Path(__file__).with_name("day.toml")
STEP_S = 0.05
"""A step takes so long [s]."""
POSITIONS = tuple(f"{kind}_{axis}" for axis in "xyz" for kind in ("motor", "command", "eoffset"))
FLAGS = ("on", "homed", "valid", "following", "wait", "moved", "clear", "limited")
NO_OFFSETS = dict.fromkeys(OFFSETS, 0.0)
"""The axes move by the control, not by the plant's own."""


def new_pins(name: str, outputs: Sequence[str]) -> Any:
    """Make the component and its pins.

    Parameters
    ----------
    name : str
        Of the component.
    outputs : sequence of str
        What the plant reads.
    """
    hal = linuxcnc_module("hal")
    pins = hal.component(name)
    for given in ("speed", "tool_length", "velocity", *POSITIONS):
        pins.newpin(given, hal.HAL_FLOAT, hal.HAL_IN)
    for flag in FLAGS:
        pins.newpin(flag, hal.HAL_BIT, hal.HAL_IN)
    pins.newpin("cold", hal.HAL_BIT, hal.HAL_OUT)
    for shown in outputs:
        pins.newpin(shown, hal.HAL_FLOAT, hal.HAL_OUT)
    return pins


def main(argv: Sequence[str] | None = None) -> int:
    """Run the spindle until LinuxCNC ends it."""
    parser = argparse.ArgumentParser(prog="gateway.linuxcnc.spindle")
    parser.add_argument("--plant", type=Path, required=True)
    parser.add_argument("--speed-up", type=float, required=True)
    parser.add_argument("--duration", type=float, required=True, help="[s] of wall time, at most")
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args(argv)
    step_s = STEP_S * args.speed_up
    settings = {"duration_s": args.duration * args.speed_up, "step_s": step_s, "record_s": step_s}
    case = read_scenario(str(SCENARIO), list(settings.items())).cases[0]
    plant = MachinePlant(args.plant, case, recorded=False)
    plant.start()
    pins = new_pins("spindle-plant", sorted(name for name in plant.readings() if name[0] == "T"))
    _show(pins, plant.readings(), cold=True)
    # Line by line, so that nothing is lost with a component that is ended at once.
    with args.out.open("w", buffering=1, newline="") as file, stop_flag() as stopped:
        table = csv.writer(file)
        pins.ready()
        begun, points, cold = time.monotonic(), 0, True
        while not stopped() and not plant.done:
            plant.drive({"speed": pins["speed"], "tool_length": pins["tool_length"]})
            row = {"wall_s": time.time(), "time_s": plant.time_s, **plant.readings()}
            row |= {name: pins[name] for name in ("velocity", *POSITIONS)}
            row |= {flag: int(pins[flag]) for flag in FLAGS}
            if not points:
                table.writerow(row)
            table.writerow(row.values())
            plant.step(NO_OFFSETS)
            points += 1
            cold = cold and pins["speed"] == 0.0
            _show(pins, plant.readings(), cold=cold)
            time.sleep(max(begun + points * STEP_S - time.monotonic(), 0.0))
    plant.close()
    return 0


def _show(pins: Any, readings: Mapping[str, float], *, cold: bool) -> None:
    for name, value in readings.items():
        if name[0] == "T":
            pins[name] = value
    pins["cold"] = cold


if __name__ == "__main__":
    sys.exit(main())
