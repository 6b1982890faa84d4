"""What is scored in full, and where its calibration begins."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from gap_finder import forward_backward, proposals
from gap_finder.calibrate import calibrate
from gap_finder.candidates import Candidate
from gap_finder.design import all_sensitivities
from gap_finder.forward_backward import Hypothesis, _in_place_of, added_to
from gap_finder.hypotheses import AddedChange, Listed, all_additions, prior_costs
from gap_finder.kinds.heat_path import HeatPath
from gap_finder.kinds.sensor_place import SensorPlace
from gap_finder.observations import observe
from gap_finder.proposals import Proposal, screened
from gap_finder.score import scored
from measurement.workers import workers
from plant_model.effects import catalogue
from plant_model.machine import Machine
from tests.gap_finder.conftest import candidates_of, runs_of

SLIPS = "bearing_stick_slip"
LAWS = ("friction_speed_exponent", "windage", "motor_iron_loss", "joint_resistance", SLIPS)


def test_the_likeliest_is_scored_even_if_none_lowers_the_score_in_the_screening(jig_borer_lumps):
    observed = observe(jig_borer_lumps, runs_of(jig_borer_lumps))
    calibration = calibrate(jig_borer_lumps, observed, starts=1, cost_limit=0.0)
    sensitivities = all_sensitivities(calibration.machine, observed)
    now = scored(jig_borer_lumps, observed, calibration, sensitivities)
    tried: list[Candidate | AddedChange] = [
        one for name in LAWS for one in candidates_of(now.machine, observed, name)
    ]
    # So unlikely that nothing gained pays for it.
    costs = {key: 1e4 + cost for key, cost in prior_costs({one.key for one in tried}, {}).items()}
    assert len(screened(now, now, sensitivities, Listed(tried, costs))[0]) == 1
    some, _ = screened(now, now, sensitivities, Listed(tried, dict.fromkeys(costs, -1e4)))
    assert {one.key for one in some} == {one.key for one in tried}
    # The response of a law that slips leaps with its size, which calibration cannot find.
    sizes = {one.addition.values["hold"] for one in some if one.key == SLIPS}
    assert (len(some), len(sizes)) == (len(LAWS) + 5, 6)


def test_a_channel_that_nothing_follows_is_asked_first(jig_borer_lumps):
    runs = runs_of(jig_borer_lumps)
    sensors = [
        replace(sensor, of="pedestal") if sensor.name == "T8" else sensor
        for sensor in jig_borer_lumps.sensors
    ]
    mistaken = replace(jig_borer_lumps, sensors=tuple(sensors))
    observed = observe(mistaken, runs)
    calibration = calibrate(mistaken, observed, starts=1, cost_limit=0.0)
    sensitivities = all_sensitivities(calibration.machine, observed)
    now = scored(mistaken, observed, calibration, sensitivities)
    with workers(1) as pool:
        listed = all_additions(pool, now, sensitivities, catalogue())
    likely, _ = screened(now, now, sensitivities, listed)
    # They are warmed alike; scored in full, they are in one set.
    assert likely[0].key in ("sensor_place:T8+housing_motor_yp", "sensor_place:T8+stator")


@pytest.mark.parametrize(("law", "starts"), [("windage", [1.1]), ("joint_resistance", [1.1, 1.0])])
def test_what_is_far_from_linear_also_starts_from_the_file(
    jig_borer_lumps, monkeypatch, law, starts
):
    (moved, *_) = [name for name, one in jig_borer_lumps.parameters.items() if one.calibrate]
    usual = jig_borer_lumps.parameters[moved].value
    calibrated = jig_borer_lumps.with_values({moved: 1.1 * usual})
    fit: Any = SimpleNamespace(
        machine=calibrated,
        base=jig_borer_lumps,
        observed=(),
        calibration=SimpleNamespace(cost=0.0, starts_cost=0.0),
    )
    values = {name: one.value for name, one in catalogue()[law].parameters.items()}
    begun: list[Machine] = []
    monkeypatch.setattr(forward_backward, "fit", lambda *args: begun.extend(args[2]))
    addition = Candidate(law, values, ())
    added_to(Hypothesis((), (), fit), Proposal(addition, calibrated, 0.0), [])
    assert [one.parameters[moved].value / usual for one in begun] == pytest.approx(starts)


def test_another_place_begins_where_the_one_that_does_best_has_ended(jig_borer_lumps):
    (moved, *_) = [name for name, one in jig_borer_lumps.parameters.items() if one.calibrate]
    usual = jig_borer_lumps.parameters[moved].value
    known: Any = SimpleNamespace(machine=jig_borer_lumps)
    here, there, *_ = (
        AddedChange(one, {"conductance": 3.0}, ()) for one in HeatPath.all_of([known])
    )
    ended = here.put_into(jig_borer_lumps).with_values({moved: 1.1 * usual})

    def found(machine: Machine, *added: AddedChange) -> Hypothesis:
        fit: Any = SimpleNamespace(machine=machine)
        return Hypothesis(added, (0.0,) * len(added), fit)

    begun = _in_place_of(found(ended, here), found(jig_borer_lumps), there)
    assert begun.parameters[moved].value == pytest.approx(1.1 * usual)
    there_is = {item.name for item in begun.items} - {item.name for item in jig_borer_lumps.items}
    assert there_is == {"-".join(there.change.place)}


def test_the_cells_of_one_body_leave_room_for_other_places():
    cells = [f"housing_{number}" for number in range(9)]
    parts = [*cells, "head", "column"]
    listed = [AddedChange(HeatPath((part, "guides"), False), {}, ()) for part in parts]
    chosen = proposals.places_of(listed, range(len(listed)), dict.fromkeys(cells, "housing"))
    assert [listed[i].change.place[0] for i in chosen] == [*cells[:3], "head", "column"]


def test_a_misplaced_thermometer_is_scored_on_every_body():
    """The likeliest one only: what calibration has hidden says little about where it is."""
    cells = [f"housing_{number}" for number in range(9)]
    parts = [*cells, *(f"part_{number}" for number in range(9))]
    places = [("T1", parts[0]), *(("T2", part) for part in parts), *(("T1", p) for p in parts[1:])]
    listed = [AddedChange(SensorPlace(place, "head", False), {}, ()) for place in places]
    chosen = proposals.places_of(listed, range(len(listed)), dict.fromkeys(cells, "housing"))
    read = [listed[i].change.place for i in chosen]
    assert read == [("T1", part) for part in (*cells[:3], *parts[9:])]
