"""The page on the studies' experiment is what its command writes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies import Judged, compensation_table, etas, prediction_table
from benchmarks.studies_machines import EVERY_S, finite_element_spindle
from benchmarks.studies_text import PAGE
from measurement.rig import FivePointRig

DOCS = Path(__file__).resolve().parents[2] / "docs"
RIG = FivePointRig(spacing_mm=100.0, near_to_gauge_mm=30.0)


def test_the_page_holds_the_text_and_a_table_at_every_place() -> None:
    page = (DOCS / "studies.md").read_text(encoding="utf-8")
    parts = re.split(r"\{\w+\}", PAGE)
    pattern = r"((?:\|.*\|\n?)+)".join(map(re.escape, parts))
    found = re.fullmatch(pattern, page)
    assert found, "python -m benchmarks.studies --write"
    assert [table.count("\n") > 2 for table in found.groups()] == [True] * 5


def judged(scale: float) -> Judged:
    pose = np.outer(np.linspace(1.0, 2.0, 20), [30.0, 20.0, -10.0, 4.0, -5.0])
    return Judged("bp", "BP", (pose, scale * pose), (pose, scale * pose), {})


def test_eta_and_improvement_are_those_of_the_error_that_is_left() -> None:
    assert etas(judged(0.9).unseen) == pytest.approx([90.0] * 5)
    assert "| 90.0 (97.8) |" in prediction_table([judged(0.9)])
    cells = compensation_table([judged(0.75)], RIG).splitlines()[-1].split(" | ")
    # The tilt is small, so a pose that is a quarter short leaves a quarter of the drift.
    assert cells[3:5] == ["75 / 75 / 75"] * 2
    assert cells[5] == "60.0 to 15.0, 45.0 to 11.2 |"


def test_the_finite_element_spindle_warms_and_grows_with_noisy_sensors() -> None:
    run = finite_element_spindle(["stop_and_go"])[0]
    frame: pd.DataFrame = run.frame
    assert np.diff(run.time_s) == pytest.approx(EVERY_S)
    assert frame["T6_degC"].max() - frame["T6_degC"].iloc[0] > 3.0
    assert frame["elongation_um"].max() > 10.0
    hall = frame["T5_degC"].to_numpy()
    assert 0.02 < np.std(np.diff(hall)) / 2**0.5 < 0.04
