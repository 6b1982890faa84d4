"""Registers of a control, for whatever carries them there (``--registers``)."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from gateway.background import Background
from gateway.controls import controls
from gateway.controls.base import Control, Write
from gateway.database import OFFSETS
from gateway.protocols.base import Adapter, Participant, Report, Say

if TYPE_CHECKING:
    from gateway.database import Database
    from gateway.unit import CompensatorUnit


class RegisterLines(Participant):
    """Prints each register that changes, a line of JSON for an answer.

    Parameters
    ----------
    control : Control
        Whose registers.
    show : callable
        Takes a line; must not wait.
    done : callable, optional
        Called at the end.
    """

    def __init__(
        self,
        control: Control,
        show: Callable[[str], None],
        done: Callable[[], object] = lambda: None,
    ) -> None:
        self._control, self._show, self._done = control, show, done
        self._tell(control.start())

    def update(self, now: float, report: Callable[[], Report]) -> None:
        """Print what the newest answer changes."""
        answer = report().answer
        offsets = {
            name: float(answer[name]) for name in OFFSETS if isinstance(answer.get(name), float)
        }
        self._tell(self._control.writes(offsets))

    def close(self) -> None:
        """Print what is left."""
        self._done()

    def _tell(self, writes: list[Write]) -> None:
        if writes:
            self._show(json.dumps({write.address: write.value for write in writes}))


class Registers(Adapter):
    """What a control is to be given, on standard output."""

    @classmethod
    def add_arguments(cls, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""
        text = "print the registers of such a control, a line of JSON for each change"
        parser.add_argument("--registers", choices=tuple(controls()), help=text)

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Begin to print."""
        if self.args.registers is None:
            return None

        printer = Background()

        def show(line: str) -> None:
            printer.do(lambda: print(line, flush=True))

        return RegisterLines(controls()[self.args.registers](), show, printer.close)
