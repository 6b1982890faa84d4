"""One long recording as several runs that begin as warm as the one before ended."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from gap_finder.long_log import need_no_leap, own_hours, pieces_of
from gap_finder.observations import observe
from gap_finder.regimes import gap_of, residuals
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.simulate import simulate
from scenarios.gap_runner import _in_pieces
from tests.gap_finder.conftest import inputs_of
from tests.refusing import refusal


@pytest.fixture(scope="module")
def log(jig_borer_lumps: Machine) -> Run:
    """Nine hours without a pause between what the three spectra ask for."""
    parts = []
    for i, name in enumerate(("down", "stairs", "stops")):
        part = inputs_of(name, 60.0).iloc[:-1]
        parts.append(part.assign(time_s=part["time_s"] + i * 3.0 * 3600.0))
    inputs = pd.concat(parts, ignore_index=True)
    return Run("log", simulate(jig_borer_lumps, inputs, noise_seed=3).run_frame())


def test_pieces_hold_their_own_hours_and_what_drove_the_machine_before(jig_borer_lumps, log):
    pieces = pieces_of(jig_borer_lumps, log, 3.0)
    assert [one.name for one in pieces] == ["log_1of3", "log_2of3", "log_3of3"]
    driving = ["time_s", "speed_rpm", "T5_degC", "T9_degC"]
    for number, piece in enumerate(pieces):
        pd.testing.assert_frame_equal(piece.frame[driving], log.frame[driving])
        assert np.flatnonzero(piece.frame["T1_degC"].notna()).tolist() == [
            *range(bool(number)),
            *range(180 * number, 180 * (number + 1)),
        ]
        read = piece.frame["T1_degC"].dropna()
        pd.testing.assert_series_equal(read, log.frame["T1_degC"][read.index])


def test_pieces_are_driven_alike_and_observed_once(jig_borer_lumps, log):
    observed = observe(jig_borer_lumps, pieces_of(jig_borer_lumps, log, 3.0))
    assert all(piece.drive.is_like(observed[0].drive) for piece in observed)
    (whole,) = observe(jig_borer_lumps, [log])
    firsts = len(observed) - 1  # the log's first row once more in each later piece
    assert sum(len(piece.time_s) for piece in observed) == len(whole.time_s) + firsts
    drawn = [own_hours(piece) for piece in observed]
    np.testing.assert_array_equal(np.concatenate([p.time_s for p in drawn]), whole.time_s)
    assert [len(p.values) for p in drawn] == [len(p.weights) for p in drawn]
    assert drawn[0] is observed[0]
    assert own_hours(whole) is whole


def test_hidden_parts_begin_where_the_piece_before_left_them(jig_borer_lumps, log):
    pieces = pieces_of(jig_borer_lumps, log, 3.0)
    whole = gap_of([residuals(jig_borer_lumps, one) for one in observe(jig_borer_lumps, pieces)])
    cut = []
    for number in range(3):
        rows = log.frame.iloc[180 * number : 180 * (number + 1)].reset_index(drop=True)
        cut.append(Run(f"cut_{number}", rows.assign(time_s=rows["time_s"] - rows["time_s"][0])))
    alone = gap_of([residuals(jig_borer_lumps, one) for one in observe(jig_borer_lumps, cut)])
    assert whole < 2.0  # The first reading, which starts the parts, has its noise.
    assert alone > 3.0 * whole


def test_a_short_rest_stays_with_the_piece_before(jig_borer_lumps, log):
    assert _ends(pieces_of(jig_borer_lumps, log, 4.4)) == [264, 540]
    assert pieces_of(jig_borer_lumps, log, 20.0) == [log]


def _ends(pieces: list[Run]) -> list[int]:
    return [piece.frame["T1_degC"].last_valid_index() + 1 for piece in pieces]


def _paused(log: Run, row: int, hours: float) -> Run:
    late = log.frame["time_s"] + 3600.0 * hours * (log.frame.index >= row)
    return replace(log, frame=log.frame.assign(time_s=late))


def test_no_piece_begins_in_a_pause(jig_borer_lumps, log):
    pieces = pieces_of(jig_borer_lumps, _paused(log, 180, 7.0), 2.0)
    assert _ends(pieces) == [120, 180, 300, 420, 540]


@pytest.mark.parametrize("row", [1, 270, 539])
def test_a_run_is_cut_where_its_clock_leaps_by_months(log, row):
    said = refusal(need_no_leap, _paused(log, row, 8000.0))
    last = 60.0 * (row - 1)
    assert said.startswith(f"log: column time_s: {last + 60.0 + 8000.0 * 3600.0} after {last}, ")
    assert said.endswith("cut the run in two there, as spindle-drift import does")


def test_a_run_pauses_while_the_rest_is_longer_or_the_machine_warm(log):
    for run in (log, _paused(log, 270, 8.9), Run("one", log.frame[:1])):
        need_no_leap(run)
    short = Run("short", log.frame[:60])
    need_no_leap(_paused(short, 30, 7.9))
    assert "longer than all the rest" in refusal(need_no_leap, _paused(short, 30, 8.0))


def test_a_sensor_that_comes_late_and_one_that_never_reads(jig_borer_lumps, log):
    frame = log.frame.copy()
    frame.loc[:9, "T1_degC"] = np.nan
    frame["T2_degC"] = np.nan
    last = pieces_of(jig_borer_lumps, replace(log, frame=frame), 3.0)[-1].frame
    assert last["T1_degC"].iloc[0] == frame["T1_degC"].iloc[10]
    assert last["T2_degC"].isna().all()


def test_the_last_piece_is_kept_back_and_too_few_are_refused(jig_borer_lumps, log):
    used, kept_back = _in_pieces(jig_borer_lumps, [log], [], 2.25)
    assert [one.name for one in used] == ["log_1of4", "log_2of4", "log_3of4"]
    assert [one.name for one in kept_back] == ["log_4of4"]
    used, kept_back = _in_pieces(jig_borer_lumps, [log], [log], 3.0)
    assert (len(used), kept_back) == (3, [log])
    assert "make 3 runs; 4 or more" in refusal(_in_pieces, jig_borer_lumps, [log], [], 3.0)
