"""Mistakes of the shipped lathe's description, one kind after another, found with their place."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from threadpoolctl import threadpool_limits

from benchmarks.gap.mistakes import Mistake, mistakes, runs_of
from gap_finder.calibrate import calibrate, quiet
from gap_finder.description import NamedChange
from gap_finder.description_rounds import left_out, select_changes
from gap_finder.design import all_sensitivities
from gap_finder.kinds import kinds
from gap_finder.kinds.heat_source import HeatSource
from gap_finder.observations import observe
from gap_finder.refit import CandidateFit, score_fit
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine

LATHE = read_machine("lathe")
PLANTED = {
    ("conductance_with_motion", "z_nut", "air", "feed"),
    ("coarse_part", "carriage"),
}
FOUND = [
    pytest.param(one, id="-".join(key))
    for one in mistakes(LATHE)
    if (key := (one.kind, *one.place)) in PLANTED
]


def named(told: Machine, runs: list[Run], most: int = 1) -> tuple[CandidateFit, list[NamedChange]]:
    """Return the calibrated machine and what is named of its description."""
    observed = observe(told, runs)
    with threadpool_limits(1), ThreadPoolExecutor(1) as pool:
        calibration = calibrate(told, observed, starts=1)
        sensitivities = all_sensitivities(told, calibration.machine, observed)
        before = score_fit(told, (), observed, calibration, sensitivities)
        return before, select_changes(pool, before, sensitivities, 0, most, quiet)


def named_places(found: list[NamedChange]) -> list[list[tuple[str, tuple[str, ...]]]]:
    """Return what each change may be: itself first, then what cannot be told from it."""
    return [
        [(one.change.name, one.change.place)]
        + [(rival["name"], tuple(rival["place"])) for rival in one.rivals]
        for one in found
    ]


@pytest.mark.long
@pytest.mark.parametrize("mistake", FOUND)
def test_a_mistake_is_named_with_its_place(mistake: Mistake) -> None:
    truth, told = mistake.machines(LATHE)
    before, found = named(told, runs_of(truth)[:5])
    (options,) = named_places(found)
    assert options[0] == (mistake.kind, mistake.place)
    assert found[0].after.loro_cost.sum() < 0.9 * before.loro_cost.sum()


@pytest.mark.long
def test_nothing_is_named_where_the_description_is_right() -> None:
    _, found = named(LATHE, runs_of(LATHE)[:5])
    assert found == []


@pytest.mark.long
def test_two_mistakes_are_found_one_after_another(monkeypatch: pytest.MonkeyPatch) -> None:
    # Which kind it is, among all of them, is asked above.
    some = {name: kind for name, kind in kinds().items() if name in ("heat_source", "heat_path")}
    monkeypatch.setattr("gap_finder.describe.kinds", lambda: some)
    places = (("z_nut",), ("tray", "speed"))
    truth = HeatSource(places[0]).put_into(LATHE, {"power": 40.0})
    truth = HeatSource(places[1]).put_into(truth, {"power": 200.0, "exponent": 1.0})
    before, found = named(LATHE, runs_of(truth)[:4], most=2)
    assert {options[0] for options in named_places(found)} == {
        ("heat_source", place) for place in places
    }
    power = found[-1].after.machine.parameters[found[0].change.parameters()["power"]].value
    assert power == pytest.approx(40.0 if found[0].change.place == places[0] else 200.0, rel=0.2)
    kept = left_out(before, found, found[0])
    assert [one.key for one in kept] == [found[1].key]
    left = kept[-1].after.machine.parameters
    assert not set(found[0].change.parameters().values()) & set(left)
    assert set(found[1].change.parameters().values()) <= set(left)
