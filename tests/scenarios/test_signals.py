"""Signals: values worked out by hand, and refusals."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.errors import BadInput
from scenarios.signals import build
from scenarios.signals.base import Setting

TIMES = np.array([0.0, 1.0, 5.0, 9.0, 10.0, 11.0, 30.0])


def setting(folder: Path = Path(), seed: int = 1, place: str = "signals.speed") -> Setting:
    return Setting("scenario.toml", place, folder, seed)


def values(entry: object, times: np.ndarray = TIMES) -> list[float]:
    return list(build(entry, setting()).values(times, setting()))


def test_a_scaled_signal_is_a_factor_times_another():
    inner = {"kind": "ramp", "start": 2.0, "end": 6.0, "end_s": 100.0}
    scaled = values({"kind": "scaled", "signal": inner, "factor": -0.5})
    assert scaled == [-0.5 * value for value in values(inner)]
    with pytest.raises(BadInput, match=r"signals\.speed\.signal\.kind: 'rmap' is not a kind"):
        build({"kind": "scaled", "signal": {"kind": "rmap"}, "factor": 1.0}, setting())


LEVELS = {"kind": "steps", "values": [1, 2]}
RAMP = {"kind": "ramp", "start": 0, "end": 8, "start_s": 1, "end_s": 9}
SINE = {"kind": "sine", "mean": 20, "amplitude": 2, "period_s": 40, "phase_deg": 90}
RISE = {"kind": "first_order", "start": 10, "end": 20, "time_constant_s": 5, "start_s": 5}
SUM = {"kind": "sum", "parts": [1, {"kind": "steps", "times_s": [0, 5], "values": [0, 2]}]}


@pytest.mark.parametrize(
    ("entry", "times", "expected"),
    [
        (LEVELS | {"times_s": [5, 10]}, TIMES, [1, 1, 1, 1, 2, 2, 2]),
        (LEVELS | {"times_s": [0, 5], "repeat_s": 10}, TIMES, [1, 1, 2, 2, 1, 1, 1]),
        (RAMP, TIMES, [0, 0, 4, 8, 8, 8, 8]),
        (SINE, np.array([0.0, 10.0, 20.0]), [22, 20, 18]),
        (RISE, np.array([0.0, 5.0, 10.0]), [10, 10, 10 + 10 * (1 - np.exp(-1))]),
        (SUM, TIMES, [1, 1, 3, 3, 3, 3, 3]),
    ],
    ids=["steps", "repeated steps", "ramp", "sine", "first order", "sum"],
)
def test_a_signal_has_the_values_worked_out_by_hand(entry, times, expected):
    assert values(entry, times) == pytest.approx(expected)


STEPS_S = ["0.05", "0.1", "0.3", "0.35", "0.7", "2.5"]


@pytest.mark.parametrize("step", STEPS_S)
def test_steps_jump_at_the_communication_point_that_the_scenario_names(step):
    # The moments as a scenario file spells them; multiples of the float lie above or below.
    moments = [float(Fraction(step) * k) for k in range(1, 300)]
    steps = {"kind": "steps", "times_s": moments, "values": list(range(1, 300))}
    assert values(steps, np.arange(300) * float(step))[1:] == list(range(1, 300))


@pytest.mark.parametrize("step", STEPS_S)
@pytest.mark.parametrize("count", [2, 3, 7])
def test_steps_repeat_at_the_communication_points_that_the_scenario_names(step, count):
    moments = [float(Fraction(step) * k) for k in range(count)]
    period_s = float(Fraction(step) * count)
    steps = {
        "kind": "steps",
        "times_s": moments,
        "values": list(range(count)),
        "repeat_s": period_s,
    }
    times = np.arange(3000) * float(step)
    assert values(steps, times) == [k % count for k in range(3000)]


def test_table_holds_commands_and_interpolates_measurements(tmp_path):
    (tmp_path / "run.csv").write_text(
        "time_s,speed_rpm,T5_degC\n100,1000,20\n104,2000,22\n108,,26\n", encoding="utf-8"
    )
    times = np.array([0.0, 2.0, 4.0, 6.0, 20.0])

    def column(name: str) -> list[float]:
        entry = {"kind": "table", "file": "run.csv", "column": name}
        return list(build(entry, setting(tmp_path)).values(times, setting(tmp_path)))

    assert column("speed_rpm") == [1000, 1000, 2000, 2000, 2000]
    assert column("T5_degC") == pytest.approx([20, 21, 22, 24, 26])
    with pytest.raises(BadInput, match=r"signals.speed.column: 'T9_degC' is not a column"):
        column("T9_degC")


def test_table_changes_a_command_at_its_row_whenever_the_run_began(tmp_path):
    rows = "".join(f"{100.1 + k * 0.1:.1f},{k}\n" for k in range(300))
    (tmp_path / "run.csv").write_text(f"time_s,speed_rpm\n{rows}", encoding="utf-8")
    entry = {"kind": "table", "file": "run.csv", "column": "speed_rpm"}
    found = build(entry, setting(tmp_path)).values(np.arange(300) * 0.1, setting(tmp_path))
    assert list(found) == list(range(300))


RANDOM = {"kind": "random_steps", "low": 100, "high": 900, "dwell_s": [10, 60], "round_to": 100}


@given(seed=st.integers(0, 2**31 - 1), stops=st.floats(0.0, 1.0))
def test_random_steps_stay_in_range_and_dwell_long_enough(seed, stops):
    signal = build({**RANDOM, "stops": stops}, setting())
    times = np.arange(0.0, 2000.0)
    found = signal.values(times, setting(seed=seed))
    assert set(found) <= {0.0, *np.arange(100.0, 901.0, 100.0)}
    changes = np.flatnonzero(np.diff(found)) + 1
    # A level may be drawn twice in a row, so only the shortest stay is certain.
    assert np.all(np.diff([0, *changes]) >= 9)
    again = signal.values(times, setting(seed=seed))
    assert np.array_equal(found, again)


def test_random_steps_of_a_longer_scenario_begin_as_those_of_a_shorter_one():
    signal = build(RANDOM, setting())
    short = signal.values(np.arange(0.0, 500.0), setting())
    long = signal.values(np.arange(0.0, 5000.0), setting())
    assert np.array_equal(short, long[:500])


def test_random_steps_differ_between_seeds_and_between_signals():
    signal, times = build(RANDOM, setting()), np.arange(0.0, 5000.0)
    found = [
        signal.values(times, setting()),
        signal.values(times, setting(seed=2)),
        signal.values(times, setting(place="signals.torque")),
    ]
    assert not np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], found[2])


REFUSED = [
    ({"kind": "stepps"}, "did you mean steps"),
    ({"value": 3}, "kind: is missing"),
    ({"kind": "constant"}, "value: is missing"),
    ({"kind": "constant", "value": True}, "value: True"),
    ({"kind": "constant", "value": float("nan")}, "value: nan"),
    ("fast", "'fast' is not allowed"),
    (True, "True is not allowed"),
    ({"kind": "steps", "times_s": [0, 1], "values": [1]}, "as many are needed"),
    ({"kind": "steps", "times_s": [1, 1], "values": [1, 2]}, "must increase"),
    ({"kind": "steps", "times_s": [0, 9], "values": [1, 2], "repeat_s": 9}, "repeat_s"),
    ({"kind": "ramp", "start": 0, "end": 1, "start_s": 9, "end_s": 9}, "end_s, 9"),
    ({"kind": "random_steps", "low": 2, "high": 1, "dwell_s": [1, 2]}, "low, 2"),
    ({"kind": "random_steps", "low": 1, "high": 2, "dwell_s": [5, 2]}, "shortest"),
    ({"kind": "sum", "parts": [{"kind": "sine"}]}, "parts, item 1, amplitude: is missing"),
    ({"kind": "sum", "parts": []}, "parts"),
]


@pytest.mark.parametrize(("entry", "message"), REFUSED)
def test_refusals_name_the_place(entry, message):
    with pytest.raises(BadInput, match=message) as caught:
        build(entry, setting())
    assert str(caught.value).startswith("scenario.toml: signals.speed")


def test_sums_nest_only_so_deep():
    entry: object = 1.0
    for _ in range(10_000):
        entry = {"kind": "sum", "parts": [entry]}
    with pytest.raises(BadInput, match="sums nest too deep"):
        build(entry, setting())
