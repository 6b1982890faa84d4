"""The reference: what lagged inputs predict of readings and of what a model leaves of them."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.observations import Observations, observe
from gap_finder.reference import LAGS_MIN, ReferenceModel
from gap_finder.regimes import RunResiduals, residuals
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of


@pytest.fixture(scope="module")
def observed(jig_borer_lumps: Machine) -> list[Observations]:
    return observe(jig_borer_lumps, runs_of(jig_borer_lumps))


def behind(observed: Observations, lag_min: float) -> np.ndarray:
    """The spindle speed behind a lag, as an exact sum of exponentials."""
    time, speed = observed.run.time_s, observed.run.frame["speed_rpm"].to_numpy()
    changes = np.diff(speed, prepend=0.0)
    since = np.maximum(observed.time_s[:, None] - time[None, changes != 0.0], 0.0)
    return (1.0 - np.exp(-since / (60.0 * lag_min))) @ changes[changes != 0.0]


def test_a_lag_of_the_speed_is_found_with_its_lag_and_channel(jig_borer_lumps, observed):
    found = [residuals(jig_borer_lumps, one) for one in observed]
    at = observed[0].channels.index("T8")
    for one in found:
        one.values[:, at] += 1.5 * behind(one.observed, 45.0) / 10000.0
    reference = ReferenceModel(jig_borer_lumps, found[:3], found[3:])
    places = reference.places()
    assert {place.channel for place in places} == {"T8"}
    # Hours of a steady speed hold most of it, though half an hour of cooling down is further off.
    assert places[0].regime == "steady"
    assert places[0].tolerances < max(place.tolerances for place in places)
    sources = reference.sources("T8")
    assert sources[0].input == "speed"
    assert sources[0].share > 0.9
    assert sources[0].lag_min == 45.0
    for before, after in ((found[0], reference.used[0]), (found[3], reference.unseen[0])):
        rms = [float(np.sqrt(np.mean(part[:, at] ** 2))) for part in (before.values, after.values)]
        assert rms[1] < 0.25 * rms[0]


def test_noise_is_not_reducible(jig_borer_lumps, observed):
    reference = ReferenceModel(
        jig_borer_lumps, [residuals(jig_borer_lumps, one) for one in observed]
    )
    assert 0.0 <= reference.share < 0.1
    assert reference.places() == []


def test_a_channel_that_is_missing_in_a_run_is_no_obstacle(jig_borer_lumps, observed):
    found = [residuals(jig_borer_lumps, one) for one in observed]
    empty = found[1].values.copy()
    empty[:, 0] = np.nan
    found[1] = RunResiduals(
        replace(found[1].observed, values=found[1].observed.values + empty * 0), empty
    )
    reference = ReferenceModel(jig_borer_lumps, found)
    assert np.isnan(reference.used[1].values[:, 0]).all()
    assert np.isfinite(reference.used[0].values).all()
    assert np.isfinite(reference.share)


def test_rows_without_a_reading_do_not_weaken_the_regression(jig_borer_lumps, observed):
    found = [residuals(jig_borer_lumps, one) for one in observed]
    at = observed[0].channels.index("T8")
    for one in found:
        one.values[:, at] += 1.5 * behind(one.observed, 45.0) / 10000.0
        one.values[np.arange(len(one.values)) % 3 > 0, at] = np.nan
    sources = ReferenceModel(jig_borer_lumps, found).sources("T8")
    assert (sources[0].input, sources[0].lag_min) == ("speed", 45.0)
    assert sources[0].share > 0.9


def test_how_warm_it_started_is_a_source(jig_borer_lumps, observed):
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
