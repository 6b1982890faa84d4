"""``spindle-drift import``: run files from spreadsheets, text tables and logs of any recorder.

Columns are named and converted by their headers; what cannot be placed is left out and told. A long
log is cut into runs at its pauses. What was decided stands in import.toml beside the runs: mend it
there and import again, and later logs of the same recorder follow it.
"""

from __future__ import annotations

import argparse
import json
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
    parser.add_argument("--time", metavar="HEADER", help="column of time, if it cannot be told")
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
    found = import_files(files, mapping, _units(args.unit))
    fresh = args.mapping is None and (source is None or args.force)
    written = write_imported(found, args.files, args.output, with_mapping=fresh)
    if args.json:
        print(json.dumps(_facts(found, written), indent=1, ensure_ascii=False))
        return 0
    print(table_text(found, written))
    new = {} if source is None else _not_in(mapping.columns, found)
    for header, text in found.hints.items():
        print(f"left out: {header}: {text}", file=sys.stderr)
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
    if args.day_first or args.month_first:
        table["time"]["day_first"] = bool(args.day_first)
    if args.timezone:
        table["time"]["timezone"] = args.timezone
    return checked(type(mapping), table, "import")


def _units(given: list[str]) -> dict[str, str]:
    from measurement.errors import BadInput
    from measurement.importing.quantities import checked_conversion

    units = {}
    for text in given:
        header, equals, unit = text.rpartition("=")
        if not equals or not header.strip() or not unit.strip():
            raise BadInput("--unit", "", f"{text!r} is not of the form HEADER=UNIT")

        checked_conversion(unit, header, lambda problem: BadInput("--unit", "", problem))
        units[header.strip()] = unit.strip()
    return units


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
        "doubtful": [{"column": column, "why": text} for column, text in found.doubts],
        "notes": list(found.notes),
    }
