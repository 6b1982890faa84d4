"""The LinuxCNC component that talks to the gateway; start it with ``loadusr`` in a HAL file.

It sends its pins' values as the machine's frames, and moves the axes by the offsets that it
receives. The pins of a component called ``thermal``:

=============================== ===============================================================
``thermal.in.NAME``             a number of the machine's frames, ``in.T1`` or ``in.speed``; an
                                unconnected one is *not available*
``thermal.cold``                drift is counted from now
``thermal.enable``              set when all is connected; before, nothing is sent or moved
``thermal.clear``               take the offsets back to zero, as before homing
``thermal.on``, ``.homed``,     the control's state: ``motion.motion-enabled``,
``.coord``, ``.teleop``         ``.is-all-homed``, ``.coord-mode``, ``.teleop-mode``
``thermal.request-z``           the offset that the axis was given: ``axis.z.eoffset-request`` [mm]
``thermal.command-z``           ``axis.z.pos-cmd`` [mm]
``thermal.counts-z``            to ``axis.z.eoffset-counts``, with a scale of 0.00001
``thermal.offset-z``            the same as a length [mm], for ``offset`` with ``limit2``
``thermal.heartbeat``           for a watchdog, whose ``ok-out`` comes back as ``thermal.alive``
``thermal.running``             the offset in force has been taken over: to
                                ``axis.z.eoffset-enable``, so that the counts of a new
                                component, which begin at 0, move nothing
``thermal.wait``                an offset is not in force yet: to ``motion.feed-inhibit``
``thermal.moved``               an axis is moved: to ``motion.homing-inhibit``
``thermal.valid``, ``.status``  as the gateway reports them
``thermal.following``           its offsets are used; otherwise they are held, or given up
=============================== ===============================================================
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from math import nan
from typing import Any

from gateway.control import FOLLOWING, OffsetFollower
from gateway.database import COMPENSATOR, MACHINE, OFFSETS, Database
from gateway.dbc import DBC
from gateway.linuxcnc.axes import COUNT_UM, AxisOffset, Seen
from gateway.linuxcnc.modules import new_component
from gateway.machine import MachineNode, Pace
from gateway.mapping import read_database
from gateway.options import ABOVE_ZERO, AT_LEAST_ZERO, add_bus_arguments, as_served, on_bus
from gateway.proof import read_key
from scenarios.arguments import add_parameters

NAMES = ("x", "y", "z")
WAIT_UM = 0.5
"""The feed waits while an axis is further than this from its offset [um]: set on no data."""
OWN = ("machine_time", "machine_step", "echo", "proof")
"""Numbers of the machine's frames that the component computes itself."""


class ControlPins:
    """The control as seen by the machine's end of the bus, in place of a plant.

    Parameters
    ----------
    pins : mapping
        The component's pins, by name.
    inputs : sequence of str
        Signals to send.
    step_s : float
        The machine's time per cycle [s].
    cycle_s : float
        Length of a cycle [s].
    slew_um_s : float
        How fast an axis may be moved [um/s].
    external : bool
        Whether to use LinuxCNC's external offsets, or offsets between the control and the motors.
    clock : callable
        Monotonic time, which continues when the component is restarted [s].
    """

    done = False

    def __init__(
        self,
        pins: Any,
        inputs: Sequence[str],
        step_s: float,
        cycle_s: float,
        slew_um_s: float,
        *,
        external: bool,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._pins, self._inputs = pins, tuple(inputs)
        self.step_s, self._cycle_s, self._slew = step_s, cycle_s, slew_um_s
        self._external, self._clock = external, clock
        self._axes: list[AxisOffset] = []
        self._begun_s = clock() / cycle_s * step_s
        self._last = clock()
        self.follower: OffsetFollower | None = None
        self.point = 0

    @property
    def time_s(self) -> float:
        """The machine's time, from a clock that continues between two starts [s]."""
        return self._begun_s + self.point * self.step_s

    @property
    def thermal_state(self) -> str:
        """The thermal state, as the frames name it."""
        return "cold" if self._pins["cold"] else "unknown"

    def probe_with(self, names: Sequence[str]) -> None:
        """Do nothing, because nothing is probed."""

    def measured(self, half_widths: Sequence[float]) -> list[float]:
        """Return an empty list, because nothing is probed."""
        return []

    def readings(self) -> dict[str, float]:
        """Return the pins' readings."""
        return {name: self._pins[f"in.{name}"] for name in self._inputs}

    def record(self, offsets: Mapping[str, float], extra: Mapping[str, float]) -> None:
        """Show the gateway's report at the pins."""
        self._pins["valid"] = extra.get("valid") == 1.0
        status = extra.get("status", nan)
        self._pins["status"] = -1 if status != status else int(status)

    @property
    def _following(self) -> bool:
        return self.follower is not None and self.follower.use == FOLLOWING

    def step(self, offsets: Mapping[str, float]) -> None:
        """Move the axes towards the offsets."""
        pins, now = self._pins, self._clock()
        # A delayed component does not make up for the delay in one step.
        elapsed, self._last = min(now - self._last, self._cycle_s), now
        self.point += 1
        pins["heartbeat"] = not pins["heartbeat"]
        # A tripped watchdog is reset when ``running`` rises.
        barked = pins["running"] and not pins["alive"]
        pins["running"] = bool(self._axes) and not barked
        pins["following"] = self._following
        if not self._axes:
            self._axes = [self._taken_up(name) for name in NAMES]
        if not pins["running"]:
            return
        takes = pins["on"] and pins["homed"] and (pins["coord"] or pins["teleop"])
        furthest = 0.0
        for name, axis, signal in zip(NAMES, self._axes, OFFSETS, strict=True):
            wanted = 0.0 if pins["clear"] else offsets[signal]
            seen = Seen(takes, 1e3 * pins[f"request-{name}"], pins[f"command-{name}"])
            axis.step(wanted, seen, elapsed)
            if self._external:
                pins[f"counts-{name}"] = axis.counts
            else:
                pins[f"offset-{name}"] = axis.counts * COUNT_UM / 1e3
            furthest = max(furthest, abs(wanted - axis.in_force_um))
        pins["wait"] = bool(takes and self._following and furthest > WAIT_UM)
        pins["moved"] = not all(axis.at_zero for axis in self._axes)

    def _taken_up(self, name: str) -> AxisOffset:
        """Return an axis that continues from the offset of an earlier component."""
        request_um = 1e3 * self._pins[f"request-{name}"]
        counts = self._pins[f"counts-{name}"] if self._external else round(request_um / COUNT_UM)
        if not self._external:
            self._pins[f"offset-{name}"] = counts * COUNT_UM / 1e3
        return AxisOffset(self._slew, request_um, counts)


def sent_signals(database: Database) -> list[str]:
    """Return the numbers of the machine's frames that come from pins."""
    names = [signal.name for _, signal in database.signals(MACHINE) if not signal.is_enumeration]
    return [name for name in names if name not in OWN]


def new_pins(name: str, inputs: Sequence[str]) -> Any:
    """Make the component and its pins.

    Parameters
    ----------
    name : str
        The component's name.
    inputs : sequence of str
        Signals to send.
    """
    readings = [f"in.{signal}" for signal in inputs]
    places = [f"{what}-{axis}" for what in ("request", "command") for axis in NAMES]
    given = ("cold", "enable", "clear", "on", "homed", "coord", "teleop", "alive")
    shown = ("heartbeat", "running", "wait", "moved", "valid", "following")
    table = {
        ("BIT", "IN"): given,
        ("BIT", "OUT"): shown,
        ("S32", "OUT"): ["status", *(f"counts-{axis}" for axis in NAMES)],
        ("FLOAT", "IN"): [*places, *readings],
        ("FLOAT", "OUT"): [f"offset-{axis}" for axis in NAMES],
    }
    pins = new_component(name, table)
    # Without a watchdog, assume that none has tripped.
    pins["alive"] = True
    for reading in readings:
        pins[reading] = nan
    return pins


def arguments_of(argv: Sequence[str] | None) -> argparse.Namespace:
    """Return the arguments of a command line, with defaults for the rest."""
    parser = argparse.ArgumentParser(prog="gateway.linuxcnc.component")
    add_bus_arguments(parser)
    add = parser.add_argument
    add("--name", default="thermal", help="of the component (thermal)")
    text = "the way in: external offsets, or 'offset' with 'limit2' (external)"
    add("--offsets", choices=("external", "own"), default="external", help=text)
    add("--slew", default=5.0, metavar="UM/S", help="of an axis (5)", **ABOVE_ZERO)
    add("--speed-up", default=1.0, metavar="N", help="thermal time is faster (1)", **ABOVE_ZERO)
    add_parameters(parser, Pace, hold_s=AT_LEAST_ZERO, wait_s=AT_LEAST_ZERO | {"default": 2.0})
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the component until LinuxCNC ends it."""
    args = arguments_of(argv)
    database = as_served(args, read_database(args.dbc or DBC))
    inputs = sent_signals(database)
    pins = new_pins(args.name, inputs)
    cycle_s = database.closing(MACHINE).cycle_s
    control = ControlPins(
        *(pins, inputs, cycle_s * args.speed_up, cycle_s, args.slew),
        external=args.offsets == "external",
    )
    with on_bus(args.name, args, database, COMPENSATOR, args.wait_s) as (_, link, stopped):
        pace = Pace(wait_s=args.wait_s, hold_s=args.hold_s)
        node = MachineNode(
            *(database, control, link, pace),
            stopped=stopped,
            key=args.key and read_key(args.key),
        )
        control.follower = node.follower
        pins.ready()
        while not pins["enable"] and not stopped():
            time.sleep(cycle_s)
        node.run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
