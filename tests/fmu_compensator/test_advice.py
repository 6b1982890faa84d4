"""Which run `replay` advises to learn from."""

from functools import cache

import pytest

from fmu_compensator.fit.advice import advice
from fmu_compensator.fit.fitting import compensator_text
from fmu_compensator.fit.run_conditions import Condition
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.runs import Run
from tests.fmu_compensator.conftest import DIRECT_RIG
from tests.fmu_compensator.gaussians import apart
from tests.fmu_compensator.test_installed import RUNS, direct, fitted


@cache
def model() -> Model:
    """Return a compensator that has learnt little: one weight tells nothing about another."""
    table = fitted("gaussian")
    little = {"scale": [0.01] * 4, "seen": [], "walk_per_h": 0.25, "noise": apart([1.0, 1.0])}
    table = table | {"gaussian": table["gaussian"] | little}
    return parse_model(compensator_text(table), "made")


def moved(name: str, seed: int, **factors: float) -> Run:
    """Return a run with the rises of some thermometers multiplied."""
    frame = direct(name, seed).frame
    for sensor, factor in factors.items():
        column = frame[f"{sensor}_degC"]
        further = column.iloc[0] + factor * (column - column.iloc[0])
        frame = frame.assign(**{f"{sensor}_degC": further})
    return Run(name, frame)


ALIKE = [moved(f"alike_{seed}", seed, T1=2.0, T4=0.02) for seed in (11, 12, 13)]
ALONE = moved("alone", 14, T1=0.02, T4=-30.0)


def named(runs: list[Run]) -> str | None:
    lines = advice(model(), runs, runs, DIRECT_RIG, 100.0)
    found = [line for line in lines if line.startswith("Best run to learn from next: ")]
    return found[0].split()[6] if found else None


def test_the_best_run_teaches_most_about_the_others_however_uncertain_it_is_itself():
    assert "alike" in (named([*ALIKE, ALONE]) or "")


@pytest.mark.parametrize("new", [[], ALIKE[:1]])
def test_a_run_that_the_compensator_has_learnt_from_is_not_named(new):
    assert named([*RUNS, *new]) == (new[0].name if new else None)


def test_a_run_with_a_thermometer_that_stands_still_is_not_named():
    assert named([*ALIKE[1:], moved("broken", 11, T1=2.0, T4=0.0)]) in ("alike_12", "alike_13")


@pytest.mark.parametrize(("speed", "new"), [(850.6, False), (849.0, True), (2003.0, False)])
def test_a_condition_is_new_if_its_shown_digits_are(speed: float, new: bool):
    condition = Condition("mean speed", "rpm", speed, 851.2, 1996.0)
    assert condition.is_new == new
    shown = {850.6: "851", 849.0: "849", 2003.0: "2000"}[speed]
    assert condition.text == f"mean speed {shown} rpm (training 851 to 2000)"


def test_a_run_of_one_row_says_nothing_of_probes():
    short = Run("short", RUNS[0].frame[:1])
    lines = advice(model(), [short], [short], DIRECT_RIG, 100.0)
    assert not [line for line in lines if "probe" in line]


@pytest.mark.parametrize(
    ("unit", "value", "new"),
    [("h", 3.0, False), ("h", 7.0, True), ("rpm", 900.0, True), ("rpm", 1500.0, False)],
)
def test_a_shorter_run_is_no_new_condition(unit, value, new):
    low, high = (4.0, 6.0) if unit == "h" else (1000.0, 2000.0)
    assert Condition("what", unit, value, low, high).is_new == new
