"""Units of signals and the names of columns."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.units import UNITS, column, split_column


def test_every_suffix_of_the_run_file_is_known() -> None:
    known = {"s", "rpm", "mm_min", "Nm", "W", "lpm", "degC", "um", "mm", "urad", "1"}
    assert known == set(UNITS)


@given(st.text(min_size=1).filter(str.strip), st.sampled_from(sorted(UNITS)))
def test_splitting_undoes_joining(name: str, unit: str) -> None:
    assert split_column(column(name, unit)) == (name, unit)


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("feed_mm_min", ("feed", "mm_min")),
        ("disp_x_um", ("disp_x", "um")),
        ("tool_length_mm", ("tool_length", "mm")),
        ("valid_1", ("valid", "1")),
    ],
)
def test_known_columns(name: str, parts: tuple[str, str]) -> None:
    assert split_column(name) == parts


@pytest.mark.parametrize("name", ["T1", "T1_degF", "_um", " _um", "um", "T1_DEGC", "", "T1_um "])
def test_a_name_without_a_known_unit_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="is not a column name"):
        split_column(name)


def test_an_unknown_unit_is_refused() -> None:
    with pytest.raises(ValueError, match="'degF' is not a known unit"):
        column("T1", "degF")


@pytest.mark.parametrize(
    ("unit", "value", "si"),
    [
        ("degC", 20.0, 293.15),
        ("rpm", 60.0, 2.0 * math.pi),
        ("mm_min", 6000.0, 0.1),
        ("lpm", 60.0, 1e-3),
        ("um", 1.0, 1e-6),
        ("mm", 1.0, 1e-3),
        ("urad", 1.0, 1e-6),
        ("Nm", 3.0, 3.0),
        ("W", 3.0, 3.0),
        ("s", 3.0, 3.0),
        ("1", 3.0, 3.0),
    ],
)
def test_conversion_to_si(unit: str, value: float, si: float) -> None:
    assert UNITS[unit].to_si(value) == pytest.approx(si, rel=1e-15)


def test_power_is_torque_times_angular_speed_in_base_units() -> None:
    torque, speed, power = (UNITS[unit].exponents for unit in ("Nm", "rpm", "W"))
    product = {base: torque.get(base, 0) + speed.get(base, 0) for base in {*torque, *speed}}
    assert {base: n for base, n in product.items() if n and base != "rad"} == power


def test_the_module_needs_the_standard_library_only() -> None:
    code = "import sys, measurement.units; print('numpy' in sys.modules, 'pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
