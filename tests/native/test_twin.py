"""The C program gives the numbers of the Python runtime, for every error model, whatever comes in.

It runs under the address and undefined-behaviour sanitizers. All that either remembers is compared,
not only the outputs.
"""

import json
from collections.abc import Collection
from math import inf, isclose, isnan, nan
from typing import Any

import pytest

from fmu_compensator.native.generate import kinds
from fmu_compensator.runtime.compensator import (
    HOLDING,
    OK,
    SPARED,
    UNTRAINED,
    Output,
    RunningCompensator,
)
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.gaussian import MOST_PROBES
from fmu_compensator.runtime.modelfile import Model
from tests.native.made import MADE, SEEDS, SIX, Samples, made_model

KINDS = sorted(error_models())
STEPS = 900
TIGHT = 1e-12  # relative; absolute in um and urad for what lies near zero
Row = tuple[list[float], ...]


def test_every_error_model_has_a_c_twin_and_is_tested():
    assert kinds() == KINDS
    assert sorted(MADE) == KINDS


def written(values: list[float]) -> str:
    return " ".join(str(value) if isnan(value) else value.hex() for value in values)


def line_of(model: Model, sample: Any) -> list[str]:
    """Return the driver's lines of one sample."""
    time, step, temperatures, speed, tool, measured = sample
    values = [*temperatures, speed, tool]
    values += [*(measured or [0.0] * len(model.targets)), float(measured is not None)]
    return [f"i {written(values)}", f"d {written([time, step])}"]


def remembered(compensator: RunningCompensator) -> Row:
    """Return a state as the driver shows one."""
    state = compensator.state()
    cause, sensor = state["fault"][:2] if state["fault"] else (0, 0)
    spared, spared_sensor = state["spared"][:2] if state["spared"] else (0, 0)
    measured = state["measured"] or [nan] * len(compensator.model.targets)
    single = [
        state["last_time"],
        state["started"],
        state["recovering"],
        cause,
        sensor,
        spared,
        spared_sensor,
        state["fault_age"],
        state["good_for"],
        state["unmodelled"],
        state["measured"] is not None,
    ]
    checks = zip(state["reference"], state["checks"], strict=True)
    numbers = [value for reference, check in checks for value in (reference, *check)]
    numbers += in_lanes(compensator.model, state["gaussian"])
    numbers += [*by_sensor(state["spare"]), *state["error_model"]]
    rows = (state[name] for name in ("wanted", "offset", "pose", "half_width"))
    parts = (single, *rows, measured, state["targets"], numbers)
    return tuple([nan if value is None else float(value) for value in part] for part in parts)


def in_lanes(model: Model, state: list[float]) -> list[float]:
    """Return a Gaussian's state as C has it: as long with measurements as without."""
    learnt = model.table["gaussian"]
    targets, width = len(learnt["weights"]), len(learnt["weights"][0])
    suspected, probes, rest = int(state[6]), int(state[7]), iter(state[8:])

    def rows(count: int, length: int) -> list[list[float]]:
        return [[next(rest) for _ in range(length)] for _ in range(count)]

    (features,) = rows(1, width)
    both, (suspect,) = rows(2, targets), rows(1, suspected)
    none = [[0.0] * (width + 1)] * MOST_PROBES
    held = none[probes:] + rows(probes, width + 1)
    weights = rows(targets, width) if probes else learnt["weights"]
    bias, added = both
    weights = [[*row, last] for row, last in zip(weights, bias, strict=True)] + none[targets:]
    assert next(rest, None) is None
    return [
        *state[:6],
        float(suspected > 0),
        *padded(suspect),
        *padded(added),
        *features,
        1.0,
        *(value for lanes in zip(*weights, strict=True) for value in lanes),
        *(value for lanes in zip(*held, strict=True) for value in lanes),
    ]


def padded(values: list[float]) -> list[float]:
    return values + [0.0] * (MOST_PROBES - len(values))


def by_sensor(state: list[float]) -> list[float]:
    """Return a spare's state as C has it: what is of X, Y, Z first, then sensor by sensor."""
    head, rows, axes = state[:3], state[3:-6], state[-6:]
    sensors = len(rows) // 7
    return [*head, *axes, *(value for at in range(sensors) for value in rows[at::sensors])]


def same(found: str, expected: list[float], unused: Collection[int] = ()) -> bool:
    numbers = [float.fromhex(value) for value in found.split()]
    if numbers == expected:  # as nearly always, and soon seen
        return True
    return len(numbers) == len(expected) and all(
        place in unused or (isnan(a) and isnan(b)) or isclose(a, b, rel_tol=TIGHT, abs_tol=TIGHT)
        for place, (a, b) in enumerate(zip(numbers, expected, strict=True))
    )


def check(model: Model, parts: list[str], output: Output, row: Row) -> None:
    status, outputs, single, *rest, text = parts
    assert int(status) == 0
    assert same(outputs, [float(value) for value in output[:-1]])
    assert text == output.status_text
    # A fault that is over keeps its sensor in C, and a measurement that is used keeps its value.
    assert same(single, row[0], {4} if row[0][3] == 0 else ())
    gone = range(0 if row[0][-1] else len(model.targets))
    for place, (found, expected) in enumerate(zip(rest, row[1:], strict=True)):
        assert same(found, expected, gone if place == 4 else ()), (place, found, expected)


CASES = [
    pytest.param(kind, seed, marks=[pytest.mark.long] * (seed > 0))
    for kind in KINDS
    for seed in SEEDS
]
"""One file of a kind is enough for a change."""
WHOLE = ("gaussian", 16)
MANY = [WHOLE, ("gaussian", 13), ("mlr", 14)]
MANY += [
    pytest.param("gaussian", seed, marks=pytest.mark.long) for seed in (7, 8, 10, 14, 18, 20, 22)
]
"""Files of six sensors, those with an even number have a spare: they start without some of them."""


@pytest.mark.parametrize(("kind", "seed"), CASES + MANY)
def test_every_number_is_that_of_the_runtime(kind, seed, driver_of):
    model = made_model(kind, seed)
    compensator, samples = RunningCompensator(model), Samples(model, seed)
    if seed in SIX:
        samples.silence(120, 1 + seed % 3)
    lines: list[str] = []
    expected: list[tuple[Output, Row]] = []
    steps = STEPS if kind == "gaussian" else STEPS // 2  # others add a mean function to it
    for k in range(steps):
        sample = samples.next()
        lines += line_of(model, sample)
        output = compensator.step(*sample)
        expected.append((output, remembered(compensator)))
        if k % 100 == 99:  # a host takes the state to another instance
            lines.append("s")
            expected.append(expected[-1])
            state, compensator = compensator.state(), RunningCompensator(model)
            compensator.restore(json.loads(json.dumps(state)))
        if k == 2 * steps // 3:
            compensator.reset()
            lines.append("r")
            expected.append((compensator.step(nan, nan, [nan] * len(model.sensors)), ([], [])))
            compensator.reset()
            samples.silence(120, 1 + seed % 3)
    found = driver_of(model).run(lines)
    assert len(found) == len(expected)
    for parts, (output, row) in zip(found, expected, strict=True):
        if row[0]:
            check(model, parts, output, row)
    seen = {output.status for output, _ in expected}
    assert len(seen) >= 3, seen
    assert inf not in {abs(value) for output, _ in expected for value in output[:9]}


def test_what_is_compared_above_is_reached():
    """Starts without sensors, broken ones, and as many measurements as are kept."""
    kind, seed = WHOLE
    model = made_model(kind, seed)
    compensator, samples = RunningCompensator(model), Samples(model, seed)
    samples.silence(120, 1 + seed % 3)
    seen, probes = set[int](), 0
    for _ in range(STEPS // 3):
        seen.add(compensator.step(*samples.next()).status)
        probes = max(probes, int(compensator.state()["gaussian"][7]))
    assert {OK, UNTRAINED, SPARED} <= seen
    assert any(status > HOLDING for status in seen)
    assert probes == MOST_PROBES
