"""The C program gives the numbers of the Python runtime, for every error model, whatever comes in.

It runs under the address and undefined-behaviour sanitizers. All that either remembers is compared,
not only the outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from math import inf, isclose, isnan, nan
from typing import Any

import pytest

from fmu_compensator.native.generate import kinds
from fmu_compensator.runtime.compensator import HOLDING, OK, SPARED, Output, RunningCompensator
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.modelfile import Model
from tests.native.conftest import Driver
from tests.native.made import MADE, PARTS, Samples, made_model

KINDS = sorted(error_models())
STEPS = 900
TIGHT = 1e-12  # relative; absolute in um and urad for what lies near zero
Row = tuple[list[float], ...]
CHECKED = 1 + 6  # numbers of a sensor: its reference, and what its check remembers


def test_every_error_model_has_a_c_twin_and_is_tested() -> None:
    assert kinds() == KINDS
    assert sorted(MADE) == KINDS


def written(values: list[float]) -> str:
    return " ".join(str(value) if isnan(value) else value.hex() for value in values)


def line_of(model: Model, sample: Any) -> list[str]:
    """Return the driver's lines of one sample."""
    time, step, temperatures, speed, tool, measured = sample
    values = [*temperatures, speed, tool]
    if model.takes_measured:
        values += [*(measured or [0.0] * len(model.targets)), float(measured is not None)]
    return [f"i {written(values)}", f"d {written([time, step])}"]


def remembered(compensator: RunningCompensator) -> Row:
    """Return a state as the driver shows one."""
    state = compensator.state()
    cause, sensor = state["fault"][:2] if state["fault"] else (0, 0)
    spared, spared_sensor = state["spared"][:2] if state["spared"] else (0, 0)
    measured, predicted = (
        state[name] or [nan] * len(compensator.model.targets) for name in ("measured", "predicted")
    )
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
        state["since_start"],
        state["growth"],
        state["novelty"],
        state["predicted"] is not None,
        state["measured"] is not None,
    ]
    checks = [value for check in state["checks"] for value in check]
    numbers = [*state["reference"], *checks, *measured, *predicted]
    numbers += [*state["guard"], *state["correction"]]
    numbers += [*state["spare"], *state["error_model"]]
    parts = (single, *(state[name] for name in ("wanted", "offset", "pose", "half_width")), numbers)
    return tuple([nan if value is None else float(value) for value in part] for part in parts)


def same(found: str, expected: list[float], unused: Collection[int] = ()) -> bool:
    numbers = [float.fromhex(value) for value in found.split()]
    return len(numbers) == len(expected) and all(
        place in unused or (isnan(a) and isnan(b)) or isclose(a, b, rel_tol=TIGHT, abs_tol=TIGHT)
        for place, (a, b) in enumerate(zip(numbers, expected, strict=True))
    )


def check(model: Model, parts: list[str], output: Output, row: Row) -> None:
    status, outputs, single, *rest, text = parts
    after_checks, targets = len(model.chosen) * CHECKED, len(model.targets)
    assert int(status) == 0
    assert same(outputs, [float(value) for value in output[:-1]])
    assert text == output.status_text
    # A fault that is over keeps its sensor in C, and a measurement that is used keeps its value.
    assert same(single, row[0], {4} if row[0][3] == 0 else ())
    predicted, measured = row[0][-2:]
    gone = {after_checks + k for k in range(targets) if not measured}
    gone |= {after_checks + targets + k for k in range(targets) if not predicted}
    for place, (found, expected) in enumerate(zip(rest, row[1:], strict=True)):
        assert same(found, expected, gone if place == 4 else ()), (place, found, expected)


CASES = [(kind, seed) for kind in KINDS for seed in range(len(PARTS))]
STARTS = [("mlr", 6), ("mlr", 12), ("thermal_states", 6)]
"""Files of rises with a guard and a spare, which start without a sensor."""


@pytest.mark.parametrize(("kind", "seed"), CASES + STARTS)
def test_every_number_is_that_of_the_runtime(
    kind: str, seed: int, driver_of: Callable[[Model], Driver]
) -> None:
    model = made_model(kind, seed)
    compensator, samples = RunningCompensator(model), Samples(model, seed)
    lines: list[str] = []
    expected: list[tuple[Output, Row]] = []
    for k in range(STEPS):
        sample = samples.next()
        lines += line_of(model, sample)
        output = compensator.step(*sample)
        expected.append((output, remembered(compensator)))
        if k % 100 == 99:  # a host takes the state to another instance
            lines.append("s")
            expected.append(expected[-1])
        if k == 2 * STEPS // 3:
            compensator.reset()
            lines.append("r")
            expected.append((compensator.step(nan, nan, [nan] * len(model.sensors)), ((), ())))
            compensator.reset()
            samples.silence(120)
    found = driver_of(model).run(lines)
    assert len(found) == len(expected)
    for parts, (output, row) in zip(found, expected, strict=True):
        if row[0]:
            check(model, parts, output, row)
    seen = {output.status for output, _ in expected}
    assert len(seen) >= 3, seen
    assert inf not in {abs(value) for output, _ in expected for value in output[:9]}


def test_some_made_files_start_without_a_sensor_that_reads_later() -> None:
    """What is compared above is reached."""
    shifted = 0
    for kind, seed in STARTS:
        model = made_model(kind, seed)
        compensator, samples = RunningCompensator(model), Samples(model, seed)
        samples.silence(120)
        for _ in range(300):
            compensator.step(*samples.next())
        count = len(model.chosen)
        shifts = compensator.state()["spare"][4 + 7 * count : 4 + 8 * count]
        shifted += any(shifts)
    assert shifted == len(STARTS)


def test_the_made_files_go_on_without_one_sensor_and_without_two() -> None:
    """What is compared above is reached, and left again."""
    broken: set[int] = set()
    seen: set[int] = set()
    for seed in (seed for seed, parts in enumerate(PARTS) if parts and "spare" in parts):
        model = made_model("mlr", seed)
        compensator, samples = RunningCompensator(model), Samples(model, seed)
        for _ in range(STEPS):
            output = compensator.step(*samples.next())
            seen.add(output.status)
            if output.status == SPARED:
                broken.add(2 if "and without" in output.status_text else 1)
    assert broken == {1, 2}
    assert {OK, SPARED} <= seen
    assert any(status > HOLDING for status in seen)
