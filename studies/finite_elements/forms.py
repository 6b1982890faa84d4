"""Weak forms on a body of revolution; every integral contains the factor 2 pi r."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from skfem import Basis, BilinearForm, ElementQuad0, LinearForm
from skfem.helpers import dot, grad

Array = NDArray[np.float64]


@BilinearForm  # type: ignore[untyped-decorator]
def _conduction(u: Any, v: Any, w: Any) -> Any:
    return 2.0 * np.pi * w.x[0] * w.factor * dot(grad(u), grad(v))


@BilinearForm  # type: ignore[untyped-decorator]
def _mass(u: Any, v: Any, w: Any) -> Any:
    return 2.0 * np.pi * w.x[0] * w.factor * u * v


@LinearForm  # type: ignore[untyped-decorator]
def _source(v: Any, w: Any) -> Any:
    return 2.0 * np.pi * w.x[0] * w.factor * v


def strain(u: Any, w: Any) -> tuple[Any, Any, Any, Any]:
    """Return radial, hoop, axial and shear strain of a displacement (u_r, u_z)."""
    g = u.grad
    return g[0, 0], u[0] / w.x[0], g[1, 1], g[0, 1] + g[1, 0]


@BilinearForm  # type: ignore[untyped-decorator]
def _stiffness(u: Any, v: Any, w: Any) -> Any:
    radial, hoop, axial, shear = strain(u, w)
    d_radial, d_hoop, d_axial, d_shear = strain(v, w)
    volume = radial + hoop + axial
    energy = w.lame * volume * (d_radial + d_hoop + d_axial)
    energy = energy + 2.0 * w.shear * (radial * d_radial + hoop * d_hoop + axial * d_axial)
    return 2.0 * np.pi * w.x[0] * (energy + w.shear * shear * d_shear)


@BilinearForm  # type: ignore[untyped-decorator]
def _thermal_stress(u: Any, v: Any, w: Any) -> Any:
    radial, hoop, axial, _ = strain(v, w)
    return 2.0 * np.pi * w.x[0] * w.factor * u * (radial + hoop + axial)


def per_element(basis: Basis, values: Array) -> Any:
    """Return one value per element as a field that forms can use."""
    constant = basis.with_element(ElementQuad0())
    vector = np.zeros(constant.N)
    vector[constant.element_dofs[0]] = values
    return constant.interpolate(vector)


def conduction(basis: Basis, conductivity: Array) -> csr_matrix:
    """Return the matrix of k grad T . grad v [W/K]; *conductivity* is per element [W/(m K)]."""
    return _conduction.assemble(basis, factor=per_element(basis, conductivity))


def mass(basis: Basis, factor: Array) -> csr_matrix:
    """Return the matrix of factor T v; *factor* per element, e.g. rho c [J/(m3 K)]."""
    return _mass.assemble(basis, factor=per_element(basis, factor))


def surface(basis: Basis, coefficient: float) -> tuple[csr_matrix, Array]:
    """Return matrix and vector of a film on the facets of *basis* [W/K]."""
    return _mass.assemble(basis, factor=coefficient), np.asarray(
        _source.assemble(basis, factor=coefficient)
    )


def source(basis: Basis, density: Array) -> Array:
    """Return the vector of a heat density per element [W/m3]."""
    return np.asarray(_source.assemble(basis, factor=per_element(basis, density)))


def stiffness(basis: Basis, modulus: Array, poisson: Array) -> csr_matrix:
    """Return the elastic stiffness; modulus [Pa] and Poisson's ratio per element."""
    lame = modulus * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = modulus / (2.0 * (1.0 + poisson))
    return _stiffness.assemble(
        basis, lame=per_element(basis, lame), shear=per_element(basis, shear)
    )


def thermal_load(
    displacement: Basis, temperature: Basis, modulus: Array, poisson: Array, expansion: Array
) -> csr_matrix:
    """Return the matrix from temperature rises to nodal forces [N/K]; *expansion* in 1/K."""
    factor = modulus * expansion / (1.0 - 2.0 * poisson)
    field = per_element(temperature, factor)
    return _thermal_stress.assemble(temperature, displacement, factor=field)
