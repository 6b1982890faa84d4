"""The node that each thermometer reads, and whose start it gives."""

from __future__ import annotations

from plant_model.drawing.layout import ENCLOSURE
from plant_model.drawing.sheet import Sheet

ROUND_THE_AXIS = ("inner", "outer", "sleeve")
"""Parts of a bearing set that have one temperature; the sleeve if it is a separate part."""


def add_thermometers(sheet: Sheet) -> None:
    """Add each thermometer at the node of its place."""
    nodes = {entry["name"] for entry in sheet.nodes}
    inputs = [name for name, entry in sheet.form.inputs.items() if entry.unit == "degC"]
    parts = {"shaft": "", "housing": ""}
    parts |= {
        f"{seat.form.name}.{ring}": f"{seat.form.name}_{ring}"
        for seat in sheet.drawing.seats
        for ring in ROUND_THE_AXIS
        if f"{seat.form.name}_{ring}" in nodes
    }
    parts |= {f"jacket.{jacket.name}": f"jacket_{jacket.name}" for jacket in sheet.form.jackets}
    parts |= {name: name for name in ("rotor", "stator", "pulley", "tool") if name in nodes}
    parts |= {carrier.name: carrier.name for carrier in sheet.form.carriers}
    parts |= {ENCLOSURE: "enclosure_air"} if sheet.form.enclosure else {}
    parts |= {name: name for name in inputs}
    for i, entry in enumerate(sheet.form.thermometers):
        place = f"thermometers.{i}"
        part = sheet.drawing.one_of(f"{place}.part", entry.part, parts)
        node = parts[part] or sheet.mesh.read_by(place, entry)
        sheet.sensor(
            {"name": entry.name, "of": node, "noise": entry.noise, "resolution": entry.resolution}
        )
