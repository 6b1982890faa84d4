"""The reference: what lagged inputs predict of readings and of what a model leaves of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.description import NamedChange
from gap_finder.find import GapResult
from gap_finder.held_out import confirmed
from gap_finder.kinds.heat_path import HeatPath
from gap_finder.observations import Observations, observe
from gap_finder.reference import LAGS_MIN, LEFT, ReferenceModel
from gap_finder.regimes import RunResiduals, residuals
from gap_finder.selection import select_effect
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of
from tests.gap_finder.test_find import _Scored


@pytest.fixture(scope="module")
def observed(jig_borer_lumps: Machine) -> list[Observations]:
    return observe(jig_borer_lumps, runs_of(jig_borer_lumps))


def behind(observed: Observations, lag_min: float) -> np.ndarray:
    """The spindle speed behind a lag, as an exact sum of exponentials."""
    time, speed = observed.run.time_s, observed.run.frame["speed_rpm"].to_numpy()
    changes = np.diff(speed, prepend=0.0)
    since = np.maximum(observed.time_s[:, None] - time[None, changes != 0.0], 0.0)
    return (1.0 - np.exp(-since / (60.0 * lag_min))) @ changes[changes != 0.0]


def test_a_lag_of_the_speed_is_found_with_its_lag_and_channel(
    jig_borer_lumps: Machine, observed: list[Observations]
) -> None:
    found = [residuals(jig_borer_lumps, one) for one in observed]
    at = observed[0].channels.index("T8")
    for one in found:
        one.values[:, at] += 1.5 * behind(one.observed, 45.0) / 10000.0
    reference = ReferenceModel(jig_borer_lumps, found[:3], found[3:])
    assert reference.is_left
    assert {place.channel for place in reference.places()} == {"T8"}
    sources = reference.sources_of("T8")
    assert sources[0].input == "speed"
    assert sources[0].share > 0.9
    assert sources[0].lag_min == 45.0
    for before, after in ((found[0], reference.known[0]), (found[3], reference.unseen[0])):
        rms = [float(np.sqrt(np.mean(part[:, at] ** 2))) for part in (before.values, after)]
        assert rms[1] < 0.25 * rms[0]


def test_noise_is_not_reducible(jig_borer_lumps: Machine, observed: list[Observations]) -> None:
    reference = ReferenceModel(
        jig_borer_lumps, [residuals(jig_borer_lumps, one) for one in observed]
    )
    assert 0.0 <= reference.reducible < 0.1 < LEFT
    assert not reference.is_left
    assert reference.places() == []


def test_a_channel_that_is_missing_in_a_run_is_no_obstacle(
    jig_borer_lumps: Machine, observed: list[Observations]
) -> None:
    found = [residuals(jig_borer_lumps, one) for one in observed]
    empty = found[1].values.copy()
    empty[:, 0] = np.nan
    found[1] = RunResiduals(
        replace(found[1].observed, values=found[1].observed.values + empty * 0), empty
    )
    reference = ReferenceModel(jig_borer_lumps, found)
    assert np.isnan(reference.known[1][:, 0]).all()
    assert np.isfinite(reference.known[0]).all()
    assert np.isfinite(reference.reducible)


def test_how_warm_it_started_is_a_source(
    jig_borer_lumps: Machine, observed: list[Observations]
) -> None:
    found = []
    for one, warm in zip(observed, (6.0, -3.0, 0.5, 4.0), strict=True):
        shifted = one.values + np.where([n.startswith("T") for n in one.channels], warm, 0.0)
        left = np.zeros_like(shifted)
        left[:, 2] = 0.3 * warm * np.exp(-one.time_s / (60.0 * LAGS_MIN[4]))
        found.append(RunResiduals(replace(one, values=shifted), left))
    (source, *_) = ReferenceModel(jig_borer_lumps, found).sources()
    assert source.input == "start"
    assert source.lag_min in LAGS_MIN[3:6]
    assert source.share > 0.9


def test_an_answer_that_makes_the_unseen_run_worse_is_taken_back(
    jig_borer_lumps: Machine, observed: list[Observations]
) -> None:
    def scored(name: str, machine: Machine) -> _Scored:
        one = _Scored(name, [20.0 if name else 50.0] * 3)
        one.machine, one.observed = machine, observed[:3]
        if not name:
            one.added = ()
        return one

    now = scored("", jig_borer_lumps)
    wrong = scored("windage", with_effect(jig_borer_lumps, "windage", {"power": 200.0}))
    selection = select_effect(now, [wrong], 0.1, channels=14)
    found = GapResult(now, wrong, (selection,))
    assert found.verdict == "effect"
    kept, comparison = confirmed(found, observed[3:])
    assert [one.key for one in kept.withdrawn] == ["windage"]
    assert kept.after is now
    assert kept.verdict == "unknown"
    assert comparison.gap()["after"] == comparison.gap()["before"]
    # So is a change of the description, and what was tried stays what it was: effects.
    unnamed = select_effect(now, [wrong], 0.9, channels=14)
    path = NamedChange(HeatPath(("rotor", "pedestal"), boundary=False), selection, wrong)
    kept, _ = confirmed(GapResult(now, wrong, (unnamed,), changes=(path,)), observed[3:])
    assert [one.key for one in kept.withdrawn] == ["heat_path:rotor+pedestal"]
    assert (kept.after, kept.changes, kept.verdict) == (now, (), "unknown")
    assert kept.rounds[0].fits == unnamed.fits
    # The other way round it makes the run better, and stays.
    wrong.machine, now.machine = now.machine, wrong.machine
    assert confirmed(found, observed[3:])[0] is found
