"""What broken sensors are likely to read, beside Gaussian conditioning done with numpy."""

import json
from math import exp, nan
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from fmu_compensator.fit.spare import best_strength, left_out_errors, precision
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.spare import Spare
from tests.refusing import refusal

Array = npt.NDArray[np.float64]
SENSORS = 5
RECOVER_S, MEMORY_S = 10.0, 1800.0
AXES = [[1.0, 0.5], [0.0, 0.0], [0.0, -1.0]]
"""How the drift along X, Y, Z follows from two targets."""


def covariance(seed: int) -> Array:
    parts = np.random.default_rng(seed).normal(0.0, 2.0, (SENSORS, 3))
    return parts @ parts.T + 0.3 * np.eye(SENSORS)


def table_of(known: Array, **changes: Any) -> dict[str, Any]:
    inverse = np.linalg.inv(known)
    return {
        "precision": ((inverse + inverse.T) / 2.0).tolist(),
        "growth": [1.0, 2.0, 1.0, 4.0, 1.0],
        "memory_s": MEMORY_S,
        "usual_start": [0.0, 1.0, -0.5, 2.0, 10.0],
        "sensitivity": [[1.0, -2.0, 0.5, 0.0, 3.0], [2.0] * 5],
    } | changes


def spare_of(table: Any) -> Spare:
    fields = Fields(json.loads(json.dumps(table)), "f.json", "spare")
    return Spare.from_fields(fields, SENSORS, len(AXES[0]))


def step(
    spare: Spare, readings: Array, bad: tuple[int, ...] = (), elapsed_s: float = 10.0
) -> list[float] | None:
    shown = [nan if place in bad else value for place, value in enumerate(readings.tolist())]
    return spare.step(shown, bad, 0.0, elapsed_s, RECOVER_S, AXES)


FIRST = np.array([20.0, 21.0, 19.5, 22.0, 30.0])


@pytest.mark.parametrize("bad", [(0,), (1, 4), (0, 2, 3), (1, 2, 3, 4)])
@pytest.mark.parametrize("seed", range(3))
def test_after_long_it_is_the_conditional_mean_and_deviation(seed, bad):
    known, random = covariance(seed), np.random.default_rng(seed)
    spare = spare_of(table_of(known))
    rises = random.normal(0.0, 3.0, SENSORS)
    step(spare, FIRST)
    used = step(spare, FIRST + rises, bad, 1e8)  # what was a sensor's own is forgotten by then
    used = step(spare, FIRST + rises, bad, 1e8)
    good = [place for place in range(SENSORS) if place not in bad]
    weights = known[np.ix_(bad, good)] @ np.linalg.inv(known[np.ix_(good, good)])
    assert np.array(used)[good] == pytest.approx((FIRST + rises)[good])
    assert np.array(used)[list(bad)] == pytest.approx(FIRST[list(bad)] + weights @ rises[good])
    left = known[np.ix_(bad, bad)] - weights @ known[np.ix_(good, bad)]
    table = table_of(known)
    grown = np.sqrt(np.array(table["growth"])[list(bad)])
    moved = np.array(AXES) @ np.array(table["sensitivity"])[:, list(bad)] * grown
    assert spare.added == pytest.approx(np.einsum("ij,jk,ik->i", moved, left, moved))
    assert spare.added[1] == 0.0


def test_it_goes_on_from_where_it_stood_and_forgets_that_with_time():
    known = covariance(7)
    spare = spare_of(table_of(known))
    rises = np.array([5.0, 5.0, -1.0, 2.0, 0.0])  # far from what the others say
    step(spare, FIRST)
    for _ in range(20):
        step(spare, FIRST + rises)
    good = [1, 2, 3, 4]
    likely = known[0, good] @ np.linalg.inv(known[np.ix_(good, good)]) @ rises[good]
    assert abs(likely - rises[0]) > 0.5
    first = step(spare, FIRST + rises, (0,))
    # Four samples ago it was compared with the others.
    stood = likely + (rises[0] - likely) * exp(-50.0 / MEMORY_S)
    assert first[0] == pytest.approx(FIRST[0] + stood)
    doubt = spare.added[0]  # hardly any so soon
    steps = [first[0]]
    while len(steps) < 1000:
        found = step(spare, FIRST + rises, (0,))
        steps.append(found[0])
    assert np.max(np.abs(np.diff(steps))) < 0.05
    assert 0.0 < doubt < 0.1 * spare.added[0]
    own = (rises[0] - likely) * exp(-1000 * 10.0 / MEMORY_S)
    assert steps[-1] == pytest.approx(FIRST[0] + likely + own, rel=1e-3)


def test_a_sensor_comes_back_after_a_while():
    spare = spare_of(table_of(covariance(7)))
    rises = np.array([5.0, 5.0, -1.0, 2.0, 0.0])
    step(spare, FIRST)
    step(spare, FIRST + rises, (0,))
    away = step(spare, FIRST + rises, (0,), 1e6)
    waiting = step(spare, FIRST + rises, (), 5.0)
    assert spare.broken == [0]
    back = step(spare, FIRST + rises, (), 5.0)
    assert spare.broken == []
    assert waiting[0] == pytest.approx(away[0], abs=0.01)
    assert back == pytest.approx(FIRST + rises)
    assert spare.added == [0.0, 0.0, 0.0]


def test_it_goes_on_as_long_as_one_sensor_is_good():
    spare = spare_of(table_of(covariance(1)))
    assert step(spare, FIRST, (2,)) is None  # no reference yet
    assert step(spare, FIRST) is not None
    for bad in ((0,), (0, 2), (0, 2, 3), (0, 1, 2, 3)):
        assert step(spare, FIRST, bad) is not None
        assert spare.broken == list(bad)
    assert step(spare, FIRST, (0, 1, 2, 3, 4)) is None  # nobody is left to tell
    assert step(spare, FIRST) == FIRST.tolist()  # all good again


def test_a_state_goes_on_in_another():
    table = table_of(covariance(4))
    one, other = spare_of(table), spare_of(table)
    random = np.random.default_rng(4)
    for k in range(60):
        readings = FIRST + random.normal(0.0, 0.2, SENSORS) + 0.05 * k
        bad = (1,) if 10 < k < 30 else (1, 3) if 30 <= k < 40 else ()
        assert step(one, readings, bad) == step(other, readings, bad)
        fresh = spare_of(table)
        fresh.restore(other.state())
        assert fresh.state() == other.state()
        other = fresh
    with pytest.raises(ValueError, match="numbers"):
        one.restore([0.0])
    with pytest.raises(ValueError, match="counts 9 of 5"):
        one.restore([*one.state()[:2], 9.0, *one.state()[3:]])


def test_a_state_comes_back_in_one_whose_sensors_are_all_good_again():
    spare = spare_of(table_of(covariance(4)))
    step(spare, FIRST)
    step(spare, FIRST + 1.0, (1,))
    kept = spare.state()
    while spare.broken:
        step(spare, FIRST + 1.0)
    spare.restore(kept)
    assert spare.state() == kept


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"memory_s": 0.0}, "spare.memory_s: 0.0 is not allowed"),
        ({"growth": [1.0, 1.0, -1.0, 1.0, 1.0]}, "spare.growth.2: -1.0 is not allowed: "),
        ({"sensitivity": [[1.0] * 5]}, "spare.sensitivity"),
        ({"precision": [[1.0] * 4] * 5}, "spare.precision.0"),
        ({"precision": np.zeros((5, 5)).tolist()}, "precision.0.0: 0 is not allowed: the matrix"),
        ({"precision": np.ones((5, 5)).tolist()}, "precision.1.1: 1 is not allowed: the matrix"),
        ({"precision": (np.eye(5) + np.eye(5, k=1) / 9).tolist()}, "must be that of precision.0.1"),
        ({"more": 1}, "is not a known field"),
    ],
)
def test_a_wrong_field_is_refused_in_one_line(change, problem):
    assert problem in refusal(spare_of, table_of(covariance(0)) | change)


def test_a_file_that_still_tells_the_usual_drift_is_read():
    table = table_of(covariance(0))
    assert spare_of(table | {"usual": [[1.0, 0.0], [0.0, 1.0]]}).state() == spare_of(table).state()


def test_the_fit_finds_what_the_sensors_have_in_common():
    random = np.random.default_rng(11)
    slopes = np.array([1.0, 2.0, -1.0, 0.5])

    def run() -> Array:
        heat = np.cumsum(random.normal(0.05, 0.2, 100))
        return np.outer(heat, slopes) + random.normal(0.0, 0.1, (100, 4))

    runs = [run() for _ in range(5)]
    errors = left_out_errors(runs, best_strength(runs))
    assert max(np.sqrt(np.mean(one**2)) for one in errors) < 0.3
    known = precision(runs, best_strength(runs))
    assert known == pytest.approx(known.T)
    # A sensor apart from all others is not believed to be told by them.
    apart = [np.column_stack([one, random.normal(0.0, 3.0, 100)]) for one in runs]
    found = left_out_errors(apart, 1e-3)
    deviation = np.sqrt(np.mean([(one**2).mean(axis=0) for one in found], axis=0))
    assert deviation[4] == pytest.approx(3.0, rel=0.2)
    assert deviation[:4].max() < 0.5
