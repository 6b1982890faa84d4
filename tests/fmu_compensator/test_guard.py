"""The careful model, its novelty, the leash and the fade, beside sums made with matrices."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.fields import Fields, ModelFileError
from fmu_compensator.runtime.guard import CULPRIT_SHARE, CULPRITS, Careful, Guard

Array = npt.NDArray[np.float64]
INPUTS, TARGETS = 4, 3
LAGS_S = (300.0, 5400.0)
WIDTH = INPUTS * (1 + 2 * len(LAGS_S))
RIDGE = 40.0  # lambda [K^2]


def trained(random: np.random.Generator, reference: str, rows: int = 6) -> tuple[Array, Any]:
    """Return what training saw, shape (rows, WIDTH), and the table that a fit makes of it."""
    seen = random.normal(0.0, 5.0, (rows, WIDTH))
    _, size, directions = np.linalg.svd(seen, full_matrices=False)
    kept = np.sqrt(size**2 / (RIDGE * (RIDGE + size**2)))

    def matrix() -> Any:
        return random.normal(0.0, 1.0, (TARGETS, INPUTS)).tolist()

    return seen, {
        "lags_s": list(LAGS_S),
        "reference": reference,
        "usual": random.normal(20.0 if reference == "fixed" else 0.0, 1.0, INPUTS).tolist(),
        "constant": random.normal(0.0, 1.0, TARGETS).tolist(),
        "direct": matrix(),
        "rise_lags": [matrix() for _ in LAGS_S],
        "start_lags": [matrix() for _ in LAGS_S],
        "prior": 1.0 / RIDGE,
        "seen": (kept[:, None] * directions).tolist(),
        "known": 1.5,
        "leash": [1.0, 2.0, 0.0],
        "fade_shortest": [0.5, None, 2.0],
        "fade_longest": [1.5, None, 0.0],
    }


def guard_of(table: Any) -> Guard:
    return Guard.from_fields(Fields(json.loads(json.dumps(table)), "f.json", "guard"), 4, TARGETS)


def warming(random: np.random.Generator) -> tuple[Array, Array]:
    """Return times and temperatures of a run with uneven steps, shapes (n,) and (n, INPUTS)."""
    time = np.cumsum(random.choice([1.0, 30.0, 600.0], 60))
    return time, 20.0 + np.cumsum(random.normal(0.1, 0.4, (60, INPUTS)), axis=0)


def features_of(table: Any, time: Array, readings: Array) -> Array:
    """Return each sample's features by the sum over all samples before, shape (n, WIDTH)."""
    fixed = table["reference"] == "fixed"
    usual = np.array(table["usual"])
    rises = readings - (usual if fixed else readings[0])
    starts = np.zeros(INPUTS) if fixed else readings[0] - np.median(readings[0]) - usual
    steps = np.diff(time, prepend=time[0])
    columns = [rises]
    for tau in LAGS_S:
        after = (time[:, None] - time[None, :]) / tau
        share = np.tril(np.exp(-np.abs(after))) * (1.0 - np.exp(-steps / tau))
        columns += [share @ rises, share.sum(axis=1)[:, None] * starts]
    return np.hstack(columns)


def run_through(guard: Guard, time: Array, readings: Array) -> list[Careful]:
    steps = np.diff(time, prepend=time[0] - 77.0)  # what passed before the first does not count
    return [
        guard.step(row, step) for row, step in zip(readings.tolist(), steps.tolist(), strict=True)
    ]


@pytest.mark.parametrize("reference", ["start", "fixed"])
@pytest.mark.parametrize("seed", range(4))
def test_novelty_is_the_leverage_beside_all_that_training_saw(seed: int, reference: str) -> None:
    random = np.random.default_rng(seed)
    seen, table = trained(random, reference)
    time, readings = warming(random)
    features = features_of(table, time, readings)
    known = RIDGE * np.eye(WIDTH) + seen.T @ seen
    leverage = np.einsum("nw,wn->n", features, np.linalg.solve(known, features.T))
    found = [one.novelty for one in run_through(guard_of(table), time, readings)]
    assert found == pytest.approx(leverage, rel=1e-9, abs=1e-12)
    assert max(found) > 1.0


@pytest.mark.parametrize("reference", ["start", "fixed"])
def test_the_careful_model_is_the_sum_of_its_matrices(reference: str) -> None:
    random = np.random.default_rng(5)
    _, table = trained(random, reference)
    time, readings = warming(random)
    parts = [table["direct"]]
    for lag in range(len(LAGS_S)):
        parts += [table["rise_lags"][lag], table["start_lags"][lag]]
    expected = table["constant"] + features_of(table, time, readings) @ np.hstack(parts).T
    found = [one.targets for one in run_through(guard_of(table), time, readings)]
    assert np.array(found) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_nothing_is_new_before_anything_moved() -> None:
    _, table = trained(np.random.default_rng(6), "start")
    first = guard_of(table).step([20.0, 21.0, 25.0, 19.0], 0.0)
    assert first == (table["constant"], 0.0)


def test_without_a_direction_seen_all_of_the_prior_is_left() -> None:
    _, table = trained(np.random.default_rng(7), "start")
    guard = guard_of(table | {"seen": [], "prior": 0.25})
    guard.step([20.0] * INPUTS, 0.0)
    moved = guard.step([20.0, 22.0, 20.0, 19.0], 0.0)
    assert moved.novelty == 0.25 * (4.0 + 1.0)


@given(st.lists(st.floats(-1e6, 1e6), min_size=TARGETS, max_size=TARGETS))
def test_the_leash_moves_a_prediction_no_further_than_it_must(targets: list[float]) -> None:
    _, table = trained(np.random.default_rng(8), "start")
    careful = [10.0, -3.0, 7.0]
    held = guard_of(table).held(targets, careful)
    for value, found, safe, leash in zip(targets, held, careful, table["leash"], strict=True):
        assert found == np.clip(value, safe - leash, safe + leash)


def test_the_fade_starts_at_what_is_known_and_only_falls() -> None:
    _, table = trained(np.random.default_rng(9), "start")
    guard = guard_of(table)
    just = [guard.faded(0, novelty, 0.5, 1.0) for novelty in (0.0, 1.5, 1.5 + 1e-9)]
    assert just == [1.0, 1.0, pytest.approx(1.0, abs=1e-8)]
    beyond = np.array([guard.faded(0, novelty, 0.5, 1.0) for novelty in np.linspace(1.5, 1e3, 99)])
    assert np.all(np.diff(beyond) < 0.0)
    assert 0.0 < beyond[-1] < 0.002


def test_the_fade_is_that_of_the_axis_the_tool_and_the_doubt() -> None:
    _, table = trained(np.random.default_rng(10), "start")
    guard = guard_of(table)
    # Two beyond the known novelty; 0.5 at the shortest tool and 1.5 at the longest.
    assert guard.faded(0, 3.5, 0.0, 1.0) == 1.0 / (1.0 + 0.5 * 2.0)
    assert guard.faded(0, 3.5, 1.0, 1.0) == 1.0 / (1.0 + 1.5 * 2.0)
    assert guard.faded(0, 3.5, 0.5, 0.25) == 1.0 / (1.0 + 1.0 * 2.0 * 0.25)
    # A measurement leaves no doubt, nothing is measured along Y, and nothing fades Z here.
    assert guard.faded(0, 3.5, 0.5, 0.0) == guard.faded(1, 1e6, 0.5, 1.0) == 1.0
    assert guard.faded(2, 3.5, 1.0, 1.0) == 1.0


@pytest.mark.parametrize("seed", range(4))
def test_culprits_are_the_inputs_that_bring_most_of_the_novelty(seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    seen, table = trained(random, "start", rows=15)
    time, readings = warming(random)
    guard = guard_of(table)
    novelty = run_through(guard, time, readings)[-1].novelty
    last = features_of(table, time, readings)[-1]
    known = RIDGE * np.eye(WIDTH) + seen.T @ seen
    shares = (last * np.linalg.solve(known, last)).reshape(-1, INPUTS).sum(axis=0)
    order = np.argsort(-shares).tolist()
    wanted = [place for place in order[:CULPRITS] if shares[place] >= CULPRIT_SHARE * novelty]
    assert guard.culprits(novelty) == wanted


def test_one_input_is_always_to_blame_and_never_more_than_three() -> None:
    _, table = trained(np.random.default_rng(11), "start")
    guard = guard_of(table | {"seen": []})
    guard.step([20.0] * INPUTS, 0.0)
    novelty = guard.step([20.0, 23.0, 20.0, 22.0], 0.0).novelty
    assert guard.culprits(novelty) == [1, 3]
    assert guard.culprits(100.0 * novelty) == [1]
    novelty = guard.step([21.0] * INPUTS, 0.0).novelty
    assert guard.culprits(novelty) == [0, 1, 2]


def test_a_state_goes_on_where_it_was_left_and_a_reset_starts_over() -> None:
    random = np.random.default_rng(12)
    _, table = trained(random, "start")
    time, readings = warming(random)
    whole, other = guard_of(table), guard_of(table)
    run_through(whole, time[:30], readings[:30])
    run_through(other, time[:7], readings[7:14])  # a past of its own, to be overwritten
    other.restore(json.loads(json.dumps(whole.state())))
    for row, step in zip(readings[30:].tolist(), np.diff(time)[29:].tolist(), strict=True):
        assert other.step(row, step) == whole.step(row, step)
    assert other.culprits(1.0) == whole.culprits(1.0)
    other.reset()
    assert other.state() == guard_of(table).state()


@pytest.mark.parametrize("damage", ["short", "long", "nan", "text"])
def test_a_foreign_state_is_refused(damage: str) -> None:
    _, table = trained(np.random.default_rng(13), "start")
    guard = guard_of(table)
    state: list[Any] = guard.state()
    damaged = {
        "short": state[:-1],
        "long": [*state, 0.0],
        "nan": [*state[:-1], float("nan")],
        "text": [*state[:-1], "1"],
    }
    with pytest.raises(ValueError, match="state"):
        guard.restore(damaged[damage])


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("lags_s", [300.0, 0.5], "lags_s.1: 0.5 is not allowed: at least 1 s"),
        ("lags_s", [300.0], "rise_lags: "),
        ("reference", "usual", "reference: 'usual' is not allowed: must be one of start, fixed"),
        ("usual", [0.0] * 3, "usual: "),
        ("usual", [0.0, 0.0, 0.0, 2e4], "usual.3: "),
        ("constant", [0.0, None, 0.0], "constant.1: "),
        ("direct", [[0.0] * INPUTS] * 2, "direct: "),
        ("rise_lags", [[[0.0] * INPUTS] * TARGETS], "rise_lags: "),
        ("start_lags", [[[0.0] * INPUTS] * TARGETS, [[0.0] * 3] * TARGETS], "start_lags.1.0: "),
        ("prior", -1.0, "prior: -1.0 is not allowed: must be a number from 0 to"),
        ("seen", [[0.0] * (WIDTH - 1)], "seen.0: "),
        ("seen", [[0.0] * WIDTH] * 2001, "seen: "),
        ("seen", None, "seen: "),
        ("known", -0.1, "known: "),
        ("leash", [1.0, -2.0, 1.0], "leash.1: -2 is not allowed: at least 0"),
        ("leash", [1.0, 2.0], "leash: "),
        ("fade_shortest", [1.0, 2.0], "fade_shortest: "),
        ("fade_shortest", [1.0, -2.0, None], "fade_shortest.1: "),
        ("fade_longest", [None, None, True], "fade_longest.2: "),
        ("more", 1.0, "'more': is not a known field"),
    ],
)
def test_every_field_is_refused_in_one_line(field: str, value: Any, told: str) -> None:
    _, table = trained(np.random.default_rng(14), "start")
    with pytest.raises(ModelFileError) as caught:
        guard_of(table | {field: value})
    assert str(caught.value).startswith(f"f.json: guard.{told}")
    assert len(str(caught.value).splitlines()) == 1


def test_a_missing_field_is_named() -> None:
    _, table = trained(np.random.default_rng(15), "start")
    for field in table:
        with pytest.raises(ModelFileError) as caught:
            guard_of({name: value for name, value in table.items() if name != field})
        assert str(caught.value) == f"f.json: guard.{field}: is missing"


def test_a_lone_wrong_level_is_not_taken_for_heat_but_a_warm_restart_is() -> None:
    random = np.random.default_rng(21)
    _, table = trained(random, "start")
    table["usual"] = [0.0, 0.5, -0.5, 0.0]
    time, readings = warming(random)
    readings[:] += 20.0 + np.array(table["usual"]) - readings[0]
    right = run_through(guard_of(table), time, readings)
    off = readings + np.array([0.0, 31.0, 0.0, 0.0])
    wrong = run_through(guard_of(table), time, off)
    for one, other in zip(right, wrong, strict=True):
        assert other.novelty == pytest.approx(one.novelty, rel=1e-9, abs=1e-12)
        assert other.targets == pytest.approx(one.targets, rel=1e-9, abs=1e-12)
    # Heat left from before is in more than one place, and a few kelvins may be in one.
    for warm in ([0.0, 31.0, 14.0, 0.0], [0.0, 6.0, 0.0, 0.0]):
        restarted = run_through(guard_of(table), time, readings + np.array(warm))
        assert restarted[-1].novelty > 1.1 * right[-1].novelty
