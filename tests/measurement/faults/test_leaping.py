"""One score for leaps, with the error rate that it names."""

import numpy as np
import pytest

from measurement.faults.leaping import leap_odds
from measurement.resampling import WRONG

MADE = np.random.default_rng(4)


@pytest.mark.parametrize(
    "kind", ["white", "walk", "coarse", "walk whose moves are Laplace's", "warming"]
)
def test_a_sound_record_has_a_leap_as_seldom_as_is_said(kind):
    noise = MADE.standard_normal((400, 300))
    records = {
        "white": noise,
        "walk": np.cumsum(noise, axis=1),
        "coarse": np.round(noise),
        "walk whose moves are Laplace's": np.cumsum(MADE.laplace(size=(400, 300)), axis=1),
        "warming": 100.0 * (1.0 - np.exp(-np.arange(300.0) / 60.0)) + noise,
    }[kind]
    alarms = sum(bool((leap_odds(record, 0.0) > 0.0).any()) for record in records)
    assert alarms <= 2.0 * WRONG * len(records)


def test_size_is_told_against_the_channel_s_own_moves():
    values = MADE.standard_normal(300)
    values[150:] += 30.0
    odds = leap_odds(values, 0.0)
    assert np.flatnonzero(odds > 0.0).tolist() == [149]
    assert leap_odds(7.0 * values + 3.0, 0.0) == pytest.approx(odds)
    # A machine that was just switched moves as fast in the next readings.
    switched = np.r_[MADE.standard_normal(150), 30.0 * np.arange(4), 90.0 + MADE.standard_normal(9)]
    assert not (leap_odds(switched, 0.0) > 0.0).any()


def test_a_reading_that_is_held_moves_when_it_is_read():
    read = np.cumsum(MADE.standard_normal(40))
    held = np.repeat(read, 15)
    assert not (leap_odds(held, 0.0) > 0.0).any()
    held[300:] += 60.0
    assert np.flatnonzero(leap_odds(held, 0.0) > 0.0).tolist() == [299]
