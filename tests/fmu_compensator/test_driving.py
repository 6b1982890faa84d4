"""A compensator driven through runs: which rows count, and leaps of what remains."""

from dataclasses import replace

import numpy as np
import pytest

from fmu_compensator.driving import Driven, drive
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.leaps import leaps_of
from fmu_compensator.runtime.compensator import Output
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.runs import Run
from tests.fmu_compensator.conftest import RIG, make_run

DISPLACEMENTS, AT = RIG.columns, 130


@pytest.fixture(scope="module")
def model() -> Model:
    table = fit_compensator([make_run(f"r{n}", n) for n in range(4)], RIG, judge=False)
    return parse_model(compensator_text(table), "m.json")


def test_rare_measurements_all_count_and_the_first_is_the_zero(model):
    """Rows every 13 s are thinned to every 65 s: of the probes, one in five would be left."""
    run = make_run(seed=50, step_s=13.0)
    frame = run.frame.copy()
    probed = np.arange(len(frame)) % 50 == 1
    frame.loc[~probed, DISPLACEMENTS] = np.nan
    probes = Run("probes", frame)
    some, whole = (drive(model, one, one, RIG, 100.0) for one in (probes, run))
    known = np.isfinite(some.drift).all(axis=1)
    np.testing.assert_array_equal(some.time_s[known], run.time_s[probed])
    assert len(whole.time_s) == pytest.approx(len(frame) / 5, abs=1)
    np.testing.assert_array_equal(some.drift[known][0], 0.0)


def left_with(leap_um: float, *, back_after: int = 1000, noise_um: float = 0.2) -> Driven:
    """Return a run with offsets of zero and a drift along Z that creeps and leaps once."""
    time = np.arange(300) * 60.0
    drift = np.full((300, 3), np.nan)
    drift[:, 2] = np.random.default_rng(3).normal(0.0, noise_um, 300) + 0.01 * np.arange(300)
    drift[AT : AT + back_after, 2] += leap_um
    drift[0, 2] = 0.0
    widths = dict.fromkeys(("dX_uncertainty", "dY_uncertainty", "dZ_uncertainty"), 5.0)
    zero = dict.fromkeys(Output._fields, 0.0) | widths | {"status": 0}
    return Driven(time, [Output(**zero)] * 300, drift, "rise")  # type: ignore[arg-type]


def standing(switched_at: int | None = None) -> Run:
    """Return a run of five hours at 2,000 r/min, or switched once."""
    run = make_run(hours=4.99, step_s=60.0)
    speed = np.full(len(run.frame), 2000.0)
    if switched_at is not None:
        speed[switched_at:] = 6000.0
    return Run("run", run.frame.assign(speed_rpm=speed))


def test_a_leap_of_what_remains_is_told_with_its_size_and_instant():
    found = leaps_of(standing(), left_with(8.0))
    assert list(found) == ["Z"]
    assert found["Z"].startswith("Z leaps by +8.")
    assert f"at {AT} min" in found["Z"]


@pytest.mark.parametrize(
    ("run", "driven"),
    [
        (standing(), left_with(4.0)),  # within the interval
        (standing(), left_with(8.0, back_after=1)),  # it comes back at once
        (standing(), left_with(8.0, noise_um=4.0)),  # as large as the noise
        (standing(AT), left_with(8.0)),  # the spindle was switched
    ],
)
def test_what_is_no_leap(run, driven):
    assert leaps_of(run, driven) == {}


def test_an_offset_that_moves_at_once_is_no_leap_of_the_drift():
    driven = left_with(0.0)
    sent = [one._replace(dZ=8.0) if k >= AT else one for k, one in enumerate(driven.outputs)]
    assert leaps_of(standing(), replace(driven, outputs=sent)) == {}
