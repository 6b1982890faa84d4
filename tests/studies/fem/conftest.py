"""Small spindles in finite elements whose answers are known."""

from typing import Any

import pytest

from studies.finite_elements import Description, FiniteElementSpindle

STEEL = {
    "conductivity": 45.0,
    "density": 7800.0,
    "specific_heat": 470.0,
    "modulus": 210.0,
    "poisson": 0.3,
    "expansion": 11.5,
}


def bar_table(**changes: Any) -> dict[str, Any]:
    """A hollow bar of 200 mm, held at z = 0, heated throughout, cooled at its outside."""
    return {
        "format": 1,
        "name": "bar",
        "element_mm": 10.0,
        "mount": {"z": 0.0, "r": [20.0, 40.0]},
        "nose": {"z": 200.0, "r": [20.0, 40.0]},
        "materials": {"steel": STEEL},
        "parts": [{"name": "bar", "material": "steel", "r": [20.0, 40.0], "z": [0.0, 200.0]}],
        "surfaces": [
            {
                "name": "outside",
                "kind": "still",
                "r": [39.0, 41.0],
                "z": [0.0, 200.0],
                "diameter_mm": 80.0,
            }
        ],
        "motors": [{"name": "heater", "watts_per_1000rpm": 10.0, "shares": {"bar": 1.0}}],
        **changes,
    }


@pytest.fixture
def bar() -> FiniteElementSpindle:
    return FiniteElementSpindle(Description.model_validate(bar_table()))


@pytest.fixture(scope="session")
def jig_borer() -> FiniteElementSpindle:
    return FiniteElementSpindle()
