"""Thermo-elastic growth: displacement of the nose by the temperature of each node."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import spsolve
from skfem import Basis, ElementQuad1, ElementQuad2, ElementVector, condense

from measurement.errors import BadInput
from studies.finite_elements import forms
from studies.finite_elements.description import Description, Ring
from studies.finite_elements.mesh import Array, Index, SpindleMesh


class GrowthModel:
    """Linear thermo-elasticity of the solid parts, held at the mounting face along the axis.

    Parameters
    ----------
    description : Description
    mesh : SpindleMesh
        Of parts and gaps; gaps carry no force and are left out.

    Notes
    -----
    The displacement is quadratic and the temperature linear, so that strains match. The influence
    row comes from one adjoint solution.
    """

    def __init__(self, description: Description, mesh: SpindleMesh) -> None:
        solid = np.flatnonzero(mesh.part >= 0)
        body = mesh.mesh.restrict(solid)
        table = [description.materials[part.material] for part in description.parts]
        number = mesh.part[solid]
        modulus = np.array([material.modulus for material in table])[number] * 1e9
        poisson = np.array([material.poisson for material in table])[number]
        expansion = np.array([material.expansion for material in table])[number] * 1e-6
        self.displacement = Basis(body, ElementVector(ElementQuad2()), intorder=4)
        self.temperature = self.displacement.with_element(ElementQuad1())
        self.stiffness = forms.stiffness(self.displacement, modulus, poisson)
        self.load = forms.thermal_load(
            self.displacement, self.temperature, modulus, poisson, expansion
        )
        self._node = _node_numbers(mesh, body.p)
        self._size = mesh.mesh.p.shape[1]
        self.held = self._ring(description, "mount", description.mount)
        self.nose = self._ring(description, "nose", description.nose)

    def _ring(self, description: Description, place: str, ring: Ring) -> Index:
        """Return the axial degrees of freedom on a ring of a plane across the axis."""
        r, z = self.displacement.doflocs * 1e3
        on = np.isclose(z, ring.z, atol=1e-6) & (r > ring.r[0] - 1e-6) & (r < ring.r[1] + 1e-6)
        axial = np.zeros(self.displacement.N, dtype=bool)
        # In a vector element with two components, the second one of every place is axial.
        axial[self.displacement.nodal_dofs[1::2].ravel()] = True
        axial[self.displacement.facet_dofs[1::2].ravel()] = True
        axial[self.displacement.interior_dofs[1::2].ravel()] = True
        dofs = np.flatnonzero(on & axial)
        if not len(dofs):
            raise BadInput(description.name, place, "does not lie on a part")
        return dofs

    def fixed(self) -> Index:
        """Return the degrees of freedom that cannot move: the mount's, and radial ones on r = 0."""
        r = self.displacement.doflocs[0]
        radial = np.setdiff1d(
            np.flatnonzero(np.isclose(r, 0.0, atol=1e-12)),
            np.concatenate(
                [
                    self.displacement.nodal_dofs[1::2].ravel(),
                    self.displacement.facet_dofs[1::2].ravel(),
                    self.displacement.interior_dofs[1::2].ravel(),
                ]
            ),
        )
        return np.unique(np.concatenate([self.held, radial]))

    def influence(self) -> Array:
        """Return the nose's axial displacement per kelvin of every thermal node [um/K]."""
        wanted = np.zeros(self.displacement.N)
        wanted[self.nose] = 1.0 / len(self.nose)
        matrix, right, solution, kept = condense(self.stiffness, wanted, D=self.fixed())
        solution[kept] = spsolve(matrix.tocsc(), right)
        row = np.zeros(self._size)
        row[self._node] = (self.load.T @ solution) * 1e6
        return row

    def displaced(self, rise: Array) -> Array:
        """Return the displacement of all degrees of freedom [m] for temperature rises [K]."""
        force = self.load @ rise[self._node]
        matrix, right, solution, kept = condense(self.stiffness, force, D=self.fixed())
        solution[kept] = spsolve(matrix.tocsc(), right)
        return np.asarray(solution)


def _node_numbers(mesh: SpindleMesh, points: Array) -> Index:
    """Return the number in the whole mesh of each node of the solid body."""
    whole = {tuple(np.round(p, 9)): i for i, p in enumerate(mesh.mesh.p.T.tolist())}
    return np.array([whole[tuple(np.round(p, 9))] for p in points.T.tolist()], dtype=np.intp)
