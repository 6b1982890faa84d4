"""A working day at the control, with a program, tool changes and faults; runs in the sandbox.

Only thermal time is accelerated: the axes and the day follow the control's own time. The spindle
records the motion of its nose; this program records its own events.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.linuxcnc.session import PATIENCE_S, Session, running

GRID_MM = 10.0
"""The program stops only at multiples of this distance [mm]: given by its places."""
TOOLS = (
    (1, 8000),
    (2, 10000),
    (1, 12000),
    (3, 6000),
    (1, 12000),
    (2, 10000),
    (1, 8000),
    (3, 12000),
)
"""Tool and spindle speed of each part of the day [rpm]: set on no data."""
LIMIT_MM = 300.0
"""The soft limit of Z [mm]: given by the INI file."""
DWELL_S = 0.4
"""Dwell at the bottom of a hole [s]: set on no data."""
ABORT, STOP, KILLED, KNOWN_PLACE = "abort", "E-stop", "component killed", "at a known place"
STOPS = (ABORT, STOP, KILLED)
"""After one of these events the axes may stand anywhere, until they are at a known place again."""

PROGRAM = """G21 G90 G94 G64
T{tool} M6
G43
S{speed} M3
G0 Z50
O100 repeat [{cycles}]
{holes}
O100 endrepeat
M2
"""
HOLE = """G0 X{x} Y{y}
G1 Z10 F3000
G4 P{dwell}
G0 Z50"""
PLACES = ((0, 0), (40, 0), (40, 30), (0, 30))
"""Positions of the holes [mm]: set on no data."""
CYCLE_S = len(PLACES) * (DWELL_S + 2.4)
"""Approximate duration of one cycle of holes [s]."""


def program(tool: int, speed: int, seconds: float) -> str:
    """Return a program that bores holes for about *seconds* [s]."""
    holes = "\n".join(HOLE.format(x=x, y=y, dwell=DWELL_S) for x, y in PLACES)
    cycles = max(round(seconds / CYCLE_S), 1)
    return PROGRAM.format(tool=tool, speed=speed, cycles=cycles, holes=holes)


class Day:
    """The events of a day.

    Parameters
    ----------
    session : Session
        The control, running.
    part_s : float
        Length of each part of the day [s].
    hold_s : float
        How long offsets are held without a gateway, in real time [s].
    """

    def __init__(self, session: Session, part_s: float, hold_s: float) -> None:
        self._session, self._part_s, self._hold_s = session, part_s, hold_s
        self.events: list[dict[str, float | str]] = []
        self._has_bus = (session.folder / "bus").exists()

    def note(self, name: str, **facts: float) -> None:
        """Record an event that happens now."""
        self.events.append({"name": name, **facts})
        (self._session.folder / "events.json").write_text(json.dumps(self.events, indent=1))
        # The number of events is sampled with everything else.
        self._session.hal("sets", "event", str(len(self.events)))

    def work(self, part: int, share: float = 1.0) -> None:
        """Bore holes for a share of a part of the day."""
        self.begin(part, share)
        self._session.until_idle("the program", 3.0 * self._part_s + PATIENCE_S)

    def begin(self, part: int, share: float = 1.0) -> None:
        """Begin to bore holes, without waiting for the end."""
        tool, speed = TOOLS[part % len(TOOLS)]
        file = self._session.folder / "program.ngc"
        file.write_text(program(tool, speed, self._part_s * share))
        self.note(f"tool {tool}, {speed} rpm")
        self._session.begin(file)

    def run(self, parts: int) -> None:
        """Run the day."""
        session = self._session
        session.switch_on()
        session.home()
        # Drift is counted from the cold spindle, so it must not turn before.
        session.wait(lambda: session.signal("valid") == 1.0, "the machine is not known to be cold")
        faults: list[Callable[[], None]] = [self._abort, self._stop, self._limit, self._clear]
        faults += [self._kill_component]
        if session.has_gateway:
            faults[2:2] = [self._kill_gateway]
        if self._has_bus:
            faults[3:3] = [self._lose_bus]
        self.work(0)
        for part in range(1, parts):
            begun = self._session.now()
            if part <= len(faults):
                self.begin(part)
                self._session.sleep(0.35 * self._part_s)
                faults[part - 1]()
                self._rest()
            left = 1.0 - (self._session.now() - begun) / self._part_s
            self.work(part, max(left, 0.0))
        self.note("end of work")
        session.mdi("M5")
        self._to_zero()

    def _rest(self) -> None:
        """Abort the running program and go to one of its places."""
        self.note(ABORT)
        self._session.abort()
        self._session.mdi("G90 G0 Z50")
        self._session.mdi("G0 X0 Y0")
        self.note(KNOWN_PLACE)

    def _abort(self) -> None:
        self.note(ABORT)
        self._session.abort()
        self._session.sleep(1.0)

    def _stop(self) -> None:
        self.note(STOP)
        self._session.stop()
        self._session.sleep(2.0)
        self.note("on again")
        self._session.switch_on()
        self._session.sleep(2.0)

    def _kill_gateway(self) -> None:
        self.note("gateway killed")
        self._session.kill_gateway()
        self._session.sleep(0.4 * self._hold_s)
        self.note("gateway again")
        self._session.start_gateway()
        self._followed()

    def _lose_bus(self) -> None:
        self._rest()
        self.note("bus lost")
        (self._session.folder / "bus").write_text("down\n")
        self._session.sleep(self._hold_s)
        self.note("offsets given up")
        self._session.wait(lambda: self._session.signal("moved") == 0.0, "offsets stay")
        self.note("bus back")
        (self._session.folder / "bus").write_text("up\n")
        self._followed()
        self.note("offsets back")

    def _followed(self) -> None:
        """Wait until the offsets are followed and in force."""
        session = self._session
        session.wait(lambda: session.signal("following") == 1.0, "offsets are not followed")
        session.wait(lambda: session.signal("wait") == 0.0, "offsets are not in force")

    def _limit(self) -> None:
        session = self._session
        self._rest()
        self.note("to the soft limit")
        session.mdi(f"G53 G0 Z{LIMIT_MM:g}")
        self._session.sleep(2.0)
        self.note("limited", **{"eoffset-limited": session.pin("motion.eoffset-limited")})
        session.mdi("G0 Z50")
        self._session.sleep(1.0)
        self.note("from the soft limit")

    def _clear(self) -> None:
        session = self._session
        self._rest()
        session.mdi("G53 G0 X0 Y0 Z0")
        session.mdi("M5")
        self._to_zero()
        self.note("home")
        session.home()
        session.hal("sets", "clear", "0")
        self._followed()
        self.note("homed")

    def _to_zero(self) -> None:
        """Take the offsets back to zero, and record where the axes are then."""
        session = self._session
        self.note("clear")
        session.hal("sets", "clear", "1")
        session.wait(lambda: session.signal("moved") == 0.0, "the offsets are not cleared")
        self._session.sleep(0.5)
        self.note("cleared", **{axis: session.offset_um(axis) for axis in "xyz"})

    def _kill_component(self) -> None:
        session = self._session
        self.note(KILLED)
        session.kill_component()
        session.wait(lambda: session.signal("hold-feed") == 1.0, "the feed goes on")
        self.note("feed stopped")
        self._session.sleep(2.0)
        self.note("component again")
        session.start_component()
        session.wait(lambda: session.signal("hold-feed") == 0.0, "the feed does not go on")
        self.note("feed again")


def main(argv: Sequence[str] | None = None) -> int:
    """Run a day in a prepared folder."""
    parser = argparse.ArgumentParser(prog="benchmarks.linuxcnc.day")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--part", type=float, required=True, help="[s]")
    parser.add_argument("--parts", type=int, required=True)
    parser.add_argument("--hold", type=float, required=True, help="[s]")
    parser.add_argument("--gateway", type=json.loads, default=[], help="its command, as JSON")
    args = parser.parse_args(argv)
    with running(args.folder, args.gateway) as session:
        day = Day(session, args.part, args.hold)
        try:
            day.run(args.parts)
        except BaseException as error:
            day.note(f"failed: {error}")
            raise
        day.note("end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
