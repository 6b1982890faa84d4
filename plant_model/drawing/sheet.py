"""A machine file under construction."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plant_model.drawing.known import Known
from plant_model.drawing.materials import Material
from plant_model.drawing.mesh import Mesh
from plant_model.machine import REST


class Sheet:
    """Collects the content of a machine file.

    Parameters
    ----------
    mesh : Mesh
        The cells of the drawing.

    Attributes
    ----------
    drawing : Drawing
    form : PageForm
        The page.
    numbers : dict
        Named numbers, as in a machine file.
    nodes, links, sources, structure, sensors : list of dict
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh, self.drawing, self.form = mesh, mesh.drawing, mesh.drawing.form
        self.numbers: dict[str, dict[str, Any]] = {}
        self.nodes: list[dict[str, Any]] = []
        self.links: list[dict[str, Any]] = []
        self.sources: list[dict[str, Any]] = []
        self.structure: list[dict[str, Any]] = []
        self.sensors: list[dict[str, Any]] = []

    def number(self, name: str, known: Known) -> str:
        """Add a named number once and return its name."""
        self.numbers.setdefault(name, known.parameter())
        return name

    def tied(self, name: str, factor: float, unit: str) -> dict[str, Any]:
        """Return a parameter that follows a named number."""
        return {"number": name, "factor": factor, "unit": unit}

    def heat_of(self, material: Material, volume_m3: float) -> dict[str, Any]:
        """Return a heat capacity [J/K] from a volume [m3]."""
        name = self.number(f"{material.name}_heat", material.heat)
        return self.tied(name, volume_m3, "J/K")

    def path_in(self, material: Material, area_over_length_m: float) -> dict[str, Any]:
        """Return a conductance [W/K] from a cross-section divided by a length [m]."""
        conductivity = replace(material.conductivity, free=False)
        name = self.number(f"{material.name}_conductivity", conductivity)
        return self.tied(name, area_over_length_m, "W/K")

    def growth_of(self, material: Material) -> dict[str, Any]:
        """Return an expansion [1e-6/K]."""
        expansion = replace(material.expansion, free=True)
        name = self.number(f"{material.name}_expansion", expansion)
        return self.tied(name, 1.0, "1e-6/K")

    def node(self, name: str, capacity: Known | dict[str, Any]) -> None:
        """Add a node; it starts at rest unless a :meth:`sensor` reads it."""
        _add(self.nodes, name=name, capacity=capacity, start=REST)

    def sensor(self, entry: dict[str, Any]) -> None:
        """Add a thermometer; its node starts at the reading of its first thermometer."""
        self.sensors.append(entry)
        for node in self.nodes:
            if node["name"] == entry["of"] and node["start"] == REST:
                node["start"] = entry["name"]

    def link(self, kind: str, first: str, second: str, **numbers: Any) -> None:
        """Add a link; ``name`` may be among *numbers*."""
        _add(self.links, kind=kind, between=[first, second], **numbers)

    def source(self, kind: str, name: str, **fields: Any) -> None:
        """Add a heat source."""
        _add(self.sources, kind=kind, name=name, **fields)

    def member(self, kind: str, name: str, **fields: Any) -> None:
        """Add a part of the structure."""
        _add(self.structure, kind=kind, name=name, **fields)


def _add(entries: list[dict[str, Any]], **fields: Any) -> None:
    entries.append({key: v.parameter() if isinstance(v, Known) else v for key, v in fields.items()})
