"""What is promised to be left, from what was left out and what the interval expects."""

from dataclasses import replace

import pytest

from fmu_compensator.fit.conditions import LIKE, UNLIKE, Fold
from fmu_compensator.fit.gaussian import DEGREES
from fmu_compensator.fit.promise import AxisLeft, RunLeft, followed, promise

AXIS = AxisLeft(none=10.0, left=2.0, inside=0.9, half_width=5.0, expected=6.0, miss=0.5)
LIKE_FOLD, COLD = Fold("every 5th", LIKE, (0,)), Fold("coldest starts", UNLIKE, (0, 1))


def left(run: str, fold: Fold | None, rms: float) -> RunLeft:
    return RunLeft(run, fold, {"Z": replace(AXIS, left=rms)}, 0.0)


def square(expected: float, rms: float, behind: int) -> float:
    return (DEGREES * expected**2 + behind * rms**2) / (DEGREES + behind)


def test_many_runs_weigh_more_than_what_the_interval_expects_and_conditions_are_few():
    runs = [left(f"run{n}", LIKE_FOLD, 2.0) for n in range(30)]
    found = promise(runs)
    assert found["like_behind"] == 30
    assert found["promised"]["Z"]["model"] ** 2 == pytest.approx(square(6.0, 2.0, 30))
    found = promise([*runs, *(left(f"run{n}", COLD, 2.0) for n in range(10))])
    assert found["unlike_behind"] == 3  # ten runs are no more than three conditions
    assert found["promised"]["Z"]["model"] ** 2 == pytest.approx(square(6.0, 2.0, 3))
    assert found["promised"]["Z"]["no_model"] == pytest.approx(10.0)


def test_a_promise_is_of_the_drift_of_the_runs_that_it_comes_from():
    cold = RunLeft("cold", COLD, {"Z": replace(AXIS, none=7.0, left=4.0)}, 0.0)
    found = promise([left("run", LIKE_FOLD, 2.0), cold])
    assert found["promised"]["Z"]["no_model"] == pytest.approx(7.0)


def test_an_interval_that_expects_less_than_was_left_does_not_lower_the_promise():
    found = promise([left(f"run{n}", LIKE_FOLD, 9.0) for n in range(4)])
    assert found["promised"]["Z"]["model"] == pytest.approx(9.0)


def test_a_promise_follows_what_was_left_of_further_runs():
    first = promise([left(f"run{n}", fold, 2.0) for n in range(4) for fold in (LIKE_FOLD, COLD)])
    worse = followed(first, [left("new", None, 8.0), left("newer", None, 8.0)])
    assert (worse["like_behind"], worse["unlike_behind"]) == (6, 4)
    expected = square(6.0, ((3 * 2.0**2 + 8.0**2) / 4) ** 0.5, 4)
    like = square(6.0, ((4 * 2.0**2 + 2 * 8.0**2) / 6) ** 0.5, 6)
    assert worse["promised"]["Z"]["model"] ** 2 == pytest.approx(max(like, expected))
    assert [one["run"] for one in worse["by_run"]][-2:] == ["new", "newer"]
    assert followed(first, []) == first


def test_without_a_promise_before_the_new_runs_make_one():
    found = followed(None, [left("new", None, 2.0)])
    assert found["like_behind"] == 1
    assert "unlike" not in found
    assert found["promised"]["Z"]["model"] ** 2 == pytest.approx(square(6.0, 2.0, 1))
