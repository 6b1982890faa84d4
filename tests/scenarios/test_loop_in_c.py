"""The loop in C beside the loop in Python: the same bits, the same events, the same words."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from scenarios import cosimulation
from scenarios.cosimulation import simulate
from scenarios.fmu import FmuError
from scenarios.loop_in_c import library
from scenarios.recording import Recording
from scenarios.scenario import read_scenario
from tests.scenarios.tiny_fmus import COMPENSATOR, build_tiny

FAULTS = "".join(
    f'\n[[faults]]\nsensor = "T1"\nkind = "{kind}"\n{rest}'
    for kind, rest in (
        ("frozen", "start_s = 2\nend_s = 5\n"),
        ("drift", "value = 100.0\nstart_s = 4\nend_s = 12\n"),
        ("spike", "value = 3.0\nstart_s = 1\nevery_s = 3.0\n"),
        ("missing", "start_s = 8\nend_s = 10\n"),
        ("stuck-at", "value = 25.0\nstart_s = 15\nend_s = 18\n"),
        ("frozen", "start_s = 19\n"),
    )
)
"""The last one acts at the last points, where nothing is stepped any more."""


@pytest.fixture(autouse=True)
def needs_a_compiler() -> None:
    if library() is None:
        pytest.skip("there is no C compiler")


@contextmanager
def in_python() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cosimulation, "library", lambda: None)
        yield


def both(*given: Any) -> tuple[Recording, Recording]:
    in_c = simulate(*given, quiet=True)
    with in_python():
        return in_c, simulate(*given, quiet=True)


@pytest.mark.parametrize("compensated", [True, False])
@pytest.mark.parametrize("step_s", [1.0, 0.05])
def test_both_loops_give_the_same_bits(
    tiny_scenario: Path, tiny_plant: Path, tiny_compensator: Path, compensated: bool, step_s: float
) -> None:
    if compensated:
        tiny_scenario.write_text(tiny_scenario.read_text() + FAULTS)
    (case,) = read_scenario(tiny_scenario, [("step_s", step_s)]).cases
    one, other = both(case, tiny_plant, tiny_compensator if compensated else None)
    pd.testing.assert_frame_equal(one.frame, other.frame, check_exact=True)
    assert one.events == other.events
    assert len(one.events) == (3 if compensated else 0)
    if compensated:
        changed = one.frame["T1_seen_degC"] != one.frame["T1_degC"]
        assert 0.3 < changed.mean() < 0.95


def test_a_step_that_fails_is_told_alike(
    tiny_scenario: Path, tiny_plant: Path, tiny_compensator: Path
) -> None:
    (case,) = read_scenario(tiny_scenario, [("signals.speed", 9500.0)]).cases
    with pytest.raises(FmuError) as in_c:
        simulate(case, tiny_plant, tiny_compensator, quiet=True)
    with in_python(), pytest.raises(FmuError) as expected:
        simulate(case, tiny_plant, tiny_compensator, quiet=True)
    assert str(in_c.value) == str(expected.value)
    assert "plant FMU at 0 s: the step failed" in str(in_c.value)


def test_a_late_failure_names_its_time(
    tiny_scenario: Path, tiny_plant: Path, tmp_path: Path
) -> None:
    first = "        missing = self.T1"
    late = "        if current_time >= 7.0:\n            return False\n"
    source = COMPENSATOR.replace(first, late + first)
    assert source != COMPENSATOR
    broken = build_tiny(source, "LateCompensator", tmp_path)
    (case,) = read_scenario(tiny_scenario, []).cases
    with pytest.raises(FmuError, match="compensator FMU at 7 s: the step failed"):
        simulate(case, tiny_plant, broken, quiet=True)
