"""``spindle-drift new-machine``: write a first page for your own machine from a few answers."""

from __future__ import annotations

import argparse
import sys
import tomllib
from pathlib import Path

from measurement.errors import BadInput
from measurement.files import write_atomically
from measurement.iso230 import RUNNING_S
from measurement.runs import read_run
from plant_model.checks import HOT, MachineFacts, bearing_temperatures, check_sheet
from plant_model.drawing.bearing_table import SERIES, Bearing, by_designation, known_designations
from plant_model.drawing.class_values import CLASS_VALUES
from plant_model.drawing.columns import Columns, columns_of
from plant_model.drawing.coolants import ALLOWED, coolant
from plant_model.drawing.expand import expanded
from plant_model.drawing.fits import lines_to_check, odd_fits
from plant_model.drawing.layout import Drawing
from plant_model.drawing.new_page import BEARINGS, Answers, page_text, unplaced
from plant_model.machine_file import machine_from_table
from scenarios.arguments import add_output, add_parameters, parameters_of
from scenarios.outputs import MACHINE_FILE

NAME = "new-machine"
READS = ("from_run",)
WRITES = {"output": MACHINE_FILE}
HELP = "write a machine's page from a few answers and, if given, a run's columns"

QUESTIONS = {
    "bearing": "Front bearing: designation or bore in mm (for example 7014)",
    "speed": "Highest speed in r/min",
    "power": "Motor power in kW",
}
"""The questions; a belt's power is used only if it is given."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_output(parser, "page to write (TOML)")
    add_parameters(
        parser,
        Answers,
        "drive",
        "lubrication",
        "rig",
        bearing={"flag": "--bearing"},
        speed={"flag": "--speed"},
        power={"flag": "--power"},
        coolant={"flag": "--coolant"},
        title={"flag": "--title"},
    )
    parser.add_argument(
        "--from-run", type=Path, metavar="RUN", help="take sensors and inputs from a run's columns"
    )
    changes = {"ambient": {"metavar": "COLUMN"}, "inlet": {"metavar": "COLUMN"}}
    add_parameters(parser, columns_of, **changes)


def run(args: argparse.Namespace) -> int:
    """Write the page, read it back, and print how warm the machine gets."""
    if args.output.suffix != ".toml":
        raise BadInput(args.output, "", "a page's name ends in .toml")
    if args.coolant is None:
        args.coolant = "none" if args.drive == "belt" else "water"
    columns = None
    if args.from_run is not None:
        columns = columns_of(read_run(args.from_run), args.ambient, args.inlet)
        if not columns.coolant and args.coolant != "none":
            raise BadInput(
                args.from_run,
                "",
                "which column is the coolant's inlet? Say --inlet COLUMN, or --coolant none",
            )
    answers = _answers(args)
    text = page_text(answers, columns, _running(answers, columns, args.output))
    table = tomllib.loads(text)
    machine = machine_from_table(expanded(table, args.output), args.output)
    path = write_atomically(args.output, text)
    print(f"wrote {path}: {len(text.splitlines())} lines, {lines_to_check(text)} to CHECK")
    if columns is not None and (left := unplaced(answers, columns)):
        print(f"not placed, remarks in the page until you do: {', '.join(left)}")
    if columns is not None and columns.not_names:
        print(
            f"left out: {', '.join(columns.not_names)}: a thermometer's name has letters a to z,"
            " digits and _ only; rename the column"
        )
    sheet = check_sheet(machine)
    for line in _first_look(sheet):
        print(line)
    for line in (*odd_fits(Drawing(table, args.output)), *sheet.wrong):
        print(f"looks wrong: {line}")
    print(f"see it to scale: spindle-drift show-machine {path}")
    return 0


def _running(answers: Answers, columns: Columns | None, path: Path) -> dict[str, float]:
    """Return the temperatures at which bearings run at full speed, in whole degrees.

    A bearing's friction depends on its temperature and vice versa. A warmer bearing makes less
    heat, so there is one solution for each, and repeated half steps towards it converge.
    """
    running = dict.fromkeys(BEARINGS, CLASS_VALUES["running_temperature"].value)
    tried: list[dict[str, float]] = []
    while running not in tried:  # this ends: there are finitely many whole degrees
        tried.append(running)
        table = tomllib.loads(page_text(answers, columns, running))
        warm = bearing_temperatures(machine_from_table(expanded(table, path), path))
        halfway = {name: (running[name] + warm[name]) / 2.0 for name in running}
        running = {name: min(float(round(value)), HOT) for name, value in halfway.items()}
    return running


def _answers(args: argparse.Namespace) -> Answers:
    belt = args.drive == "belt"
    needed = [key for key in QUESTIONS if key != "power" or not belt or args.power is not None]
    asked = {key: _asked(key, getattr(args, key)) for key in needed}
    numbers = {}
    for key, low, high, unit in (
        ("speed", 100.0, 100000.0, "r/min"),
        ("power", 0.1, 200.0, "kW"),
    ):
        if key not in asked:
            continue
        try:
            numbers[key] = float(asked[key])
        except ValueError:
            numbers[key] = float("nan")
        if not low <= numbers[key] <= high:
            raise BadInput(f"--{key}", "", f"{asked[key]} is not in {low:g}..{high:g} {unit}")
    if args.coolant != "none" and coolant(args.coolant) is None:
        raise BadInput("--coolant", "", f"{args.coolant!r} is not one of none, {ALLOWED}")
    bearing = _bearing(str(asked["bearing"]))
    title = args.title or f"{args.drive} spindle, {bearing.designation}, {numbers['speed']:g} r/min"
    if not title.isprintable() or '"' in title or "\\" in title:
        raise BadInput("--title", "", "must be one line without quotes and backslashes")
    name = "".join(c if c.isascii() and c.isalnum() else "_" for c in args.output.stem)
    if not name[0].isalpha():
        name = f"m_{name}"
    chosen = parameters_of(args, Answers, "drive", "coolant", "rig", "lubrication")
    return Answers(name[:60], title, bearing, numbers["speed"], numbers.get("power", 0.0), **chosen)


def _asked(key: str, given: object) -> str:
    """Return an option's value, or the answer typed at the terminal."""
    if given is not None:
        return str(given)
    if not sys.stdin.isatty():
        raise BadInput(f"--{key}", "", f"is missing: {QUESTIONS[key]}")
    return input(f"{QUESTIONS[key]}: ").strip()


def _bearing(text: str) -> Bearing:
    """Return the bearing with a designation, or of series 70 with a bore [mm]."""
    bearing = by_designation(text)
    if bearing is None:
        sizes = {f"{5 * code:g}": f"70{code:02d}" for code in SERIES["70"][1] if code >= 4}
        bearing = by_designation(sizes.get(text.removesuffix("mm").strip(), ""))
    if bearing is None:
        raise BadInput(
            "--bearing", "", f"{text!r} is not known; known are {known_designations()}, or a bore"
        )
    return bearing


def _first_look(sheet: MachineFacts) -> list[str]:
    """Return how warm the machine gets at full speed."""
    thermometers = {name: value for name, (value, unit) in sheet.readings.items() if unit == "degC"}
    warm = ", ".join(f"{name} {value:.1f} degC" for name, value in thermometers.items())
    hours, (x, y, z) = RUNNING_S / 3600.0, sheet.drift
    return [
        f"after {hours:g} h at full speed in a hall of 20 degC: {warm or 'no thermometer'}",
        f"drift of the nose: X {x:.0f}, Y {y:.0f}, Z {z:.0f} um",
    ]
