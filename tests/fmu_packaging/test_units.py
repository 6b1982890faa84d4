"""Units against SI factors from elsewhere."""

from __future__ import annotations

import math

import pytest

from fmu_packaging.units import UnitError, base_unit
from measurement.units import UNITS


@pytest.mark.parametrize("suffix", sorted(UNITS))
def test_agrees_with_the_run_files_units(suffix: str) -> None:
    ours, theirs = base_unit(suffix), UNITS[suffix]
    assert ours.factor == pytest.approx(theirs.factor, rel=1e-15)
    assert ours.offset == theirs.offset
    assert ours.powers == dict(theirs.exponents)


@pytest.mark.parametrize(
    ("unit", "factor", "powers"),
    [
        ("W/(m2 K)", 1.0, {"kg": 1, "s": -3, "K": -1}),
        ("W/(1000 r/min)", 60 / (2 * math.pi * 1000), {"kg": 1, "m": 2, "s": -2, "rad": -1}),
        ("W/(m/min)", 60.0, {"kg": 1, "m": 1, "s": -2}),
        ("J/(l K)", 1e3, {"kg": 1, "m": -1, "s": -2, "K": -1}),
        ("1e-6/K", 1e-6, {"K": -1}),
        ("mm2/s", 1e-6, {"m": 2, "s": -1}),
        ("N mm", 1e-3, {"kg": 1, "m": 2, "s": -2}),
        ("um/K", 1e-6, {"m": 1, "K": -1}),
        ("kJ/K", 1e3, {"kg": 1, "m": 2, "s": -2, "K": -1}),
        ("1/K", 1.0, {"K": -1}),
        ("min", 60.0, {"s": 1}),
        ("MPa", 1e6, {"kg": 1, "m": -1, "s": -2}),
    ],
)
def test_compound_units(unit: str, factor: float, powers: dict[str, int]) -> None:
    found = base_unit(unit)
    assert found.factor == pytest.approx(factor, rel=1e-12)
    assert found.powers == powers


@pytest.mark.parametrize("unit", ["furlong", "W/(m2 K", "W)", "W/€", "", "kdegC"])
def test_refuses_what_it_does_not_know(unit: str) -> None:
    with pytest.raises(UnitError):
        base_unit(unit)
