"""The replay: a compensator FMU against runs whose drift is known."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fmu_compensator.driving import drive
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.modelfile import load_model
from measurement.drift import measured_drift
from measurement.errors import BadInput
from measurement.rig import DirectRig, FivePointRig, rig_from_table
from measurement.runs import Run, read_run
from scenarios.cli import main
from scenarios.fmu_files import build_compensator
from scenarios.probing import Probing
from scenarios.replay import Replay, model_of, replay, rig_of_model
from spindle_drift._inputs import DoubtfulData
from spindle_drift.compensators import Compensator
from tests.scenarios.conftest import written

DIRECT = {"kind": "direct", "axes": {"disp_x": {"axis": "X", "sign": -1}, "growth": {"axis": "Z"}}}
RUNS = [("monday", 7), ("tuesday", 8)]
FIVE = {"kind": "five_point", "spacing_mm": 100.0, "near_to_gauge_mm": 30.0, "axial_sign": -1}


def warming(name: str, seed: int, step_s: float = 20.0) -> Run:
    """A run of 2 h in which two temperatures rise and fall, and drift is a mix of them."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 7200.0, step_s)
    speed = np.repeat(random.integers(0, 8, 12) * 1000.0, len(time) // 12)[: len(time)]
    a = np.zeros(len(time))
    b = np.zeros(len(time))
    for k in range(1, len(time)):
        a[k] = a[k - 1] + step_s / 900.0 * (speed[k - 1] / 800.0 - a[k - 1])
        b[k] = b[k - 1] + step_s / 2400.0 * (speed[k - 1] / 1600.0 - b[k - 1])
    drift_x, drift_z, yaw = 2.0 * a - b, -4.0 * a - 1.0 * b, (a - b) * 5e-6
    columns = {
        "time_s": 50.0 + time,
        "speed_rpm": speed,
        "T1_degC": 20.0 + a,
        "T2_degC": 21.0 + b,
        "disp_x_um": -drift_x,
        "growth_um": drift_z,
        "S1_um": drift_x,
        "S2_um": 0.3 * a,
        "S3_um": drift_x + 1e5 * np.tan(yaw),
        "S4_um": 0.3 * a + 1e5 * np.tan(2e-6 * b),
        "S5_um": drift_z,
    }
    return Run(name, pd.DataFrame(columns))


def built(
    rig: DirectRig | FivePointRig,
    folder: Path,
    make: Callable[[str, int], Run] = warming,
    **options: Any,
) -> Path:
    runs = [make(f"training_{seed}", seed) for seed in (1, 2, 3)]
    usual: dict[str, Any] = {"points": "all", "sensors": ["T1", "T2"], "judge": False}
    usual["use_speed"] = False  # a change of speed would tell what a probe is to find
    table = fit_compensator(runs, rig, "mlr", **usual, **options)
    model = folder / "model.json"
    model.write_text(compensator_text(table), encoding="utf-8")
    return model


@pytest.fixture(scope="module")
def direct_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(rig_from_table(DIRECT, "rig"), tmp_path_factory.mktemp("direct"))


@pytest.fixture(scope="module")
def direct_fmu(direct_model: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_compensator(direct_model, tmp_path_factory.mktemp("direct_fmu"))


def replayed(fmu: Path, run: Run, *more: float, **options: Any) -> Replay:
    """Replay a run on an FMU as it is."""
    model = model_of(fmu)
    return replay(fmu, model, run, rig_of_model(model), *more, **options)


def test_directions_come_from_the_compensator_file(direct_fmu):
    run = warming("unseen", 9)
    found = replayed(direct_fmu, run)
    frame = found.frame
    assert frame["drift_X_um"].to_numpy() == pytest.approx(-run.frame["disp_x_um"].to_numpy())
    assert frame["drift_Z_um"].to_numpy() == pytest.approx(run.frame["growth_um"].to_numpy())
    assert "drift_Y_um" not in frame
    for axis in "XZ":
        before, after = (frame[f"{what}_{axis}_um"].abs().mean() for what in ("drift", "error"))
        assert after < 0.15 * before
        total = (frame[f"drift_{axis}_um"] + frame[f"d{axis}_um"]).to_numpy()
        assert frame[f"error_{axis}_um"].to_numpy() == pytest.approx(total)


@pytest.mark.parametrize("probing", [None, Probing(every_s=900.0, noise_um=0.0)])
def test_a_replay_judges_as_fit_does(doubting_fmu, probing):
    model = model_of(doubting_fmu)
    run = Run("unseen", begun_late("unseen", 9).frame[::3].reset_index(drop=True))  # one a minute
    rig = rig_of_model(model)
    frame = replay(doubting_fmu, model, run, rig, probing=probing).frame
    every_s = None if probing is None else probing.every_s
    driven = drive(model, run, run, rig, 100.0, probe_every_s=every_s)
    second = 0.01  # later a probe is known here: so much may happen in it [um]
    for place, axis in enumerate("XYZ"):
        if f"error_{axis}_um" in frame:
            expected = pytest.approx(driven.error[:, place], abs=second)
            assert frame[f"error_{axis}_um"].to_numpy() == expected
            assert frame[f"d{axis}_uncertainty_um"].to_numpy() == pytest.approx(
                driven.half_width[:, place], abs=second
            )


def test_the_tilt_counts_at_the_tool_length(tmp_path):
    rig = rig_from_table(FIVE, "rig")
    fmu = build_compensator(built(rig, tmp_path, tool_length_mm=(0.0, 300.0)), tmp_path)
    run = warming("unseen", 9)
    for length in (30.0, 250.0):
        frame = replayed(fmu, run, length).frame
        s1, s3 = run.frame["S1_um"].to_numpy(), run.frame["S3_um"].to_numpy()
        expected = s1 + (length - 30.0) * (s3 - s1) / 100.0
        assert frame["drift_X_um"].to_numpy() == pytest.approx(expected, abs=1e-6)
        assert frame["error_X_um"].abs().mean() < 0.15 * frame["drift_X_um"].abs().mean()


def test_sensors_look_the_way_that_they_did_in_training(tmp_path):
    rig = rig_from_table(FIVE | {"axial_sign": 1}, "rig")
    assert rig_of_model(load_model(built(rig, tmp_path))) == rig


def test_drift_of_a_tilted_tool_keeps_the_exact_cosine():
    columns = {
        "time_s": [0.0],
        "S1_um": 0.0,
        "S2_um": 0.0,
        "S3_um": 2e4,
        "S4_um": 0.0,
        "S5_um": 0.0,
    }
    rig = rig_from_table(FIVE, "rig")
    run = Run("tilted", pd.DataFrame(columns))
    drift = measured_drift(run, rig, 130.0, "absolute")
    assert drift["drift_X_um"][0] == pytest.approx(2e4)
    # A tool of 130 mm along a line that leans 0.2 in 1 is shorter along Z.
    assert drift["drift_Z_um"][0] == pytest.approx(130e3 * (1.0 - 1.0 / np.hypot(1.0, 0.2)))


def test_a_thermometer_that_is_read_rarely_is_held_and_one_that_fails_is_not(direct_fmu):
    run = warming("unseen", 9)
    rows = np.arange(len(run.frame))
    rare = Run("rare", run.frame.assign(T2_degC=run.frame["T2_degC"].where(rows % 15 == 0)))
    failed = Run("failed", run.frame.assign(T2_degC=run.frame["T2_degC"].where(rows < 180)))
    frames = [replayed(direct_fmu, one).frame for one in (rare, failed)]
    assert set(frames[0]["status_1"]) <= {0, 1, 2}
    assert frames[0]["error_Z_um"].abs().mean() < 0.3 * frames[0]["drift_Z_um"].abs().mean()
    assert frames[1]["status_1"].iloc[-1] == 4


def test_rows_with_a_frozen_sensor_do_not_count_unless_asked(direct_fmu):
    run = warming("frozen", 9)
    frame = run.frame.copy()
    frame.loc[100:250, "disp_x_um"] = frame.loc[100, "disp_x_um"]
    frozen = Run("frozen", frame)
    found = replayed(direct_fmu, frozen)
    assert found.left_out >= 140
    assert found.frame["drift_X_um"].isna().sum() == found.left_out
    kept = replayed(direct_fmu, frozen, keep_frozen=True)
    assert kept.left_out == 0
    assert kept.frame["drift_X_um"].notna().all()


@pytest.mark.parametrize("form", ["rise", "level"])
def test_where_a_gauge_starts_is_no_drift(form, tmp_path):
    """500 um more on the gauge from the first sample on is the same run, whatever the form."""
    fmu = build_compensator(
        built(rig_from_table(DIRECT, "rig"), tmp_path, input_form=form), tmp_path
    )
    run = warming("unseen", 9)
    moved = Run("moved", run.frame.assign(growth_um=run.frame["growth_um"] + 500.0))
    plain, other = (replayed(fmu, one).frame for one in (run, moved))
    assert other["error_Z_um"].to_numpy() == pytest.approx(plain["error_Z_um"].to_numpy())
    assert other["error_Z_um"].abs().mean() < 0.15 * other["drift_Z_um"].abs().mean()


def test_a_run_without_displacements_says_that_nothing_was_judged(direct_model, tmp_path, prints):
    run = warming("blind", 9)
    (path,) = written(tmp_path, Run("blind", run.frame.assign(growth_um=np.nan)))
    said = prints(["replay", str(direct_model), path, "--out", str(tmp_path / "out")])
    assert "blind: no row has a sound displacement to judge Z by." in said


def test_what_remained_stands_beside_the_promise_of_the_file(tmp_path, prints):
    training = [warming(f"day{seed}", seed, 60.0) for seed in range(4)]
    table = fit_compensator(training, rig_from_table(DIRECT, "test"))
    model = tmp_path / "c.json"
    model.write_text(compensator_text(table))
    paths = written(tmp_path, warming("unseen", 9), warming("slow", 10, 40.0))
    said = prints(["replay", str(model), *paths, "--out", str(tmp_path / "out")])
    (line,) = (line for line in said.splitlines() if line.startswith("RMSE [um] without -> with"))
    files = [pd.read_csv(tmp_path / "out" / f"results_{name}.csv") for name in ("unseen", "slow")]
    squares = [(one[["drift_Z_um", "error_Z_um"]] ** 2).mean().to_numpy() for one in files]
    none, left = np.sqrt(np.mean(squares, axis=0))
    assert f" Z {none:.1f} -> {left:.1f};" in line
    row = table["provenance"]["figures"]["unseen"]["promised"]["Z"]
    promised = line.partition("promised by the compensator file: ")[2]
    assert f"Z {row['no_model']:.1f} -> {row['model']:.1f}." in promised
    assert line in (tmp_path / "out" / "report.html").read_text().replace("&gt;", ">")
    assert "Worse than" not in said
    assert "With an exact probe every hour the RMSE would be" in said


def test_a_displacement_flipped_since_training_is_doubted_and_no_other(
    direct_model, tmp_path, prints
):
    runs = [warming(name, seed) for name, seed in RUNS]
    turned = runs[1].frame.assign(growth_um=-runs[1].frame["growth_um"])
    paths = written(tmp_path, runs[0], Run("tuesday", turned))
    said = prints(["replay", str(direct_model), *paths, "--out", str(tmp_path / "out")])
    doubt = "Z drifts with the opposite sign of what the compensator learnt in tuesday: is the"
    assert doubt in said
    assert said.count("opposite sign of what") == 1
    assert "\nWorse than without compensation: tuesday (Z).\n" in said


def test_a_displacement_sensor_that_slips_is_told(direct_model, tmp_path, prints):
    run = warming("slipped", 9)
    growth = run.frame["growth_um"] + 15.0 * (run.time_s > 4000.0)
    slipped = run.frame.assign(growth_um=growth, speed_rpm=2000.0)
    with pytest.warns(DoubtfulData, match="run: Z leaps by .* and stays there"):
        Compensator.load(direct_model).judge(slipped)
    paths = written(tmp_path, Run("slipped", slipped), warming("sound", 8))
    said = prints(["replay", str(direct_model), *paths, "--out", str(tmp_path / "out")])
    assert "slipped: Z leaps by " in said
    assert said.count("and stays there; if a displacement sensor slipped") == 1


def test_a_compensator_that_never_starts_says_why(direct_model, tmp_path, prints):
    run = warming("hot", 9)
    hot = {name: run.frame[name] + 90.0 for name in run.frame if str(name).endswith("_degC")}
    (path,) = written(tmp_path, Run("hot", run.frame.assign(**hot)))
    said = prints(["replay", str(direct_model), path, "--out", str(tmp_path / "out")])
    assert "hot: the compensator never started: waiting for the first valid sample: T" in said
    assert " 0 %" in said


def test_an_axis_counts_from_its_own_first_reading_if_another_one_is_wrong(direct_fmu):
    run = Run("unseen", warming("unseen", 9).frame[::8].reset_index(drop=True))  # slowly sampled
    sound, spiked = (replayed(direct_fmu, given).frame for given in (run, spiked_first(run)))
    assert spiked["error_Z_um"].isna().tolist() == [True, *[False] * (len(spiked) - 1)]
    for name in ("drift_Z_um", "error_Z_um"):
        assert spiked[name][1:].to_numpy() == pytest.approx(sound[name][1:].to_numpy())


def spiked_first(run: Run) -> Run:
    frame = run.frame.copy()
    frame.loc[0, "disp_x_um"] -= 900.0
    return Run(run.name, frame)


def test_a_run_without_a_displacement_column_is_named(direct_fmu):
    run = Run("poor", warming("unseen", 9).frame.drop(columns="growth_um"))
    with pytest.raises(BadInput, match="poor: axes: the run has no column growth_um"):
        replayed(direct_fmu, run)


def test_a_run_without_a_chosen_temperature_is_refused(direct_fmu):
    run = Run("poor", warming("unseen", 9).frame.drop(columns="T2_degC"))
    with pytest.raises(BadInput, match="column T2_degC: is missing"):
        replayed(direct_fmu, run)


def test_an_fmu_without_a_compensator_file_is_refused(tiny_compensator):
    with pytest.raises(BadInput, match="holds no compensator file"):
        model_of(tiny_compensator)


def test_the_command_replays_several_runs(direct_model, tmp_path, prints, refused):
    paths = written(tmp_path, *(warming(name, seed) for name, seed in RUNS))
    out = tmp_path / "out"
    argv = ["replay", str(direct_model), *paths, "--out", str(out)]
    shown = prints(argv)
    for title in ("All runs together", "monday", "tuesday", "No compensation"):
        assert title in shown
    table = json.loads((out / "table.json").read_text())
    assert sorted(table["files"]) == sorted(path.name for path in out.iterdir())
    assert [group["title"] for group in table["table"]] == ["All runs together", *dict(RUNS)]
    whole, *single = (group["rows"][1]["axes"]["Z"] for group in table["table"])
    assert whole["samples"] == sum(axis["samples"] for axis in single)
    assert whole["improvement_percent"] > 80
    assert read_run(out / "results_monday.csv").frame["time_s"].iloc[0] == 50.0
    assert "monday: is the name of two of the runs" in refused([*argv[:3], paths[0], *argv[2:]])


def test_a_replay_scenario_finds_its_files_beside_it(direct_model, tmp_path, prints):
    written(tmp_path, warming("monday", 7))
    (tmp_path / "model.json").write_bytes(direct_model.read_bytes())
    scenario = tmp_path / "again.toml"
    scenario.write_text(
        'format = 1\nname = "again"\ntitle = "Again"\n'
        '[compensator]\nfmu = "model.json"\n[replay]\nruns = ["monday.csv"]\n'
    )
    table = json.loads(prints(["run", str(scenario), "--out", str(tmp_path / "out"), "--json"]))
    assert [group["title"] for group in table["table"]] == ["monday"]


@pytest.mark.long
@pytest.mark.real_data
def test_a_compensator_of_measured_runs_helps_on_runs_it_never_saw(lathe_runs, tmp_path, prints):
    model, out = tmp_path / "lathe.json", tmp_path / "out"
    training, unseen = lathe_runs[:-6], lathe_runs[-6:]
    few = ["--points", "all"]
    assert main(["fit", *map(str, training), *few, "-o", str(model)]) == 0
    assert "All runs together" in prints(
        ["replay", str(model), *map(str, unseen), "--out", str(out)]
    )
    whole = json.loads((out / "table.json").read_text())["table"][0]["rows"][1]["axes"]
    assert set(whole) == {"X", "Z"}
    for axis in whole.values():
        assert axis["improvement_percent"] > 25


def strange(name: str, seed: int) -> Run:
    """A run whose growth does what no temperature tells, and what a probe would."""
    run = warming(name, seed)
    hours = (run.time_s - run.time_s[0]) / 3600.0
    growth = run.frame["growth_um"] + 12.0 * np.sin(hours * np.pi / 2.0)
    return Run(name, run.frame.assign(growth_um=growth))


def begun_late(name: str, seed: int) -> Run:
    """The same, with times whose differences are a little less than they are written."""
    frame = strange(name, seed).frame
    return Run(name, frame.assign(time_s=frame["time_s"] + 0.7))


@pytest.fixture(scope="module")
def doubting_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A compensator whose training did such things as well, so that it trusts itself little."""
    folder = tmp_path_factory.mktemp("doubting")
    return build_compensator(built(rig_from_table(DIRECT, "rig"), folder, strange), folder)


def test_probes_at_fixed_intervals_correct_what_the_model_lacks(doubting_fmu):
    run = begun_late("unseen", 9)
    probing = Probing(every_s=900.0)
    found = replayed(doubting_fmu, run, probing=probing)
    assert np.diff(run.time_s[[0, *found.probes]]) == pytest.approx([900.0] * 7)
    frame = found.frame
    probed, unprobed = (frame[f"{what}error_Z_um"].abs().mean() for what in ("", "unprobed_"))
    assert probed < 0.7 * unprobed
    plain = replayed(doubting_fmu, run).frame
    assert np.array_equal(frame["unprobed_error_Z_um"], plain["error_Z_um"])
    # Up to the first probe there is no difference, and what is held comes from a probe before.
    first = found.probes[0]
    assert np.array_equal(frame["dZ_um"][: first + 1], plain["dZ_um"][: first + 1])
    held = (frame["drift_Z_um"] - frame["held_error_Z_um"]).to_numpy()
    assert not held[: first + 1].any()
    assert held[first + 1] == pytest.approx(frame["drift_Z_um"][first], abs=3.0)
    again = replayed(doubting_fmu, run, probing=probing)
    assert again.frame.equals(frame)


def test_probes_come_when_the_uncertainty_asks_for_them(doubting_fmu):
    run = strange("unseen", 9)
    count = []
    usual = 1000.0
    for share in (1.0, 0.95, 0.6):
        limit = share * usual
        found = replayed(doubting_fmu, run, probing=Probing(when_um=limit))
        wide = found.frame[["dX_uncertainty_um", "dZ_uncertainty_um"]].max(axis=1).to_numpy()
        assert (wide[list(found.probes)] > limit).all()
        count.append(len(found.probes))
        if not found.probes:
            usual = float(wide.max())
    assert 0 == count[0] < count[1] < count[2]


def test_the_command_shows_probes_beside_none_and_the_last_one_held(doubting_fmu, tmp_path, prints):
    paths = written(tmp_path, *(strange(name, seed) for name, seed in RUNS))
    out = tmp_path / "results"
    arguments = ["replay", str(doubting_fmu), *paths, "--out", str(out)]
    printed = prints([*arguments, "--probe-every", "30min", "--probe-noise", "0.2um"])
    (left,) = (line for line in printed.splitlines() if line.startswith("RMSE [um]"))
    assert left.count("->") == 5  # one in its heading
    assert left.endswith(" with probes.")
    assert "With a probe" not in printed
    for label in ("Compensated, with probes", "Last probe held"):
        assert printed.count(label) == 3
    assert "monday: 3 probes, 1.5 an hour, at 30, 60, 90 min." in printed
    table = json.loads((out / "table.json").read_text(encoding="utf-8"))
    assert [len(run["probed_s"]) for run in table["runs"]] == [3, 3]
    assert "Last probe held" in (out / "report.html").read_text(encoding="utf-8")
