"""What counts as a state that a power cut has spoilt."""

from __future__ import annotations

import pytest

from benchmarks.power_cut import STATE_BYTES, Found, state_of, whole_count


def test_a_whole_state_gives_its_count() -> None:
    assert whole_count(state_of(41)) == 41
    assert len(state_of(41)) > STATE_BYTES


@pytest.mark.parametrize("cut", [1, 20, STATE_BYTES])
def test_a_state_that_ends_early_is_not_whole(cut: int) -> None:
    with pytest.raises(ValueError, match=r"."):
        whole_count(state_of(41)[:cut])


def test_a_state_of_two_halves_is_not_whole() -> None:
    first, second = state_of(41), state_of(42)
    middle = len(first) // 2
    with pytest.raises(ValueError, match="not of one state"):
        whole_count(first[:middle] + second[middle:])


def test_tells_what_the_disk_held() -> None:
    found = Found()
    for on_disk, told in ((state_of(7), 7), (state_of(5), 7), ("", 7), (state_of(8)[:50], 8)):
        found.take(on_disk, told)
    assert (found.cuts, found.missing, found.half) == (4, 1, 1)
    assert (found.behind, found.most_behind) == (1, 2)
