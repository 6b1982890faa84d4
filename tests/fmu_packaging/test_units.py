"""Units against SI factors from elsewhere."""

import math

import pytest

from fmu_packaging.units import ALIASES, UnitError, base_unit, fmi_name, own_name, quantity
from measurement.units import UNITS

IN_SI = {
    "s": (3.0, 3.0),
    "rpm": (60.0, 2.0 * math.pi),
    "mm_min": (6000.0, 0.1),
    "Nm": (3.0, 3.0),
    "W": (3.0, 3.0),
    "lpm": (60.0, 1e-3),
    "degC": (20.0, 293.15),
    "um": (1.0, 1e-6),
    "mm": (1.0, 1e-3),
    "urad": (1.0, 1e-6),
    "1": (3.0, 3.0),
}


@pytest.mark.parametrize("suffix", sorted(UNITS))
def test_every_unit_of_columns_is_known_in_si(suffix):
    value, si = IN_SI[suffix]
    found = base_unit(suffix)
    assert found.factor * value + found.offset == pytest.approx(si, rel=1e-15)


def test_power_is_torque_times_angular_speed_in_base_units():
    torque, speed, power = (base_unit(unit).powers for unit in ("Nm", "rpm", "W"))
    product = {base: torque.get(base, 0) + speed.get(base, 0) for base in {*torque, *speed}}
    assert {base: n for base, n in product.items() if n and base != "rad"} == power


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
def test_compound_units(unit, factor, powers):
    found = base_unit(unit)
    assert found.factor == pytest.approx(factor, rel=1e-12)
    assert found.powers == powers


@pytest.mark.parametrize(
    ("unit", "name", "measures"),
    [
        ("Nm", "N.m", "Torque"),
        ("W/(m2 K)", "W/(m2.K)", "CoefficientOfHeatTransfer"),
        ("1e-6/K", "um/(m.K)", "LinearExpansionCoefficient"),
        ("W/(1000 r/min)", "mW.min/rev", ""),
        ("degC", "degC", "ThermodynamicTemperature"),
        ("K", "K", "TemperatureDifference"),
        ("um", "um", "Length"),
    ],
)
def test_units_in_modelicas_syntax_mean_the_same(unit, name, measures):
    assert fmi_name(unit) == name
    assert base_unit(name).powers == base_unit(unit).powers
    assert base_unit(name).factor == pytest.approx(base_unit(unit).factor, rel=1e-15)
    assert quantity(unit) == measures


def test_a_column_gets_its_own_unit_back():
    assert [own_name(fmi_name(unit)) for unit in ALIASES] == list(ALIASES)


@pytest.mark.parametrize("unit", ["furlong", "W/(m2 K", "W)", "W/€", "", "kdegC"])
def test_refuses_what_it_does_not_know(unit):
    with pytest.raises(UnitError):
        base_unit(unit)
