"""A page expanded into a machine file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plant_model.drawing.growth import add_growth
from plant_model.drawing.heat import add_heat
from plant_model.drawing.known import CLASS, Known
from plant_model.drawing.layout import Drawing
from plant_model.drawing.mesh import Mesh
from plant_model.drawing.readings import add_thermometers
from plant_model.drawing.sheet import Sheet
from plant_model.drawing.spindle import add_spindle
from plant_model.drawing.surroundings import add_surroundings
from plant_model.effects import item_kinds
from plant_model.machine_forms import naming_places

GAPS = Known(1.0, 0.5, 2.0, "1", CLASS + "factor on the correlation of the air gap effect", True)


def is_page(table: dict[str, Any]) -> bool:
    """Return whether a parsed file is a page and not a machine file in lumps.

    Parameters
    ----------
    table : dict
        The parsed file.
    """
    return "kind" in table


def expanded(
    table: dict[str, Any], source: str | Path, *, finer: float = 1.0, sectors: int | None = None
) -> dict[str, Any]:
    """Return a page as the table of a machine file.

    Parameters
    ----------
    table : dict
        The parsed page.
    source : path
        The file, for refusals.
    finer : float
        Factor by which cells are shorter than in the page.
    sectors : int, optional
        Number of cells around the axis, instead of the page's.

    Raises
    ------
    BadInput
        For the first error, in one line.
    """
    with naming_places(table):
        drawing = Drawing(table, source)
        form = drawing.form
        sheet = Sheet(Mesh(drawing, finer, sectors))
        add_spindle(sheet)
        add_heat(sheet)
        add_surroundings(sheet)
        add_growth(sheet)
        add_thermometers(sheet)
    return {
        "format": 1,
        "name": form.name,
        "title": form.title,
        "description": form.description,
        "references": {"page": f"the page {Path(source).name}"},
        "inputs": {
            name: entry.model_dump(exclude_none=True) for name, entry in form.inputs.items()
        },
        "numbers": sheet.numbers,
        "nodes": sheet.nodes,
        "links": sheet.links,
        "sources": sheet.sources,
        "structure": sheet.structure,
        "sensors": sheet.sensors,
        "rig": form.rig.model_dump(),
        "axis": form.axis.model_dump(),
        "effects": _effects(sheet) | form.effects,
    }


def _effects(sheet: Sheet) -> dict[str, Any]:
    """Return the effects that the kinds on the sheet need."""
    on_sheet = {"links": sheet.links, "sources": sheet.sources, "structure": sheet.structure}
    kinds = {(family, entry["kind"]) for family, entries in on_sheet.items() for entry in entries}
    effects: dict[str, Any] = {item_kinds()[kind][0]: {} for kind in sorted(kinds)}
    if "air_gap" in effects:
        effects["air_gap"] = {"scale": GAPS.parameter()}
    return effects
