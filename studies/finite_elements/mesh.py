"""Meshes rectangles with quadrilaterals in the half plane (r, z) [m]."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad

from measurement.errors import BadInput
from plant_model.drawing.layout import TOUCH
from studies.finite_elements.description import MOST_ELEMENTS, Description, Rectangle

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@dataclass(frozen=True)
class SpindleMesh:
    """The mesh of parts and gaps.

    Attributes
    ----------
    mesh : MeshQuad
        Coordinates (r, z) [m].
    part : array of int, shape (elements,)
        The part of each element; minus one less than the gap's number for gaps.
    """

    mesh: MeshQuad
    part: Index

    @property
    def centres(self) -> Array:
        """Centres of the elements, shape (2, elements) [mm]."""
        return np.asarray(self.mesh.p[:, self.mesh.t].mean(axis=1) * 1e3)

    def elements_in(self, box: Rectangle) -> Index:
        """Return the elements whose centre lies in a rectangle."""
        return np.flatnonzero(_inside(self.centres, box))

    def facets_in(self, box: Rectangle) -> Index:
        """Return the free facets whose centre lies in a rectangle."""
        facets = self.mesh.boundary_facets()
        middles = self.mesh.p[:, self.mesh.facets[:, facets]].mean(axis=1) * 1e3
        return np.asarray(facets[_inside(middles, box)])


def build_mesh(description: Description) -> SpindleMesh:
    """Return the mesh; every edge of a rectangle is a mesh line.

    Raises
    ------
    BadInput
        If there would be too many elements, or a rectangle covers none.
    """
    boxes: list[Rectangle] = [
        *description.parts,
        *description.gaps,
        *description.jackets,
    ]
    r = _lines([edge for box in boxes for edge in box.r], description.element_mm)
    z = _lines([edge for box in boxes for edge in box.z], description.element_mm)
    if len(r) * len(z) > MOST_ELEMENTS:
        count = len(r) * len(z)
        raise BadInput(
            description.name,
            "element_mm",
            f"{description.element_mm:g} gives {count} elements; {MOST_ELEMENTS} are allowed",
        )
    whole = MeshQuad.init_tensor(r * 1e-3, z * 1e-3)
    centres = whole.p[:, whole.t].mean(axis=1) * 1e3
    part = np.full(whole.t.shape[1], -1)
    void = np.ones(whole.t.shape[1], dtype=bool)
    for number, gap in enumerate(description.gaps):
        inside = _inside(centres, gap)
        part[inside], void[inside] = -1 - number, False
    for number, solid in enumerate(description.parts):
        inside = _inside(centres, solid)
        part[inside], void[inside] = number, False
    kept = np.flatnonzero(~void)
    for number, solid in enumerate(description.parts):
        if not np.any(part[kept] == number):
            raise BadInput(description.name, f"part {solid.name}", "is covered by later parts")
    return SpindleMesh(whole.restrict(kept), part[kept])


def _inside(points: Array, box: Rectangle) -> NDArray[np.bool_]:
    r, z = points
    return np.asarray((box.r[0] < r) & (r < box.r[1]) & (box.z[0] < z) & (z < box.z[1]))


def _lines(edges: list[float], longest: float) -> Array:
    """Return all edges and lines between them, at most *longest* apart."""
    sorted_edges = np.unique(np.asarray(edges, dtype=np.float64))
    kept = sorted_edges[np.concatenate([[True], np.diff(sorted_edges) > TOUCH])]
    pieces = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / longest - 1e-9))), endpoint=False)
        for a, b in pairwise(kept)
    ]
    return np.concatenate([*pieces, kept[-1:]])
