"""Probes that slip by a few micrometres, and what is not a slip."""

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.data_faults import without_faults
from gap_finder.probe_steps import probe_steps
from measurement.runs import Run
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of

AT_S = 6750.0


def slipped(run: Run, at_s: float = AT_S, **leaps: float) -> Run:
    """Return a run in which channels leap by so much."""
    later = run.time_s >= at_s
    frame = run.frame.assign(**{name: run.frame[name] + by * later for name, by in leaps.items()})
    return Run(run.name, frame)


@pytest.fixture(scope="module")
def runs(jig_borer_lumps: Machine) -> list[Run]:
    return runs_of(jig_borer_lumps)


@pytest.mark.parametrize("leap", [2.5, -20.0])
@pytest.mark.parametrize("probe", ["S1", "S5"])
def test_a_slip_is_found_and_put_back(probe, leap, jig_borer_lumps, runs):
    column = f"{probe}_um"
    kept, faults = without_faults(jig_borer_lumps, [slipped(runs[0], **{column: leap}), *runs[1:]])
    (fault,) = faults
    assert (fault.run, fault.channel, fault.kind) == ("down", probe, "probe_step")
    assert fault.start_s == fault.end_s == AT_S
    said = float(fault.text.partition("leaps by ")[2].partition(" um")[0])
    assert said == pytest.approx(leap, abs=0.8)
    apart = (kept[0].frame - runs[0].frame).to_numpy()
    assert np.abs(apart).max() < 0.8
    assert kept[0].frame[column].iloc[:100].equals(runs[0].frame[column].iloc[:100])


def test_sound_runs_have_none(jig_borer_lumps, runs):
    assert probe_steps(jig_borer_lumps, runs) == [()] * len(runs)


def test_what_leaps_together_is_no_slip(jig_borer_lumps, runs):
    for others in ({"S3_um": -3.0}, {"T2_degC": 1.0}):
        both = slipped(runs[0], S1_um=6.0, **others)
        assert probe_steps(jig_borer_lumps, [both]) == [()]


def test_what_leaps_at_a_switch_is_no_slip(jig_borer_lumps, runs):
    switch = 1.2 * 3600.0
    assert probe_steps(jig_borer_lumps, [slipped(runs[0], switch + 60.0, S1_um=6.0)]) == [()]


def test_a_bearing_that_slips_again_and_again_is_none(jig_borer_lumps, runs):
    once = slipped(runs[3], S5_um=5.0)
    assert [one.channel for one in probe_steps(jig_borer_lumps, [once])[0]] == ["S5"]
    again = slipped(once, 8700.0, S5_um=-5.0)
    assert probe_steps(jig_borer_lumps, [again]) == [()]
    in_two_runs = [once, slipped(runs[0], S5_um=5.0)]
    assert probe_steps(jig_borer_lumps, in_two_runs) == [(), ()]
    # A probe that elongation does not move may slip twice.
    radial = slipped(slipped(runs[3], S2_um=5.0), 8700.0, S2_um=4.0)
    assert [one.channel for one in probe_steps(jig_borer_lumps, [radial])[0]] == ["S2", "S2"]
    sticking = with_effect(jig_borer_lumps, "bearing_stick_slip", {"hold": 8.0, "share": 0.8})
    assert probe_steps(jig_borer_lumps, runs_of(sticking)) == [()] * 4
