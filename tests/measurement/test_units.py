"""Units of signals and the names of columns."""

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.units import UNITS, column, split_column


@given(st.text(min_size=1).filter(str.strip), st.sampled_from(sorted(UNITS)))
def test_splitting_undoes_joining(name, unit):
    assert split_column(column(name, unit)) == (name, unit)


@pytest.mark.parametrize("name", ["T1", "T1_degF", "_um", " _um", "um", "T1_DEGC", "", "T1_um "])
def test_a_name_without_a_known_unit_is_refused(name):
    with pytest.raises(ValueError, match="is not a column name"):
        split_column(name)


def test_an_unknown_unit_is_refused():
    with pytest.raises(ValueError, match="'degF' is not a known unit"):
        column("T1", "degF")


def test_the_module_needs_the_standard_library_only():
    code = "import sys, measurement.units; print('numpy' in sys.modules, 'pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
