"""The page that shows a machine: section, network, free numbers, and a sheet of checks."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from measurement.iso230 import RUNNING_S
from plant_model.checks import MachineFacts, check_sheet
from plant_model.convergence import Fineness, convergence
from plant_model.drawing.expand import is_page
from plant_model.drawing.fits import odd_of_page
from plant_model.drawing.layout import Drawing
from plant_model.machine import Machine
from plant_model.machine_file import machine_path, read_machine
from scenarios.pages.machine_drawing import section_of_lumps, section_of_page
from scenarios.pages.machine_graph import network_svg
from scenarios.pages.report import write_page


@dataclass(frozen=True)
class Shown:
    """What was found in a machine.

    Attributes
    ----------
    sheet : MachineFacts
    wrong : tuple of str
        A sentence for each thing that looks wrong.
    cells : tuple of Fineness
        Empty if not requested.
    """

    sheet: MachineFacts
    wrong: tuple[str, ...]
    cells: tuple[Fineness, ...]


def show_machine(machine: str, path: Path, *, cells: bool = False) -> Shown:
    """Check a machine and write its page.

    Parameters
    ----------
    machine : str
        Page, machine file or shipped name.
    path : Path
        Page to write (default: MACHINE.html).
    cells : bool
        Show how the result changes with the number of cells.

    Returns
    -------
    Shown
        What it does at full speed, and what looks wrong.

    Raises
    ------
    BadInput
        If the machine cannot be read, or is lumped and cells are requested.
    """
    source = machine_path(machine)
    read = read_machine(machine)
    fine = tuple(convergence(machine)) if cells else ()
    sheet = check_sheet(read)
    warm = {
        node.name: float(value)
        for node, value in zip(read.nodes, sheet.shown.temperatures[0, sheet.at], strict=True)
    }
    text = source.read_text(encoding="utf-8")
    table = tomllib.loads(text)
    if is_page(table):
        drawing = Drawing(table, source)
        odd, section = odd_of_page(drawing, text), section_of_page(drawing, warm)
    else:
        odd, section = [], section_of_lumps(read, warm)
    wrong = (*odd, *sheet.wrong)
    write_page(
        "machine.html",
        path,
        title=read.title,
        file=source.name,
        drawn=is_page(table),
        section=section,
        network=network_svg(read, sheet.parts, sheet.links),
        sheet=sheet,
        hours=RUNNING_S / 3600.0,
        parts=sorted(sheet.parts, key=lambda part: -part.warm),
        wrong=wrong,
        machine=read,
        followers=_followers(read),
        cells=fine,
    )
    return Shown(sheet, wrong, fine)


def _followers(machine: Machine) -> dict[str, list[str]]:
    """Return the names of the parameters that are tied to each number."""
    followers: dict[str, list[str]] = {}
    for name, parameter in machine.parameters.items():
        if parameter.tied:
            followers.setdefault(parameter.tied, []).append(name)
    return followers
