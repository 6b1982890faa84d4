"""Cells: none lost, none too long, a thermometer in the middle of its own."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant_model.drawing.cells import SHORTEST, cuts_between, slices

places = st.lists(st.floats(-50.0, 350.0), max_size=6)


@given(places, st.floats(5.0, 400.0))
def test_cells_fill_the_stretch_and_none_is_too_long(read_at, longest):
    cuts = cuts_between(0.0, 300.0, read_at, longest)
    assert cuts[0] == 0.0
    assert cuts[-1] == 300.0
    lengths = [b - a for a, b in pairwise(cuts)]
    assert min(lengths) > 0.0
    assert max(lengths) <= longest * (1.0 + 1e-9)


@given(st.lists(st.floats(SHORTEST, 299.0), min_size=1, max_size=5), st.floats(5.0, 400.0))
def test_a_thermometer_sits_in_the_middle_of_a_cell(read_at, longest):
    cells = slices("x", [(0.0, 300.0)], read_at, [], longest)
    kept = [at for at in sorted(read_at) if all(abs(at - o) >= 2 or o == at for o in read_at)]
    for at in kept:
        assert any(cell.middle == pytest.approx(at, abs=1e-6) for cell in cells)
