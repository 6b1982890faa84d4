"""From runs to a named effect, a machine file and the gap on a run that was never used."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gap_finder.calibrate import calibrate
from gap_finder.candidates import Candidate, as_tried, grid, missing_effects, with_effect
from gap_finder.design import all_sensitivities
from gap_finder.find import _need_excitation, find_gap
from gap_finder.observations import observe
from gap_finder.refit import score_fit
from gap_finder.search import Search
from gap_finder.selection import select_effect
from measurement.errors import BadInput
from measurement.runs import write_run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from scenarios.cli import main
from tests.gap_finder.conftest import runs_of
from tests.plant_model.conftest import with_effects

# A few rivals suffice to show the way; the whole catalogue is for the benchmark.
RIVALS = ("friction_speed_exponent", "centrifugal_shift", "windage")
LEFT_OUT = [name for name in catalogue() if name not in RIVALS]


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "number", "size"),
    # The second depends on temperature and has two drivers, which takes a minute.
    [("friction_speed_exponent", "deviation", 0.4), ("thermal_preload", "gain", 0.3)],
)
def test_a_hidden_effect_is_named_added_and_closes_the_gap(
    name: str,
    number: str,
    size: float,
    jig_borer_lumps: Machine,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    truth = with_effect(jig_borer_lumps, name, {number: size})
    paths = [str(write_run(run, tmp_path / f"{run.name}.csv")) for run in runs_of(truth)]
    out = tmp_path / "out"
    arguments = ["find-gap", "jig_borer_lumps", "--runs", *paths[:3], "--holdout", paths[3]]
    left_out = [other for other in LEFT_OUT if other != name]
    assert main([*arguments, "--out", str(out), "--without", *left_out, "--quiet"]) == 0
    table = json.loads((out / "gap.json").read_text())
    assert table["verdict"] == "effect"
    (effect,) = table["effects"]
    assert effect["name"] == name
    found = effect["parameters"][number]
    # Other numbers have soft ranges and give way to it, and of two drivers that do the same in
    # these runs it may be given the other.
    assert found["value"] == pytest.approx(size, rel=0.3)
    gap = table["gap"]["holdout"]
    assert gap["after"] < 0.2 * gap["before"]
    after = read_machine(out / "machine_after.toml")
    (key,) = (key for key in after.effects if key.partition(":")[0] == name)
    assert after.effects[key][number].value == found["value"]
    assert (out / "report.html").stat().st_size > 1e6
    assert len(list(out.glob("residual_*.png"))) == 2
    assert len(list(out.glob(f"signature_{name}_*.png"))) == 1
    assert len(capsys.readouterr().out.strip().splitlines()) == 6


def test_nothing_is_named_when_nothing_is_missing(jig_borer_lumps: Machine) -> None:
    runs = runs_of(jig_borer_lumps, seed=7)
    first, second = (
        find_gap(jig_borer_lumps, order, Search(LEFT_OUT)) for order in (runs[:3], runs[2::-1])
    )
    assert first.verdict == "none_missing"
    assert first.after is first.before
    # The order in which runs are given changes nothing.
    assert first.before.cost == second.before.cost


def test_too_few_runs_and_a_machine_at_rest_are_refused(jig_borer_lumps: Machine) -> None:
    runs = runs_of(jig_borer_lumps)
    with pytest.raises(BadInput, match="3 or more are needed"):
        find_gap(jig_borer_lumps, runs[:2])
    for run in runs:
        run.frame["speed_rpm"] = 0.0
    with pytest.raises(BadInput, match="stands still"):
        find_gap(jig_borer_lumps, runs)


def test_an_input_with_a_default_moves_a_machine_too(jig_borer_lumps: Machine) -> None:
    inputs = tuple(
        replace(entry, default=0.0) if entry.name == "speed" else entry
        for entry in jig_borer_lumps.inputs
    )
    machine, runs = replace(jig_borer_lumps, inputs=inputs), runs_of(jig_borer_lumps)
    _need_excitation(machine, runs)
    for run in runs:
        run.frame["speed_rpm"] = 0.0
    with pytest.raises(BadInput, match="stands still"):
        _need_excitation(machine, runs)


def test_candidates_cover_both_signs_and_stay_in_range(jig_borer_lumps: Machine) -> None:
    for effect in missing_effects(jig_borer_lumps):
        sizes = {entry[effect.amplitude] for entry in grid(effect)}
        amplitude = effect.parameters[effect.amplitude]
        assert effect.off not in sizes
        assert (min(sizes) < effect.off) == (amplitude.low < effect.off)
        for entry in grid(effect):
            for name, value in entry.items():
                parameter = effect.parameters[name]
                assert parameter.low <= value <= parameter.high


class _Scored:
    """What selection needs to know of a fit."""

    def __init__(
        self,
        name: str,
        unseen: list[float],
        acts: tuple[bool, ...] = (),
        at_bounds: tuple[str, ...] = (),
        beyond_usual: tuple[str, ...] = (),
        *,
        is_ordinary: bool = False,
        cost: float | None = None,
    ) -> None:
        self.added, self.loro_cost, self.acts = (name,), np.array(unseen), acts
        self.pieces, self.cost = 14 * len(unseen), sum(unseen) if cost is None else cost
        self.calibration = SimpleNamespace(cost=self.cost)
        self.at_bounds, self.beyond_usual, self.is_ordinary = at_bounds, beyond_usual, is_ordinary


@pytest.mark.parametrize(
    ("costs", "chance", "named"),
    [
        ({"a": [20.0, 20.0, 20.0], "b": [45.0, 45.0, 45.0]}, 0.1, ("a",)),
        ({"a": [20.0, 20.0, 20.0], "b": [20.5, 20.5, 20.5]}, 0.1, ("a", "b")),
        ({"a": [48.0, 48.0, 48.0]}, 0.1, ()),
        ({"a": [20.0, 20.0, 20.0]}, 0.7, ()),
        # Better over all, but only because of one run.
        ({"a": [1.0, 52.0, 52.0]}, 0.1, ()),
    ],
)
def test_judging(costs: dict[str, list[float]], chance: float, named: tuple[str, ...]) -> None:
    now = _Scored("", [50.0, 50.0, 50.0])
    tried = [_Scored(name, cost) for name, cost in costs.items()]
    selection = select_effect(now, tried, chance, channels=14)  # type: ignore[arg-type]
    assert selection.one_of == named
    assert sum(selection.probability) == pytest.approx(1.0)


def test_what_helps_to_predict_must_also_explain() -> None:
    now = _Scored("", [50.0, 50.0, 50.0], cost=60.0)
    for cost, named in ((45.0, ("a",)), (52.0, ()), (65.0, ())):
        found = _Scored("a", [20.0, 20.0, 20.0], cost=cost)
        assert select_effect(now, [found], 0.1, channels=14).one_of == named  # type: ignore[list-item, arg-type]
    # What a run's own unknowns can do as well shows before they are calibrated.
    found = _Scored("a", [20.0, 20.0, 20.0], cost=55.0)
    found.calibration = SimpleNamespace(cost=45.0)
    assert select_effect(now, [found], 0.1, channels=14).one_of == ("a",)  # type: ignore[list-item, arg-type]
    # Where much is left, it must explain as much more.
    much, some = (_Scored("", [900.0] * 3, cost=left) for left in (840.0, 600.0))
    assert select_effect(much, [_Scored("a", [300.0] * 3, cost=420.0)], 0.1, channels=14).named  # type: ignore[list-item, arg-type]
    assert not select_effect(some, [_Scored("a", [300.0] * 3, cost=510.0)], 0.1, channels=14).named  # type: ignore[list-item, arg-type]


def test_only_runs_in_which_an_effect_acts_speak_of_it() -> None:
    now = _Scored("", [50.0, 50.0, 50.0])
    everywhere, last = (
        _Scored("a", [50.5, 50.5, 1.0], acts) for acts in ((True,) * 3, (False, False, True))
    )
    assert select_effect(now, [everywhere], 0.1, channels=14).one_of == ()  # type: ignore[arg-type]
    assert select_effect(now, [last], 0.1, channels=14).one_of == ("a",)  # type: ignore[arg-type]


def test_a_further_effect_explains_much_of_what_was_or_of_what_is_left() -> None:
    now = _Scored("first", [50.0, 50.0, 50.0])
    some, most = (_Scored("b", [cost] * 3) for cost in (30.0, 20.0))
    for at_first, found, named in (
        (150.0, some, True),
        (3000.0, some, False),
        (3000.0, most, True),
    ):
        selection = select_effect(now, [found], 0.1, channels=14, at_first=at_first)  # type: ignore[list-item, arg-type]
        assert selection.named == named


def test_effects_of_temperature_are_calibrated_from_larger_sizes_too() -> None:
    sizes = (-0.5, -0.2, -0.06, 0.06, 0.2)
    tried = [Candidate("joint_resistance", {"gain": gain}, ()) for gain in sizes]
    assert as_tried(tried, tried[2]) == [tried[2], tried[1]]
    assert as_tried(tried, tried[3]) == [tried[3], tried[4]]
    assert as_tried(tried, tried[0]) == [tried[0]]
    shifts = [Candidate("centrifugal_shift", {"shift": shift}, ()) for shift in (1.0, 2.0)]
    assert as_tried(shifts, shifts[0]) == [], "near enough to linear"


def test_an_error_that_may_be_on_any_sensor_is_no_sensor_s() -> None:
    now = _Scored("", [50.0, 50.0, 50.0])
    tried = [_Scored(f"sensor_offset:T{i}", [20.0 + 0.1 * i] * 3) for i in (1, 2, 3)]
    assert select_effect(now, tried, 0.1, channels=14).one_of == ()  # type: ignore[arg-type]
    assert len(select_effect(now, tried[:2], 0.1, channels=14).one_of) == 2  # type: ignore[arg-type]


def test_an_effect_at_the_end_of_its_range_is_not_named() -> None:
    now = _Scored("", [50.0, 50.0, 50.0])
    ended = _Scored("a", [20.0, 20.0, 20.0], at_bounds=("power",))
    close, far = (_Scored("b", [cost] * 3) for cost in (20.5, 40.0))
    assert select_effect(now, [ended], 0.1, channels=14).one_of == ()  # type: ignore[list-item, arg-type]
    # Another that does nearly as well may be it; one that does far worse is not.
    selection = select_effect(now, [ended, close], 0.1, channels=14)  # type: ignore[list-item, arg-type]
    assert selection.one_of == ("b",)
    assert selection.best is close  # type: ignore[comparison-overlap]
    assert select_effect(now, [ended, far], 0.1, channels=14).one_of == ()  # type: ignore[list-item, arg-type]


def test_a_written_machine_reads_back_and_keeps_its_comments(
    jig_borer_lumps: Machine, tmp_path: Path
) -> None:
    moved = with_effects(jig_borer_lumps, "radiation", "sensor_offset").with_values(
        {"sources.motor.loss": 25.5, "effects.sensor_offset:T1.error": -3.0}
    )
    path = write_machine(moved, "jig_borer_lumps", tmp_path / "after.toml")
    assert read_machine(path) == moved
    assert "# Jackets: one each" in path.read_text()
    with pytest.raises(BadInput, match="not the file"):
        write_machine(jig_borer_lumps, path, tmp_path / "other.toml")


def test_of_two_larger_than_usual_the_one_that_fits_far_better_is_not_excluded() -> None:
    now = _Scored("", [500.0, 500.0, 500.0])
    best = _Scored("windage", [20.0] * 3, beyond_usual=("power",))
    best.calibration = SimpleNamespace(cost=500.0)
    other = _Scored("motor_iron_loss", [60.0] * 3, beyond_usual=("power",))
    for cost, kept in ((200.0, ("windage", "motor_iron_loss")), (400.0, ("windage",))):
        other.calibration = SimpleNamespace(cost=cost)
        assert select_effect(now, [best, other], 0.1, channels=14).one_of == kept  # type: ignore[list-item, arg-type]


def test_an_effect_larger_than_usual_must_explain_most() -> None:
    now = _Scored("", [50.0, 50.0, 50.0])
    for cost, named in ((15.0, ("a",)), (25.0, ())):
        found = _Scored("a", [cost] * 3, beyond_usual=("gain",))
        assert select_effect(now, [found], 0.1, channels=14).one_of == named  # type: ignore[list-item, arg-type]
    # Half of it is enough for one that stays within what is usual.
    assert select_effect(now, [_Scored("a", [25.0] * 3)], 0.1, channels=14).named  # type: ignore[list-item, arg-type]


def test_what_any_machine_has_is_not_named() -> None:
    now = _Scored("", [50.0, 50.0, 50.0])
    found = _Scored("a", [15.0] * 3, is_ordinary=True)
    assert select_effect(now, [found], 0.1, channels=14).one_of == ()  # type: ignore[list-item, arg-type]


def test_a_lag_of_less_than_a_minute_is_ordinary(jig_borer_lumps: Machine) -> None:
    observed = observe(jig_borer_lumps, runs_of(jig_borer_lumps, every_s=300.0)[:2])
    for minutes, ordinary in ((0.8, True), (2.0, False)):
        machine = with_effect(jig_borer_lumps, "sensor_lag:T1", {"minutes": minutes})
        known = all_sensitivities(machine, machine, observed)
        calibration = calibrate(
            machine, observed, starts=1, iterations=0, start_from=[machine], sensitivities=known
        )
        kept = replace(calibration, machine=machine)
        fit = score_fit(machine, ("sensor_lag:T1",), observed, kept, known)
        assert fit.is_ordinary is ordinary


@pytest.mark.long
def test_a_loss_far_beyond_its_usual_range_is_named_and_said_to_be_large(
    jig_borer_lumps: Machine, tmp_path: Path
) -> None:
    truth = with_effect(jig_borer_lumps, "windage", {"power": 1500.0})
    runs = runs_of(truth)
    found = find_gap(jig_borer_lumps, runs[:3], Search(LEFT_OUT))
    assert found.rounds[0].one_of == ("windage",)
    assert found.after.beyond_usual == ("power",)
    power = found.after.machine.parameters["effects.windage.power"]
    assert power.value == pytest.approx(1500.0, rel=0.15)
    # Beyond the catalogue's range, and read back all the same.
    path = write_machine(found.after.machine, "jig_borer_lumps", tmp_path / "after.toml")
    assert read_machine(path).effects["windage"]["power"] == power


def test_a_law_at_an_end_of_its_range_is_forgiven_where_it_explains_nearly_all() -> None:
    now = _Scored("", [500.0, 500.0, 500.0])
    for cost, beyond, named in (
        (30.0, ("eddy_share",), True),
        (100.0, ("eddy_share",), False),
        # An amplitude at an end of what is possible is another matter.
        (30.0, ("power",), False),
    ):
        found = _Scored("motor_iron_loss", [cost] * 3, at_bounds=beyond)
        assert select_effect(now, [found], 0.1, channels=14).named == named  # type: ignore[list-item, arg-type]
