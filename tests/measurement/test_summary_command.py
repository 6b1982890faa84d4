"""``spindle-drift summary``."""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from measurement.errors import BadInput
from measurement.runs import write_run
from spindle_drift.commands import summary
from tests.refusing import refusal


def call(*words: object) -> int:
    parser = argparse.ArgumentParser()
    summary.add_arguments(parser)
    return summary.run(parser.parse_args([str(word) for word in words]))


@pytest.fixture
def five_point_run(tmp_path: Path) -> Path:
    time = 60.0 * np.arange(100)
    columns = {f"S{i}_um": i * time / 1000 for i in range(1, 6)}
    temperatures = {f"T{i}_degC": 20.0 + time / 1000 for i in range(1, 12)}
    frame = pd.DataFrame({"time_s": time, "speed_rpm": 6000.0, **temperatures, **columns})
    return write_run(frame, tmp_path / "warm.csv")


@pytest.fixture
def direct_run(tmp_path: Path) -> Path:
    frame = pd.DataFrame({"time_s": [0.0, 60.0], "disp_x_um": [0.0, 3.0]})
    return write_run(frame, tmp_path / "other" / "warm.csv")


def test_tables_for_people(five_point_run, direct_run, capsys):
    assert call(five_point_run, direct_run) == 0
    shown = capsys.readouterr().out
    assert shown.count("Run warm") == 2
    assert "disp_x (+X)" in shown
    assert "yaw" not in shown  # nobody said how far apart the sensors are


def test_the_machine_gives_tilt_and_ambient(five_point_run, capsys):
    assert call(five_point_run, "--machine", "jig_borer", "--json") == 0
    (table,) = json.loads(capsys.readouterr().out)
    assert table["spacing_mm"] == 100.0
    # S3 - S1 grows by 2 um per 1000 s over 5940 s and 100 mm
    assert table["pose"]["yaw_urad"]["whole"] == pytest.approx(118.8, rel=1e-6)
    assert table["ambient"]["column"] == "T5_degC"
    assert call(five_point_run, "--ambient", "T9_degC", "--json") == 0
    (table,) = json.loads(capsys.readouterr().out)
    assert table["ambient"]["column"] == "T9_degC"


@pytest.mark.usefixtures("drawn")
def test_a_folder_of_results_with_a_figure_per_run(five_point_run, direct_run, tmp_path, capsys):
    out = tmp_path / "out"
    assert call(five_point_run, direct_run, "--out", out, "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert json.loads((out / "summary.json").read_text()) == printed
    assert sorted(path.name for path in out.iterdir()) == [
        "summary.json",
        "table.json",
        "warm-2.png",
        "warm.png",
    ]


def test_one_bad_run_of_several_stops_all_before_anything_is_written(
    five_point_run, tmp_path, capsys
):
    bad = tmp_path / "bad.csv"
    bad.write_text("time_s,T1_degC\n0,20\n1,900\n")
    with pytest.raises(BadInput, match=r"row 3, column T1_degC: 900 is outside -60\.\.400 degC"):
        call(five_point_run, bad, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("option", ["--machine", "--ambient"])
def test_a_wrong_option_is_refused_in_one_line(five_point_run, option):
    assert "none_such" in refusal(call, five_point_run, option, "none_such")
