"""Shaft, housing and tool in finite elements: bodies of revolution in the half plane (r, z).

Quadrilaterals with linear temperatures; the weak forms are those of scikit-fem that the project's
finite-element spindle has, too. Heat capacities are lumped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Basis, ElementQuad1, MeshQuad

from benchmarks.gap.belt.numbers import Stretch
from benchmarks.gap.cells import Array, Index
from studies.finite_elements import forms

ALONG, ACROSS = 12.0, 9.0
"""Longest element along and across the axis [mm]."""

Hats = tuple[tuple[float, float], tuple[float, float]]

SLIVER = 1e-6
"""Places nearer than this are one [mm]."""


@dataclass
class Solid:
    """One body of revolution.

    Attributes
    ----------
    stretches : tuple of Stretch
    r, z : array, shape (nodes,)
        Places of the nodes [mm].
    volume : array, shape (nodes,)
        Belonging to each node [m3].
    conduction : matrix, shape (nodes, nodes)
        For 1 W/(m K) [m].
    around : matrix, shape (nodes, nodes)
        What a cosine around the axis adds to it, for 1 W/(m K) [m].
    """

    stretches: tuple[Stretch, ...]
    r: Array
    z: Array
    volume: Array
    conduction: csr_matrix
    around: csr_matrix
    _lines: Array = field(default_factory=lambda: np.zeros(0))

    def surface(self, side: str, start: float, end: float) -> tuple[Index, Array]:
        """Return the nodes of the outer or inner surface in a span, and the area of each [m2]."""
        found: dict[int, float] = {}
        for stretch in self.stretches:
            radius = getattr(stretch, side) / 2.0
            at = {
                round(float(self.z[i]), 6): i
                for i in np.flatnonzero(np.abs(self.r - radius) < SLIVER).tolist()
            }
            for length, hats in self._covered(start, end):
                if hats[0][0] < stretch.start - SLIVER or hats[1][0] > stretch.end + SLIVER:
                    continue
                area = 2.0 * np.pi * radius * length * 1e-6
                for line, share in hats:
                    node = at[round(line, 6)]
                    found[node] = found.get(node, 0.0) + share * area
        return np.array(list(found), dtype=np.intp), np.array(list(found.values()))

    def face(self, place: float) -> tuple[Index, Array]:
        """Return the nodes of the plane at a place and the share of the section of each."""
        nodes = np.flatnonzero(np.abs(self.z - place) < SLIVER)
        weight = self.volume[nodes]
        return nodes, weight / weight.sum()

    def mean_over(self, start: float, end: float) -> Array:
        """Return weights whose sum over temperatures is the integral of the section's mean [mm].

        That is how a bar whose sections stay plane grows from *start* to *end*.
        """
        weights = np.zeros(len(self.r))
        for length, hats in self._covered(start, end):
            for line, share in hats:
                nodes, part = self.face(line)
                weights[nodes] += share * length * part
        return weights

    def _covered(self, start: float, end: float) -> Iterator[tuple[float, Hats]]:
        """Yield the length of each row of elements in a span, and the hats at both of its ends.

        Of each, the place [mm] and the mean over that length.
        """
        for low, high in pairwise(self._lines.tolist()):
            a, b = max(low, start), min(high, end)
            if b - a >= SLIVER:
                later = ((a + b) / 2.0 - low) / (high - low)
                yield b - a, ((low, 1.0 - later), (high, later))

    def at(self, radius: float, place: float) -> Array:
        """Return weights that interpolate the temperature at a place."""
        lines = np.unique(self.r)
        weights = np.zeros(len(self.r))
        for value, near in ((place, self._lines), (radius, lines)):
            assert near[0] - SLIVER <= value <= near[-1] + SLIVER
        for z, zs in _between(place, self._lines):
            column = np.flatnonzero(np.abs(self.z - z) < SLIVER)
            for r, rs in _between(radius, np.sort(self.r[column])):
                weights[column[np.argmin(np.abs(self.r[column] - r))]] += zs * rs
        return weights


def _between(value: float, lines: Array) -> list[tuple[float, float]]:
    """Return both neighbours of a value among lines, with their shares."""
    right = int(np.clip(np.searchsorted(lines, value), 1, len(lines) - 1))
    low, high = float(lines[right - 1]), float(lines[right])
    later = (value - low) / (high - low)
    return [(low, 1.0 - later), (high, later)]


def revolve(stretches: Sequence[Stretch], cuts: Sequence[float], finer: float = 1.0) -> Solid:
    """Return a body of revolution; elements end at the stretches' edges and at *cuts* [mm]."""
    r = _lines([edge for s in stretches for edge in (s.inner / 2.0, s.outer / 2.0)], ACROSS / finer)
    low, high = stretches[0].start, stretches[-1].end
    edges = [edge for s in stretches for edge in (s.start, s.end)]
    z = _lines([*edges, *(cut for cut in cuts if low < cut < high)], ALONG / finer)
    whole = MeshQuad.init_tensor(r * 1e-3, z * 1e-3)
    middle = whole.p[:, whole.t].mean(axis=1) * 1e3
    inside = np.zeros(middle.shape[1], dtype=bool)
    for s in stretches:
        across = (s.inner / 2.0 < middle[0]) & (middle[0] < s.outer / 2.0)
        inside |= across & (s.start < middle[1]) & (middle[1] < s.end)
    mesh = whole.restrict(np.flatnonzero(inside))
    basis = Basis(mesh, ElementQuad1(), intorder=4)
    ones = np.ones(mesh.t.shape[1])
    centre = mesh.p[0, mesh.t].mean(axis=0)
    places = basis.doflocs * 1e3
    return Solid(
        tuple(stretches),
        np.asarray(places[0]),
        np.asarray(places[1]),
        np.asarray(forms.mass(basis, ones).sum(axis=1)).ravel(),
        forms.conduction(basis, ones),
        forms.mass(basis, 1.0 / centre**2),
        z,
    )


def _lines(edges: Sequence[float], longest: float) -> Array:
    """Return all edges, and between them lines no further apart than *longest*."""
    kept = np.unique(np.round(np.asarray(edges, dtype=float), 6))
    pieces = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / longest - 1e-9))), endpoint=False)
        for a, b in pairwise(kept)
    ]
    return np.concatenate([*pieces, kept[-1:]])
