"""The regime map and the signatures of the gap finder's page."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gap_finder.candidates import Candidate, with_effect
from gap_finder.find import GapResult
from gap_finder.forward_backward import SearchResult
from gap_finder.hypotheses import AddedChange
from gap_finder.kinds.moves_axis import MovesAxis
from gap_finder.observations import Observations, observe
from gap_finder.regimes import residuals
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from scenarios.pages.charts import Chart
from scenarios.pages.gap_map import regime_map
from scenarios.pages.gap_page import _round
from scenarios.pages.gap_signature import signature_charts


@pytest.fixture(scope="module")
def machine() -> Machine:
    """The jig borer."""
    return read_machine("jig_borer_lumps")


@pytest.fixture(scope="module")
def observed(machine: Machine) -> list[Observations]:
    """Two runs of the jig borer with a centrifugal shift."""
    shifted = with_effect(machine, "centrifugal_shift", {"shift": 15.0})
    time = np.arange(0.0, 9001.0, 60.0)
    runs = []
    for name, speed in (("slow", 4000.0), ("fast", 16000.0)):
        inputs = pd.DataFrame(
            {
                "time_s": time,
                "speed_rpm": np.where((time >= 1800.0) & (time < 7200.0), speed, 0.0),
                "T5_degC": 21.0,
                "T9_degC": 21.0,
            }
        )
        runs.append(Run(name, simulate(shifted, inputs, noise_seed=1).run_frame()))
    return observe(machine, runs)


def lines_of(chart: Chart, channel: str) -> tuple[np.ndarray, np.ndarray]:
    """Return what is left without an addition in a channel, and its signature."""
    (panel,) = [one for one in chart.panels if one.y_label.startswith(channel)]
    left, signature = (line.values for line in panel.lines)
    return left, signature


def test_the_map_shows_where_and_in_which_regime(machine, observed):
    found = [residuals(machine, one) for one in observed]
    shown = regime_map(found)
    assert shown.runs == (("slow", 4), ("fast", 4))
    assert shown.kinds[:4] == ("standing", "warming up", "steady", "cooling down")
    cells = dict(shown.rows)["S5"]
    ratios = dict(
        zip(zip(["slow"] * 4 + ["fast"] * 4, shown.kinds, strict=True), cells, strict=True)
    )
    # 15 um at the highest speed: sixteen times as much at four times the speed, none standing.
    assert float(ratios["fast", "steady"].text) > 10.0 * float(ratios["fast", "standing"].text)
    assert float(ratios["fast", "steady"].text) > 5.0 * float(ratios["slow", "steady"].text)
    assert ratios["slow", "standing"].colour == "#ffffff"
    # The further off, the less white.
    assert ratios["fast", "steady"].colour < ratios["slow", "steady"].colour <= "#ffffff"


def test_a_channel_that_a_run_lacks_stays_blank_there(machine, observed):
    used, unseen = observed
    gone = unseen.channels[3]
    frame = unseen.run.frame.drop(columns=[f"{gone}_degC"])
    (lacking,) = observe(machine, [Run("lacking", frame)])
    assert gone not in lacking.channels
    shown = regime_map([residuals(machine, one) for one in (used, lacking)])
    assert [name for name, _ in shown.rows] == list(used.channels)
    cells = dict(shown.rows)
    assert [bool(cell.text) for cell in cells[gone]] == [True] * 4 + [False] * 4
    assert all(cell.text for cell in cells[used.channels[4]])


def test_a_signature_is_what_one_addition_alone_changes(machine, observed):
    shift = Candidate("centrifugal_shift", {"shift": 15.0}, ())
    grows = AddedChange(MovesAxis(("shaft_front", "Z"), -1.0), {"length": 300.0}, ())
    after = grows.put_into(shift.put_into(machine))
    nothing, both = (
        SimpleNamespace(base=machine, machine=which, observed=observed)
        for which in (machine, after)
    )
    found = GapResult(
        SimpleNamespace(
            nothing=SimpleNamespace(fit=nothing),
            best=SimpleNamespace(additions=(shift, grows), fit=both),
        )
    )
    of_shift, of_growth = signature_charts(found)
    assert of_shift.name == "signature_centrifugal_shift_fast", "the run in which it does most"
    assert of_growth.name == "signature_moves_axis_shaft_front+Z_fast"
    left, signature = lines_of(of_shift, "S5")
    assert np.ptp(signature) == pytest.approx(15.0 * (16.0 / 20.0) ** 2, rel=0.02)
    # Nothing but the growth was wrong, so that without it its signature is left, and noise.
    _, growth = lines_of(of_growth, "S5")
    assert np.std(left - signature + growth) < 0.1 * np.std(left)
    assert np.ptp(growth) > 1.0


def test_what_a_second_addition_explains_also_counts_from_nothing_added():
    def hypothesis(*keys: str, cost: float) -> Any:
        none = dict.fromkeys(("cost_left_out", "score"), lambda _: 0.0)
        fit = SimpleNamespace(cost=cost, machine=None)
        return SimpleNamespace(keys=keys, fit=fit, cost_in_fit=0.0, **none)

    path, mass = "heat_path:bed+column", "hidden_mass:bed"
    one, both = hypothesis(path, cost=40.0), hypothesis(path, mass, cost=10.0)
    step: Any = SimpleNamespace(baseline=one, tried=(both,), units=None)
    found = SearchResult(hypothesis(cost=100.0), both, (), (step,))
    shown = _round(step, found)
    assert shown["share"] == pytest.approx(0.6)
    assert shown["rows"][0]["share"] == pytest.approx(0.9)
    assert GapResult(found).explained == pytest.approx(0.9), "as the first line says"
