"""An axisymmetric thermo-elastic spindle in finite elements, from a small description file."""

from studies.finite_elements.description import Description, read_description
from studies.finite_elements.spindle import FiniteElementSpindle

__all__ = ["Description", "FiniteElementSpindle", "read_description"]
