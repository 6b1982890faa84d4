"""Prints register values for a control (``--registers``).

A control is described by a file: the register for each offset, its unit, and how far one write may
change it. Writing them (by the PLC's program, OPC UA, ADS, FOCAS) is left to the machine.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from gateway.background import Background
from gateway.mapfile import CONTROLS, Form, Name, named_file, read_form
from gateway.protocols.base import Adapter, Participant, Report, Say
from measurement.errors import one_line
from measurement.rig import AXES

if TYPE_CHECKING:
    from gateway.database import Database
    from gateway.unit import CompensatorUnit

Value = float | int | bool


class Control(Form):
    """A control's registers."""

    title: Name
    source: Name
    """The manual that it follows."""
    step_um: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    """What a register's last digit is worth."""
    most_um: Annotated[float, Field(gt=0.0)] = inf
    """The largest offset that a register holds."""
    most_at_once_um: Annotated[float, Field(gt=0.0)] = inf
    """By how much one write may change it."""
    in_mm: bool = False
    """Whether a register holds millimetres, and not a whole number of steps."""
    start: dict[str, int | bool | float] = Field(default_factory=dict)
    """What is written once, before the first offset."""
    registers: dict[Literal["X", "Y", "Z"], Name]


class RegisterLines(Participant):
    """Prints all registers, then those that change, one line of JSON per answer.

    Parameters
    ----------
    control : Control
        The control; it holds the offsets with which the compensator begins.
    show : callable
        Takes a line; must not wait.
    done : callable
        Called at the end.
    """

    def __init__(
        self,
        control: Control,
        show: Callable[[str], None],
        done: Callable[[], object] = lambda: None,
    ) -> None:
        self._control, self._show, self._done = control, show, done
        self._digits: dict[str, int | None] = {}

    def update(self, now: float, report: Callable[[], Report]) -> None:
        """Print the registers that the newest answer changes; a missing offset changes none."""
        shown = report()
        if not self._digits:
            # Whatever the control holds, its registers begin with the compensator's offsets, which
            # after a restart are those that it takes up.
            self._digits = dict.fromkeys(AXES)
            self._tell(self._control.start | self._moved(shown.outputs, inf))
        self._tell(self._moved(shown.answer, self._control.most_at_once_um))

    def _moved(self, offsets: Mapping[str, object], most_at_once_um: float) -> dict[str, Value]:
        """Move the digits towards offsets, as far as one write may go; return those that change."""
        control, writes = self._control, dict[str, Value]()
        for axis, register in control.registers.items():
            offset, before = offsets.get(f"d{axis}"), self._digits[axis] or 0
            if isinstance(offset, float) and isfinite(offset):
                change_um = _within(offset, control.most_um) - before * control.step_um
                digits = before + round(_within(change_um, most_at_once_um) / control.step_um)
                # Without the rounding error of the binary division.
                in_mm = round(digits * control.step_um / 1e3, 9)
                value = in_mm if control.in_mm else digits
                writes |= {register: value} if digits != self._digits[axis] else {}
                self._digits[axis] = digits
        return writes

    def close(self) -> None:
        """Print the remaining lines."""
        self._done()

    def _tell(self, writes: Mapping[str, Value]) -> None:
        if writes:
            self._show(json.dumps(writes))


def _within(value: float, most: float) -> float:
    return min(max(value, -most), most)


class Registers(Adapter):
    """A control's register values on standard output."""

    @classmethod
    def add_arguments(cls, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""
        controls = ", ".join(sorted(path.stem for path in CONTROLS.glob("*.toml")))
        text = "print the registers of a control, in lines of JSON"
        parser.add_argument("--registers", metavar="NAME", help=f"{text}: {controls}, or a file")

    def check(self) -> None:
        """Read the control's file."""
        if self.args.registers is not None:
            path = named_file("--registers", self.args.registers, CONTROLS)
            self._control = read_form(Control, path)

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Begin to print."""
        if self.args.registers is None:
            return None
        printer, lost = Background(), list[str]()

        def put(line: str) -> None:
            try:
                print(line, flush=True)
            except (OSError, ValueError) as error:
                if not lost:
                    lost.append(one_line(error))
                    say(f"--registers: nobody takes them ({lost[0]}); the gateway goes on without")

        def show(line: str) -> None:
            printer.do(lambda: put(line))

        return RegisterLines(self._control, show, printer.close)
