"""The command line: ``spindle-drift COMMAND``.

A command is a file in ``spindle_drift/commands`` or ``gateway/commands`` with ``NAME``, ``HELP``,
``add_arguments(parser)`` and ``run(args)``, which returns the exit code. NAME and HELP are read
without importing the file, so that help is quick whatever the commands import. ``READS`` and
``WRITES`` name the arguments that are files: see `scenarios.outputs`.

Exit codes: 0; 2 for unusable input (one line on standard error); 1 for an FMU that failed (one
line) or a bug (a traceback); 130 if interrupted, 143 if terminated.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from measurement.stops import LOOK_S
from scenarios.entry import interrupted
from scenarios.version import PROGRAM, version

ROOMS = ("spindle_drift", "gateway")
"""Packages with a folder of ``commands``; by name, since this package may not import them."""
TERMINATED = 128 + signal.SIGTERM
"""Exit code after SIGTERM, as a shell returns it."""
DESCRIPTION = """\
Measures, models and compensates the thermal drift of machine-tool spindles.

A spindle warms up and its nose moves. A compensator takes temperatures and the speed and sends
offsets to the axes. Here both are FMUs, and scenarios run them in a loop.
"""
EXAMPLES = """\
examples:
  spindle-drift list
  spindle-drift run step_speed --out results/step_speed
  spindle-drift fit RUN.csv RUN.csv -o compensator.json
  spindle-drift replay compensator.json OTHER_RUN.csv --out results/replay

'spindle-drift COMMAND --help' shows a command's options.
"""


class UsageError(Exception):
    """A command line that cannot be understood; the text is one line."""


class _Parser(argparse.ArgumentParser):
    """A parser whose refusals have the same form as all others."""

    def error(self, message: str) -> Any:
        """Refuse the command line."""
        raise UsageError(f"{message} (see '{self.prog} --help')")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments without the program's name; by default those of the process.
    """
    return reported(lambda: _run(list(sys.argv[1:] if argv is None else argv)))


def reported(work: Callable[[], int]) -> int:
    """Return the exit code of a program's work, and report in one line whatever ends it early.

    Parameters
    ----------
    work : callable
        Returns its exit code.
    """
    try:
        with _ending_in_order():
            return work()
    except SystemExit as end:  # --help, --version, SIGTERM
        if end.code == TERMINATED:
            return _say("terminated: what was not finished is removed", TERMINATED)
        return int(end.code or 0)
    except KeyboardInterrupt:
        return interrupted()
    except BrokenPipeError:
        # The reader of the pipe is gone; a second failure on closing must be silent.
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
        return 0
    except Exception as error:
        if isinstance(error, OSError) and _is_full(error):
            where = error.filename or f"the results, or {tempfile.gettempdir()}"
            return _say(f"{where}: cannot be written: {error.strerror}", 2)
        code = _code(error)
        if code is None:
            traceback.print_exc()
            return _say(f"this is a mistake in {PROGRAM}, not in your input", 1)
        return _say(_text(error), code)


@contextlib.contextmanager
def _ending_in_order() -> Iterator[None]:
    """Let SIGTERM end the program by an exception, so that temporary folders are removed.

    An exception raised while an object is deleted, or inside a library's ``except:``, gets lost. So
    the signal is sent again until the program is ending.
    """
    again: list[threading.Timer] = []

    def end(number: int, frame: object) -> None:
        again.append(threading.Timer(LOOK_S, os.kill, (os.getpid(), number)))
        again[-1].daemon = True
        again[-1].start()
        handled = sys.exc_info()[1]
        while handled is not None and not _is_termination(handled):
            handled = handled.__context__
        if handled is None:
            raise SystemExit(TERMINATED)

    def lost(report: Any) -> None:
        if not _is_termination(report.exc_value):
            usual_report(report)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual, usual_report = signal.signal(signal.SIGTERM, end), sys.unraisablehook
    sys.unraisablehook = lost
    try:
        yield
    finally:
        for timer in again:
            timer.cancel()
        sys.unraisablehook = usual_report
        signal.signal(signal.SIGTERM, usual)
    if again:
        raise SystemExit(TERMINATED)


def _is_termination(error: BaseException | None) -> bool:
    return isinstance(error, SystemExit) and error.code == TERMINATED


def _run(argv: list[str]) -> int:
    shipped = commands()
    parser = _Parser(
        PROGRAM,
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {version()}")
    inner = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for name, (_, text) in shipped.items():
        command = inner.add_parser(name, help=text)
        if argv and argv[0] == name:
            module, chosen = import_module(shipped[name][0]), command
            _declare(module, command)
    if not argv:
        parser.print_help()
        return 0
    args, unknown = parser.parse_known_args(argv)
    if not args.command:
        raise UsageError(f"a command is needed: {', '.join(shipped)} (see '{PROGRAM} --help')")
    if unknown:  # refused by the command, whose help lists its arguments
        chosen.error(f"unrecognized arguments: {' '.join(unknown)}")
    return _guarded(module, args)


def parser_of(name: str) -> argparse.ArgumentParser:
    """Return the parser of one command, as ``spindle-drift NAME --help`` shows it."""
    command = _Parser(f"{PROGRAM} {name}")
    _declare(import_module(commands()[name][0]), command)
    return command


def _declare(module: ModuleType, command: argparse.ArgumentParser) -> None:
    said = (module.__doc__ or "").removeprefix(f"``{command.prog}``: ")
    command.description = said[:1].upper() + said[1:]
    module.add_arguments(command)
    if getattr(module, "WRITES", None):
        command.add_argument(
            "--force", action="store_true", help="overwrite whatever is in the way"
        )


def _guarded(module: ModuleType, args: argparse.Namespace) -> int:
    """Run a command, which may overwrite only its own files."""
    from scenarios.outputs import guarding_command

    args.force = getattr(args, "force", False)
    reads, writes = getattr(module, "READS", ()), getattr(module, "WRITES", {})
    with guarding_command(module.NAME, args, reads, writes):
        code: int = module.run(args)
    return code


@cache
def commands() -> dict[str, tuple[str, str]]:
    """Return every command's module and one line of help, without importing it."""
    by_name = {}
    for room, path in _files():
        constants = {
            statement.targets[0].id: ast.literal_eval(statement.value)
            for statement in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(statement, ast.Assign)
            and isinstance(statement.targets[0], ast.Name)
            and statement.targets[0].id in ("NAME", "HELP")
        }
        by_name[constants["NAME"]] = (f"{room}.commands.{path.stem}", constants["HELP"])
    return by_name


def _files() -> list[tuple[str, Path]]:
    top = Path(__file__).parents[1]
    paths = [(room, path) for room in ROOMS for path in (top / room / "commands").glob("[a-z]*.py")]
    return sorted(paths, key=lambda entry: entry[1].stem)


def _is_full(error: OSError) -> bool:
    from measurement.files import FULL

    return error.errno in FULL


def _code(error: Exception) -> int | None:
    """Return the exit code of an error that is reported in one line; None for a bug."""
    if isinstance(error, UsageError):
        return 2
    # By name, so that nothing heavy is imported for the comparison: if such an error exists, its
    # module is already loaded.
    for module, name, code in (
        ("measurement.errors", "BadInput", 2),
        ("fmu_compensator.runtime.fields", "ModelFileError", 2),
        ("plant_model.parameters", "ParameterError", 2),
        ("scenarios.fmu", "FmuError", 1),
    ):
        kind = getattr(sys.modules.get(module), name, None)
        if kind is not None and isinstance(error, kind):
            return code
    return None


def _text(error: Exception) -> str:
    if not hasattr(error, "place"):
        return str(error)
    from measurement.errors import BadInput

    # The runtime's class, which imports nothing from other rooms, counts items from zero.
    parts = (str(getattr(error, name)) for name in ("source", "place", "problem"))
    return str(BadInput(*parts))


def _say(text: str, code: int) -> int:
    print(f"{PROGRAM}: error: {' '.join(text.split())}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
