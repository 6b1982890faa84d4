"""``spindle-drift import``: run files from spreadsheets, text tables and logs of any recorder.

Columns are named and converted by their headers; what cannot be placed is left out and told. A long
log is cut into runs at its pauses. What was decided stands in import.toml beside the runs: mend it
there and import again, and later logs of the same recorder follow it.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any

from scenarios.outputs import FOLDER_OF_RUNS

NAME = "import"
HELP = "make run files of a spreadsheet, a text table or a recorder's log"
READS = ("files", "mapping")
WRITES = {"output": FOLDER_OF_RUNS}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="text table, .xlsx, .xls, .ods, .tdms or .mf4",
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the run files"
    )
    parser.add_argument(
        "--mapping",
        type=Path,
        metavar="FILE",
        help="mapping file to follow (import.toml in the folder, where there is one)",
    )
    parser.add_argument(
        "--unit",
        action="append",
        default=[],
        metavar="HEADER=UNIT",
        help="unit of a column whose header has none, such as 'T*=degC'; may be repeated",
    )
    parser.add_argument(
        "--axis",
        action="append",
        default=[],
        metavar="HEADER=AXIS",
        help="axis that a displacement measures, such as 'Dia*=X', or -X where it grows towards "
        "-X; may be repeated",
    )
    parser.add_argument("--time", metavar="HEADER", help="column of time, if it cannot be told")
    parser.add_argument(
        "--every-row",
        metavar="TIME",
        help="for tables without a column of time: from row to row, such as 60s",
    )
    order = parser.add_mutually_exclusive_group()
    order.add_argument(
        "--day-first", action="store_true", default=None, help="03/04 is the 3rd of April"
    )
    order.add_argument(
        "--month-first", action="store_true", default=None, help="03/04 is the 4th of March"
    )
    parser.add_argument("--timezone", metavar="ZONE", help="of local times, as Europe/Berlin")
    parser.add_argument(
        "--split",
        choices=("pauses", "days", "none"),
        help="where a log is cut into runs (pauses); days: at midnight, too",
    )
    parser.add_argument(
        "--pause", type=float, metavar="SECONDS", help="a longer pause ends a run (1800)"
    )
    parser.add_argument(
        "--cold-after",
        type=float,
        metavar="SECONDS",
        help="a machine is cold after a longer rest (28800)",
    )
    parser.add_argument(
        "--every", type=float, metavar="SECONDS", help="put the rows on an even grid"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def run(args: argparse.Namespace) -> int:
    """Import, write the folder, and say what became of every column.

    Raises
    ------
    BadInput
        For the first thing that cannot be used; nothing is written then.
    """
    from tqdm import tqdm

    from measurement.importing.log import import_files
    from measurement.importing.mapping import Mapping, read_mapping
    from scenarios.imported import MAPPING, table_text, write_imported

    beside = args.output / MAPPING
    source = args.mapping or (beside if beside.exists() else None)
    mapping = _adjusted(read_mapping(source) if source else Mapping(), args)
    hidden = len(args.files) < 2 or not sys.stderr.isatty()
    files = tqdm(args.files, desc="import", unit="file", disable=hidden, leave=False)
    units, axes = _units(args.unit), _axes(args.axis)
    found = import_files(files, mapping, units, axes)
    # What was said now is to be remembered for the next import.
    fresh = args.mapping is None and bool(source is None or args.force or units or axes)
    written = write_imported(found, args.files, args.output, with_mapping=fresh)
    if args.json:
        print(json.dumps(_facts(found, written), indent=1, ensure_ascii=False))
        return 0
    print(table_text(found, written))
    new = {} if source is None else _not_in(mapping.columns, found)
    for header, text in found.hints.items():
        print(f"left out: {header}: {text}", file=sys.stderr)
    for header, text in found.asks.items():
        print(f"asked: {header}: {text}", file=sys.stderr)
    for column, text in found.doubts:
        print(f"doubtful: {column} {text}", file=sys.stderr)
    for note in (*found.notes, *new):
        print(f"note: {note}", file=sys.stderr)
    if fresh:
        print(f"what was decided: {beside}; change it there and import again")
    else:
        print(f"as {source} says")
    return 0


def _adjusted(mapping: Any, args: argparse.Namespace) -> Any:
    """Return a mapping with what the command line says otherwise."""
    from measurement.errors import checked

    table = mapping.model_dump(exclude_none=True)
    table |= {
        key: value
        for key, value in (
            ("split", args.split),
            ("pause_s", args.pause),
            ("cold_after_s", args.cold_after),
            ("every_s", args.every),
        )
        if value is not None
    }
    if args.time:
        table["time"]["columns"] = [args.time]
    if args.every_row is not None:
        table["time"]["every_row_s"] = _seconds(args.every_row)
    if args.day_first or args.month_first:
        table["time"]["day_first"] = bool(args.day_first)
    if args.timezone:
        table["time"]["timezone"] = args.timezone
    return checked(type(mapping), table, "import")


def _units(given: list[str]) -> dict[str, str]:
    from measurement.errors import BadInput
    from measurement.importing.quantities import checked_conversion

    units = _by_header("--unit", given, "UNIT")
    for header, unit in units.items():
        checked_conversion(unit, header, lambda problem: BadInput("--unit", "", problem))
    return units


def _axes(given: list[str]) -> dict[str, str]:
    from measurement.errors import BadInput

    axes = _by_header("--axis", given, "AXIS")
    for header, axis in axes.items():
        if not re.fullmatch("[+-]?[XYZxyz]", axis):
            problem = f"{axis!r} is not allowed: X, Y or Z, or -X where it grows towards -X"
            raise BadInput("--axis", header, problem)
    return axes


def _by_header(option: str, given: list[str], what: str) -> dict[str, str]:
    """Return what was given by header; a header may itself hold an equals sign."""
    from measurement.errors import BadInput

    table = {}
    for text in given:
        header, equals, value = text.rpartition("=")
        if not equals or not header.strip() or not value.strip():
            raise BadInput(option, "", f"{text!r} is not of the form HEADER={what}")
        table[header.strip()] = value.strip()
    return table


def _seconds(text: str) -> float:
    """Return a time such as ``60s``, ``1min`` or ``60`` in seconds."""
    from measurement.errors import BadInput
    from measurement.importing.quantities import conversion_of

    parts = re.fullmatch(r"\s*([0-9]*\.?[0-9]+)\s*([a-z]*)\s*", text)
    kind = conversion_of(parts[2] or "s") if parts else None
    if parts is None or kind is None or kind.suffix != "s" or not 0 < float(parts[1]) < 1e6:
        raise BadInput("--every-row", "", f"{text!r} is not allowed: a time such as 60s or 1min")
    return kind.factor * float(parts[1])


def _not_in(known: Any, found: Any) -> list[str]:
    """Return a line for each column that a mapping file in use does not name."""
    return [
        f"{header} is new to the mapping file and was read as {rule.name} in {rule.unit}"
        for header, rule in found.mapping.columns.items()
        if header not in known and rule.unit
    ]


def _facts(found: Any, written: list[Path]) -> dict[str, Any]:
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
            for piece, file in zip(found.pieces, written, strict=True)
        ],
        "left_out": found.hints,
        "asked": found.asks,
        "doubtful": [{"column": column, "why": text} for column, text in found.doubts],
        "notes": list(found.notes),
    }
