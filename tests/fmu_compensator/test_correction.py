"""The bias from measurements, beside Gaussian-process regression and by its own promises."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from fmu_compensator.runtime.correction import FURTHEST, Correction
from fmu_compensator.runtime.fields import Fields, ModelFileError

TABLE: dict[str, Any] = {"memory_s": 1800.0, "spread": [5.0, 2.0], "noise": [1.0, 0.04]}


def correction_of(table: Any = TABLE) -> Correction:
    return Correction.from_fields(Fields(dict(table), "f.json", "correction"), 2)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_the_regression_of_an_ornstein_uhlenbeck_process(seed: int) -> None:
    random = np.random.default_rng(seed)
    correction = correction_of()
    spread, noise = (np.array(TABLE[key]) for key in ("spread", "noise"))
    growth = 1.5
    time = np.cumsum(random.choice([10.0, 600.0, 4000.0], 25))
    now = time[-1] + 300.0
    errors = np.zeros((25, 2))
    # A sample of the process itself, so that no measurement is a stray one.
    kept = np.exp(-np.diff(time) / TABLE["memory_s"])
    errors[0] = random.normal(0.0, 0.5 * spread)
    for k, part in enumerate(kept):
        errors[k + 1] = part * errors[k] + random.normal(0.0, 0.5 * spread * np.sqrt(1 - part**2))
    measured = errors + random.normal(0.0, 0.5 * np.sqrt(noise), errors.shape)
    for k, wait in enumerate(np.diff(time, append=now)):
        correction.take((measured[k] - correction.bias).tolist(), growth)
        correction.wait(wait)
    alike = np.exp(-np.abs(time[:, None] - time[None, :]) / TABLE["memory_s"])
    until = np.exp(-(now - time) / TABLE["memory_s"])
    left = []
    for target in range(2):
        variance = (spread[target] * growth) ** 2
        weights = np.linalg.solve(variance * alike + noise[target] * np.eye(25), variance * until)
        assert correction.bias[target] == pytest.approx(weights @ measured[:, target], rel=1e-8)
        left.append(1.0 - weights @ until)
    assert correction.state()[2:4] == pytest.approx(left, rel=1e-8)
    assert correction.doubt == pytest.approx(max(left), rel=1e-8)


def test_without_a_measurement_nothing_is_corrected() -> None:
    correction = correction_of()
    correction.wait(1e9)
    assert (correction.bias, correction.doubt) == ([0.0, 0.0], 1.0)


def test_a_bad_probe_changes_nothing() -> None:
    correction = correction_of()
    correction.take([3.0, 0.5], 1.0)
    bias, doubt = list(correction.bias), correction.doubt
    correction.take([100.0, -100.0], 1.0)
    assert (correction.bias, correction.doubt) == (bias, doubt)
    # One that disagrees with it is not its confirmation; a good one ends the wait.
    correction.take([-100.0, 100.0], 1.0)
    assert correction.bias == bias
    correction.take([0.5, 0.1], 1.0)
    assert correction.bias == pytest.approx([bias[0] + 0.25, bias[1] + 0.05], abs=0.05)
    correction.take([100.0, -100.0], 1.0)
    assert correction.bias == pytest.approx([bias[0] + 0.25, bias[1] + 0.05], abs=0.05)


def test_an_error_beyond_all_expectation_is_taken_in_once_confirmed() -> None:
    correction = correction_of()
    truth = np.array([3.0 * FURTHEST * 5.0, -3.0 * FURTHEST * 2.0])
    correction.take(truth.tolist(), 1.0)
    assert correction.bias == [0.0, 0.0]
    assert correction.doubt == 1.0
    correction.wait(600.0)
    again = truth + np.array([2.0, -0.5])
    correction.take(again.tolist(), 1.0)
    assert correction.bias == pytest.approx(again.tolist(), rel=0.05)
    assert correction.doubt < 0.05


def test_what_was_measured_is_believed_less_and_less() -> None:
    correction = correction_of()
    correction.take([4.0, 1.0], 1.0)
    bias, doubt = list(correction.bias), correction.doubt
    assert doubt == pytest.approx(1.0 / 26.0)
    correction.wait(1800.0)
    assert correction.bias == pytest.approx([value * np.exp(-1.0) for value in bias])
    assert correction.doubt == pytest.approx(1.0 - (1.0 - doubt) * np.exp(-2.0))
    correction.wait(1e9)
    assert correction.bias == [0.0, 0.0]
    assert correction.doubt == 1.0


def test_growth_is_a_larger_spread() -> None:
    grown, wide = correction_of(), correction_of(TABLE | {"spread": [15.0, 6.0]})
    for missed in ([3.0, -1.0], [80.0, -0.5]):
        grown.take(missed, 3.0)
        wide.take(missed, 1.0)
    assert grown.state() == wide.state()


def test_a_state_goes_on_where_it_was_left_and_a_reset_starts_over() -> None:
    whole, other = correction_of(), correction_of()
    whole.take([3.0, -1.0], 1.0)
    other.take([9.0, 9.0], 2.0)
    other.restore(json.loads(json.dumps(whole.state())))
    for one in (whole, other):
        one.wait(100.0)
        one.take([1.0, 1.0], 1.2)
    assert other.state() == whole.state()
    other.reset()
    assert other.state() == correction_of().state() == [0.0, 0.0, 1.0, 1.0] + [0.0] * 6


@pytest.mark.parametrize("state", [[], [0.0] * 9, [0.0] * 11, [0.0] * 9 + [None]])
def test_a_foreign_state_is_refused(state: Any) -> None:
    with pytest.raises(ValueError, match="state"):
        correction_of().restore(state)


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("memory_s", 0.5, "memory_s: 0.5 is not allowed: must be a number from 1 to 1e+09"),
        ("memory_s", None, "memory_s: "),
        ("spread", [1.0], "spread: "),
        ("spread", [1.0, 0.0], "spread.1: 0 is not allowed: above 0"),
        ("noise", [-1.0, 1.0], "noise.0: -1 is not allowed: above 0"),
        ("noise", [1.0, 2e9], "noise.1: "),
        ("more", 1.0, "'more': is not a known field"),
    ],
)
def test_every_field_is_refused_in_one_line(field: str, value: Any, told: str) -> None:
    with pytest.raises(ModelFileError) as caught:
        correction_of(TABLE | {field: value})
    assert str(caught.value).startswith(f"f.json: correction.{told}")
    assert len(str(caught.value).splitlines()) == 1


def test_a_missing_field_is_named() -> None:
    for field in TABLE:
        with pytest.raises(ModelFileError) as caught:
            correction_of({name: value for name, value in TABLE.items() if name != field})
        assert str(caught.value) == f"f.json: correction.{field}: is missing"


def test_what_comes_and_goes_too_fast_stays_in_doubt() -> None:
    correction = correction_of(TABLE | {"fast": 0.2})
    assert correction.doubt == pytest.approx(1.0)
    for _ in range(50):
        correction.take([0.0, 0.0], 1.0)
    assert correction.doubt == pytest.approx(0.2, abs=0.01)
    correction.wait(1e9)
    assert correction.doubt == pytest.approx(1.0)
