"""``spindle-drift import``: make run files from spreadsheets, text tables and recorder logs.

Columns are named and converted by their headers; columns that cannot be identified are left out and
reported. A long log is cut into runs at its pauses. All decisions are written to import.toml next
to the runs: correct them there and import again; later logs of the same recorder follow it.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

from tqdm import tqdm

from measurement.doubts import together
from measurement.errors import BadInput
from measurement.importing.log import Imported, import_files
from measurement.importing.mapping import Mapping, adjusted, read_mapping
from measurement.importing.quantities import checked_conversion
from scenarios.arguments import add_json, add_output, add_parameters, parameters_of, tell
from scenarios.assignments import quantity
from scenarios.imported import MAPPING, mapping_in, table_text, write_imported
from scenarios.outputs import FOLDER_OF_RUNS
from spindle_drift.recordings import import_log

NAME = "import"
HELP = "convert a spreadsheet, a text table or a recorder's log to run files"
READS = ("files", "mapping")
WRITES = {"output": FOLDER_OF_RUNS}
RULES = (
    *("time", "every_row_s", "day_first", "timezone"),
    *("split", "pause_s", "cold_after_s", "every_s"),
)
"""Entries of a mapping file that the command line can override."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_parameters(parser, import_log, files={"nargs": "+", "type": Path, "metavar": "FILE"})
    add_output(parser, "folder for the run files", metavar="DIR")
    again = {"action": "append", "default": []}
    add_parameters(
        parser,
        import_log,
        mapping={
            "type": Path,
            "help": "mapping file to follow (default: import.toml in the folder, if it is there)",
        },
        units={"flag": "--unit", "metavar": "HEADER=UNIT", **again},
        axes={"flag": "--axis", "metavar": "HEADER=AXIS", **again},
        time={"metavar": "HEADER"},
        every_row_s={"metavar": "TIME", "type": str},
        timezone={"metavar": "ZONE"},
    )
    order = parser.add_mutually_exclusive_group()
    add_parameters(order, import_log, "day_first")
    order.add_argument(
        "--month-first",
        dest="day_first",
        action="store_false",
        default=None,
        help="03/04 is the 4th of March",
    )
    add_parameters(parser, import_log, "split", "pause_s", "cold_after_s", "every_s")
    add_json(parser, "print JSON instead of a table")


def run(args: argparse.Namespace) -> int:
    """Import, write the folder, and print what became of each column.

    Raises
    ------
    BadInput
        For the first error; nothing is written then.
    """
    beside, followed = args.output / MAPPING, mapping_in(args.output)
    source = args.mapping or (None if followed is None else beside)
    if args.every_row_s is not None:
        args.every_row_s = quantity("--every-row", args.every_row_s, "s", 1e-9, 1e6, "s")
    rules = parameters_of(args, import_log, *RULES)
    mapping = adjusted(read_mapping(source) if source else Mapping(), "import", **rules)
    hidden = len(args.files) < 2 or None
    files = tqdm(args.files, desc="import", unit="file", disable=hidden, leave=False)
    units, axes = _units(args.units), _axes(args.axes)
    imported = import_files(files, mapping, units, axes)
    # Keep what was given now for the next import.
    fresh = args.mapping is None and bool(source is None or args.force or units or axes)
    written = write_imported(
        imported, args.files, args.output, with_mapping=fresh, followed=followed
    )
    if args.json:
        return tell(args, _facts(imported, written))
    print(table_text(imported, written))
    new = {} if source is None else _not_in(mapping.columns, imported)
    alike: dict[str, list[str]] = {}
    for header, text in imported.hints.items():
        alike.setdefault(text.replace(header, "NAME"), []).append(header)
    for text, headers in alike.items():
        said = text if len(headers) > 1 else imported.hints[headers[0]]
        print(f"left out: {', '.join(headers)}: {said}", file=sys.stderr)
    for header, text in imported.asks.items():
        print(f"asked: {header}: {text}", file=sys.stderr)
    for column, text in together(imported.doubts):
        print(f"doubtful: {column} {text}", file=sys.stderr)
    for note in (*imported.notes, *new):
        print(f"note: {note}", file=sys.stderr)
    if fresh:
        print(f"what was decided: {beside}; change it there and import again")
    else:
        print(f"as {source} says")
    return 0


def _units(given: list[str]) -> dict[str, str]:
    units = _by_header("--unit", given, "UNIT")
    for header, unit in units.items():
        checked_conversion(unit, header, "--unit")
    return units


def _axes(given: list[str]) -> dict[str, str]:
    axes = _by_header("--axis", given, "AXIS")
    for header, axis in axes.items():
        if not re.fullmatch("[+-]?[XYZxyz]", axis):
            problem = f"{axis!r} is not allowed: X, Y or Z, or -X where it grows towards -X"
            raise BadInput("--axis", header, problem)
    return axes


def _by_header(option: str, given: list[str], what: str) -> dict[str, str]:
    """Return what was given by header; a header may itself contain an equals sign."""
    table = {}
    for text in given:
        header, equals, value = text.rpartition("=")
        if not equals or not header.strip() or not value.strip():
            raise BadInput(option, "", f"{text!r} is not of the form HEADER={what}")
        table[header.strip()] = value.strip()
    return table


def _not_in(listed: Collection[str], imported: Imported) -> list[str]:
    """Return a line for each column that the mapping file does not name."""
    return [
        f"{header} is new to the mapping file and was read as {rule.name} in {rule.unit}"
        for header, rule in imported.mapping.columns.items()
        if header not in listed and rule.unit
    ]


def _facts(imported: Imported, written: list[Path]) -> dict[str, Any]:
    return {
        "runs": [
            {
                "file": str(file),
                "starts": piece.starts,
                "rows": len(piece.run.frame),
                "rested_s": None if piece.rested_s != piece.rested_s else piece.rested_s,
                "warm_start": piece.warm,
                "columns": [str(name) for name in piece.run.frame.columns],
            }
            for piece, file in zip(imported.pieces, written, strict=True)
        ],
        "left_out": imported.hints,
        "asked": imported.asks,
        "doubtful": [{"column": column, "why": text} for column, text in imported.doubts],
        "notes": list(imported.notes),
    }
