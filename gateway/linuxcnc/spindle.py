"""The spindle behind LinuxCNC: the plant FMU as a component, driven by what the control does.

The control's spindle speed and tool length drive it, and its temperatures come out at pins. What
the nose does is written down in the control's own time: its thread samples where the axes really
are, together with the number of the plant's step.

Thermal time is faster than that on the wall, and so would be the delays of a busy computer: a
compensator that is looked at late would have minutes of drift to catch up with. So the plant takes
so many steps for a look of the component, and waits for the next one, unless the watchdog says that
it is dead. It begins with the first look: what it drifts before that nobody could know of.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from gateway.database import OFFSETS
from gateway.linuxcnc.modules import linuxcnc_module, new_component
from gateway.options import stop_flag
from gateway.plant import MachinePlant
from scenarios.scenario import read_scenario

SCENARIO = Path(__file__).with_name("day.toml")
STEPS_A_LOOK = 3
"""The plant takes so many steps between two looks of the component, at most: set on no data."""
SERVO_S, EVERY = 0.005, 10
"""The control's own cycle [s], given by the INI file; so many make a row, ten a second being
enough."""
STEP_S = EVERY * SERVO_S
"""A step of the plant takes as long on the wall as a row [s]."""
SAMPLED = (
    *("motor_x", "motor_y", "motor_z", "command_x", "command_y", "command_z", "velocity"),
    *("point", "event", "homed", "valid", "wait", "clear", "limited", "heartbeat"),
)
"""What the sampler is connected to, in this order; the first seven are numbers."""
KINDS = "fffffffssbbbbbb"
NO_OFFSETS = dict.fromkeys(OFFSETS, 0.0)
"""The axes move by the control, not by the plant's own."""


class Table:
    """What the control's thread sampled, with what the plant showed at the time.

    Parameters
    ----------
    pins : HAL component
        The plant's.
    file : text stream
        Takes the rows.
    """

    def __init__(self, pins: Any, file: Any) -> None:
        hal, self._pins = linuxcnc_module("hal"), pins
        self._samples = hal.stream(pins, hal.sampler_base, KINDS)
        self._rows = csv.writer(file)
        self._shown: list[dict[str, float]] = []

    def show(self, readings: dict[str, float]) -> int:
        """Keep what the plant shows from now on; return its number."""
        if not self._shown:
            self._rows.writerow(["servo_s", *readings, *SAMPLED])
        self._shown.append(readings)
        return len(self._shown) - 1

    def write(self) -> None:
        """Write down what was sampled meanwhile, and show the control's time."""
        while self._samples.readable:
            values = self._samples.read()
            number = self._samples.sampleno
            self._pins["servo_s"] = number * SERVO_S
            if number % EVERY == 0:
                sampled = dict(zip(SAMPLED, values, strict=True))
                shown = self._shown[sampled["point"]]
                cells = [number * SERVO_S, *shown.values(), *sampled.values()]
                self._rows.writerow(float(cell) for cell in cells)


class Looks:
    """Waits for the component, which shows a heartbeat at each of its looks."""

    def __init__(self, pins: Any, stopped: Callable[[], bool]) -> None:
        self._pins, self._stopped = pins, stopped
        self._beat, self._steps, self._begun = False, 0, False
        self._due = time.monotonic()

    def wait(self) -> bool:
        """Wait until the plant may take its next step; return whether it may begin at all."""
        # One that was late does not hurry afterwards.
        now = time.monotonic()
        self._due = max(self._due + STEP_S, now)
        time.sleep(self._due - now)
        self._steps += 1
        while True:
            if self._pins["heartbeat"] != self._beat:
                self._beat, self._steps, self._begun = not self._beat, 0, True
            dead = self._begun and not self._pins["alive"]
            if self._steps < STEPS_A_LOOK or dead or self._stopped() or not self._begun:
                return self._begun
            time.sleep(STEP_S / 10)


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
    temperatures = sorted(name for name in plant.readings() if name[0] == "T")
    table = {
        ("FLOAT", "IN"): ("speed", "tool_length"),
        ("BIT", "IN"): ("alive", "heartbeat"),
        ("BIT", "OUT"): ("cold",),
        ("S32", "OUT"): ("point",),
        ("FLOAT", "OUT"): ("servo_s", *temperatures),
    }
    pins = new_component("spindle-plant", table)
    # Line by line, so that nothing is lost with a component that is ended at once.
    with args.out.open("w", buffering=1, newline="") as file, stop_flag() as stopped:
        rows, looks, cold, ready = Table(pins, file), Looks(pins, stopped), True, False
        while not stopped() and not plant.done:
            plant.drive({"speed": pins["speed"], "tool_length": pins["tool_length"]})
            readings = plant.readings()
            for name in temperatures:
                pins[name] = readings[name]
            cold = cold and pins["speed"] == 0.0
            pins["cold"] = cold
            pins["point"] = rows.show({"time_s": plant.time_s, **readings})
            if not ready:
                pins.ready()
                ready = True
            rows.write()
            if looks.wait():
                plant.step(NO_OFFSETS)
    plant.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
