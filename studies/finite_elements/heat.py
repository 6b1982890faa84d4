"""Heat conduction in the spindle: matrices, films, jackets, sources."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from skfem import Basis, ElementQuad1, FacetBasis

from measurement.errors import BadInput
from studies.finite_elements import films, forms
from studies.finite_elements.description import Description
from studies.finite_elements.mesh import Array, Index, SpindleMesh


class HeatModel:
    """M dT/dt = -K(n) T + h(n) T_air + c T_coolant + sum of q_s(n) b_s, with n the speed.

    Attributes
    ----------
    mass : matrix, shape (nodes, nodes) [J/K]
    source_names : tuple of str
        Bearings first, then motors.
    entries : array, shape (nodes, sources)
        Where each source's heat enters; every column sums to 1.
    coolant : array, shape (nodes,) [W/K]
        Conductance of every node to the coolant.
    """

    def __init__(self, description: Description, mesh: SpindleMesh) -> None:
        self.description, self._mesh = description, mesh
        self.basis = Basis(mesh.mesh, ElementQuad1(), intorder=4)
        solid = mesh.part >= 0
        table = [description.materials[part.material] for part in description.parts]
        number = np.where(solid, mesh.part, 0)

        def of(field: str) -> Array:
            return np.array([getattr(material, field) for material in table])[number] * solid

        # Air in a gap stores hardly any heat, but the mass matrix must not be singular.
        stored = np.where(solid, of("density") * of("specific_heat"), 1.2e3)
        self.mass: csr_matrix = forms.mass(self.basis, stored)
        self._conduction: csr_matrix = forms.conduction(self.basis, of("conductivity"))
        self._add_jackets()
        self._add_surfaces()
        self._add_gaps()
        self._add_sources()

    def _add_jackets(self) -> None:
        size = self.basis.N
        self.coolant_matrix, self.coolant = csr_matrix((size, size)), np.zeros(size)
        for jacket in self.description.jackets:
            elements = self._elements(jacket.name, self._mesh.elements_in(jacket))
            density = self._over_volume(elements) * jacket.conductance
            self.coolant_matrix = self.coolant_matrix + forms.mass(self.basis, density)
            self.coolant = self.coolant + forms.source(self.basis, density)

    def _add_surfaces(self) -> None:
        size = self.basis.N
        self._still = (csr_matrix((size, size)), np.zeros(size))
        self._turning: list[tuple[float, csr_matrix, Array]] = []
        for surface in self.description.surfaces:
            facets = self._elements(surface.name, self._mesh.facets_in(surface))
            basis = FacetBasis(self._mesh.mesh, ElementQuad1(), facets=facets, intorder=4)
            matrix, vector = forms.surface(basis, 1.0)
            diameter = surface.diameter_mm * 1e-3
            if surface.kind == "turning":
                self._turning.append((diameter, matrix, vector))
            else:
                film = films.still_film(diameter)
                self._still = (self._still[0] + film * matrix, self._still[1] + film * vector)

    def _add_gaps(self) -> None:
        self._gaps: list[tuple[float, float, csr_matrix]] = []
        for number, gap in enumerate(self.description.gaps):
            inside = self._mesh.part == -1 - number
            self._elements(gap.name, np.flatnonzero(inside))
            radius, width = (gap.r[0] + gap.r[1]) * 0.5e-3, (gap.r[1] - gap.r[0]) * 1e-3
            matrix = forms.conduction(self.basis, inside.astype(np.float64))
            self._gaps.append((radius, width, matrix))

    def _add_sources(self) -> None:
        entries, self._numbers, names = [], [], []
        for bearings in self.description.bearings:
            entries.append(self._entry(bearings.parts))
            self._numbers.append(films.friction_numbers(bearings))
            names.append(bearings.name)
        for motor in self.description.motors:
            shares = {name: share for name, share in motor.shares.items() if share > 0.0}
            entry = sum(share * self._entry([name]) for name, share in shares.items())
            entries.append(np.asarray(entry) / sum(shares.values()))
            self._numbers.append((0.0, 0.0, 0.0, motor.watts_per_1000rpm * 1e-3))
            names.append(motor.name)
        self.entries: Array = np.stack(entries, axis=1)
        self.source_names = tuple(names)

    def _entry(self, parts: list[str]) -> Array:
        """Return the entry vector of heat spread evenly over the volume of parts."""
        names = [part.name for part in self.description.parts]
        inside = np.isin(self._mesh.part, [names.index(name) for name in parts])
        return forms.source(self.basis, self._over_volume(np.flatnonzero(inside)))

    def _elements(self, name: str, elements: Index) -> Index:
        if len(elements) == 0:
            raise BadInput(self.description.name, name, "covers no part of the spindle")
        return elements

    def _over_volume(self, elements: Index) -> Array:
        """Return per element 1 / (volume of these elements), 0 outside them [1/m3]."""
        inside = np.zeros(self._mesh.mesh.t.shape[1])
        inside[elements] = 1.0
        volume = float(forms.source(self.basis, inside).sum())
        return inside / volume

    @property
    def source_numbers(self) -> tuple[tuple[float, float, float, float], ...]:
        """Parameters of each source's heat over speed; see `films.friction_heat`."""
        return tuple(self._numbers)

    def powers(self, speed: float) -> Array:
        """Return the heat of every source at a speed [W]."""
        return np.array([films.friction_heat(speed, numbers) for numbers in self._numbers])

    def groups(self, speed: float) -> dict[str, tuple[csr_matrix, Array]]:
        """Return the conductance matrix and conductance to air of every group at a speed [W/K].

        ``conduction`` contains conduction and gaps, ``air`` the films, ``coolant`` the jackets.
        """
        inside = self._conduction
        for radius, width, matrix in self._gaps:
            inside = inside + films.gap_conductivity(speed, radius, width) * matrix
        film, to_air = self._still
        for diameter, matrix, vector in self._turning:
            coefficient = films.turning_film(speed, diameter)
            film, to_air = film + coefficient * matrix, to_air + coefficient * vector
        none = np.zeros(self.basis.N)
        return {
            "conduction": (inside, none),
            "air": (film, to_air),
            "coolant": (self.coolant_matrix, none),
        }

    def conductance(self, speed: float) -> tuple[csc_matrix, Array]:
        """Return K(n) and the conductance of every node to the air [W/K]."""
        groups = self.groups(speed)
        matrix = sum(
            (matrix for matrix, _ in groups.values()), csr_matrix((self.basis.N, self.basis.N))
        )
        return csc_matrix(matrix), groups["air"][1]

    @cached_property
    def nodes_mm(self) -> Array:
        """Coordinates of the nodes, shape (2, nodes) [mm]."""
        return np.asarray(self.basis.doflocs * 1e3)
