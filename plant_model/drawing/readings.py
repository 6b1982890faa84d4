"""Where each node starts, and which node each thermometer reads."""

from __future__ import annotations

from math import cos, radians

from plant_model.drawing.form import ThermometerForm, degrees
from plant_model.drawing.layout import ENCLOSURE, Drawing
from plant_model.drawing.mesh import Mesh
from plant_model.drawing.sheet import Sheet

BESIDE = 200.0
"""The far side of the spindle counts as this far along the axis [mm]."""

ROUND_THE_AXIS = ("inner", "outer")


class Starts:
    """Finds the thermometer at whose first reading a node starts.

    Parameters
    ----------
    drawing : Drawing
    """

    def __init__(self, drawing: Drawing) -> None:
        self._drawing = drawing
        self._placed: list[tuple[str, float, float | None]] = []
        self._of_part: dict[str, str] = {}
        for entry in drawing.form.thermometers:
            self._of_part.setdefault(entry.part, entry.name)
            place = _place(drawing, entry)
            if place is not None:
                side = None if entry.side is None else degrees(entry.side)
                self._placed.append((entry.name, place, side))

    def of_part(self, part: str, otherwise: str) -> str:
        """Return the thermometer of a part, or else an input."""
        return self._of_part.get(part, otherwise)

    def nearest(self, at: float, angle: float | None = None) -> str:
        """Return the thermometer nearest to a place on the spindle, or the hall's air."""

        def distance(entry: tuple[str, float, float | None]) -> float:
            _, place, side = entry
            apart = 0.0
            if side is not None and angle is not None:
                apart = BESIDE * (1.0 - cos(radians(side - angle))) / 2.0
            return float(abs(place - at) + apart)

        return min(self._placed, key=distance)[0] if self._placed else "ambient"


def _place(drawing: Drawing, entry: ThermometerForm) -> float | None:
    """Return where on the spindle a thermometer sits [mm], or None if it is elsewhere."""
    if entry.part in {"shaft", "housing"}:
        return entry.at
    form = drawing.form
    if entry.part in {"rotor", "stator"} and form.motor is not None:
        return (form.motor.start + form.motor.end) / 2.0
    name, _, ring = entry.part.partition(".")
    if ring in ROUND_THE_AXIS:
        return next((seat.form.at for seat in drawing.seats if seat.form.name == name), None)
    return None


def add_thermometers(sheet: Sheet, drawing: Drawing, mesh: Mesh) -> None:
    """Add every thermometer on the node that holds its place."""
    nodes = {entry["name"] for entry in sheet.nodes}
    inputs = [name for name, entry in drawing.form.inputs.items() if entry.unit == "degC"]
    parts = {"shaft": "", "housing": ""}
    parts |= {
        f"{seat.form.name}.{ring}": f"{seat.form.name}_{ring}"
        for seat in drawing.seats
        for ring in ROUND_THE_AXIS
    }
    parts |= {f"jacket.{jacket.name}": f"jacket_{jacket.name}" for jacket in drawing.form.jackets}
    parts |= {name: name for name in ("rotor", "stator", "pulley", "tool") if name in nodes}
    parts |= {carrier.name: carrier.name for carrier in drawing.form.carriers}
    parts |= {ENCLOSURE: "enclosure_air"} if drawing.form.enclosure else {}
    parts |= {name: name for name in inputs}
    for i, entry in enumerate(drawing.form.thermometers):
        place = f"thermometers.{i}"
        part = drawing.one_of(f"{place}.part", entry.part, parts)
        node = parts[part] or mesh.read_by(place, entry)
        sheet.sensors.append(
            {"name": entry.name, "of": node, "noise": entry.noise, "resolution": entry.resolution}
        )
