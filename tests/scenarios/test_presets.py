"""The studies' ways as presets of `points`, `fit`, `compare` and the API."""

import json
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import spindle_drift as sd
from fmu_compensator.runtime.modelfile import load_model
from measurement.runs import Run
from scenarios.presets import EQUATION_8, PRESETS, TRAINED
from studies.finite_elements import read_description
from studies.finite_elements.films import turning_film
from studies.fit.ne import time_constant
from tests.fmu_compensator.conftest import make_run
from tests.scenarios.conftest import written

QUICK = ["--option", "iterations=3", "--option", "population=6", "--option", "generations=2"]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    made = [make_run(name, seed, hours=2.0) for seed, name in enumerate("ab")]
    return written(tmp_path_factory.mktemp("runs"), *made)


@pytest.fixture
def fitted(runs: list[str], tmp_path: Path, prints: Any) -> Callable[..., tuple[dict, str]]:
    """Fits a compensator with options; returns its file's table and what the command prints."""

    def made(*more: str, of: list[str] = runs) -> tuple[dict, str]:
        out = tmp_path / "c.json"
        text = prints(["fit", *of, "-o", str(out), *more])
        return load_model(out).table, text

    return made


def test_points_as_a_study_has_them_keep_the_air_and_say_what_the_api_says(runs, prints):
    found = json.loads(prints(["points", runs[0], "--as", "ts", "--json"]))
    assert found == sd.points(runs[0], study="TS").details
    # T3 does not move. The study's way takes it in; ours does not.
    assert found["points"] == ["T1", "T2", "T3", "T4"]
    assert "T3" not in sd.points(runs[0], clusters=2).scores.index
    named = sd.points(runs[0], grouping="T1,T4", clusters=2)
    assert named.chosen == ["T1", "T4"]
    assert len(named.combinations) == 3


@pytest.mark.usefixtures("drawn")
@pytest.mark.long
def test_the_time_series_study_says_order_tests_and_correlations(fitted, tmp_path):
    figures = ["--out", str(tmp_path / "figures")]
    table, text = fitted("--as", "TS", "--option", "order=1", *figures)
    assert table["error_model"]["kind"] == "arma"
    assert table["geometry"]["form"] == "pure_rotation"
    assert "elongation: ARMA(" in text
    for said in ("ADF p of each difference", "ACF from lag 1", "PACF from lag 1"):
        assert said in text
    assert "of them arma, the mean function, uses none" in text
    assert (tmp_path / "figures" / "correlations.png").stat().st_size > 10_000


@pytest.mark.long
def test_the_hybrid_study_says_weights_and_what_its_parts_found(fitted):
    _, text = fitted("--as", "VAC", "--points", "T1,T4")
    tau = time_constant(**EQUATION_8)
    for said in (
        "weights, steady, elongation: mlr ",
        f"ne: time constant turning [s]: elongation {tau:.0f}",
        "mlr: condition number ",
        "fem: factors on what the finite elements start from: ",
    ):
        assert said in text


def test_an_option_after_a_preset_overrides_and_another_model_has_its_own_options(fitted):
    table, text = fitted("--as", "TS", "--model", "mlr", "--points", "T1,T4")
    assert (table["error_model"]["kind"], table["chosen"]) == ("mlr", ["T1", "T4"])
    assert "variance inflation: T1 " in text
    assert ", T4 " in text


def test_each_model_of_a_study_has_the_study_s_options(fitted):
    points = ["--points", "T1,T4", "--option", "iterations=3"]
    table, _ = fitted("--as", "TS", "--model", "bp", *points)
    options = table["provenance"]["options"]
    assert (options["hidden"], options["decay"]) == ([5, 5], 0.0)


def test_the_network_study_trains_without_decay_on_points_chosen_its_way(fitted):
    table, text = fitted("--as", "GA", *QUICK)
    options = table["provenance"]["options"]
    assert options["decay"] == TRAINED["decay"] == 0.0
    assert options["hidden"] == 10
    assert (options["image"], options["score"]) == ("mean", "relational")
    assert "-10-" in next(line for line in text.splitlines() if "network" in line)


def test_a_comparison_takes_options_of_models_and_of_the_choice(runs, prints, refused):
    given = ["compare", "--train", runs[0], "--validate", runs[1], "--as", "TS", "--json"]
    quick = ["--models", "mlr,bp", "--option", "bp.iterations=3", "--option", "bp.hidden=[4]"]
    found = json.loads(prints([*given, *quick]))
    kinds = {one["name"] for one in found["models"]}
    assert {"mlr", "bp", "no_model"} <= kinds
    assert "fem" in refused([*given, "--option", "fem.identify=false"])


def test_what_is_no_study_is_refused_in_one_line(runs, refused):
    assert "--as: invalid choice: 'XY' (choose from" in refused(["points", *runs, "--as", "XY"])
    with pytest.raises(sd.BadInput, match="study: 'XY' is not allowed: GA, TS, VAC"):
        sd.points(runs[0], study="XY")


@pytest.fixture(scope="module")
def lathe_runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Runs without a tilt, whose first displacement is not the one along the spindle."""
    time = np.arange(0.0, 7200.0, 60.0)
    made = []
    for seed, name in enumerate("ab"):
        random = np.random.default_rng(seed)
        rises = [(k + 1.0) * (1.0 - np.exp(-time / 600.0 / (k + 1.0))) for k in range(5)]
        noise = random.normal(0.0, 0.02, (5, len(time)))
        columns = {f"T{k + 1}_degC": 20.0 + rise + noise[k] for k, rise in enumerate(rises)}
        frame = pd.DataFrame({"time_s": time, "speed_rpm": 2000.0, **columns})
        frame["disp_x_um"] = -rises[1] + noise[0]
        frame["disp_z_um"] = 5.0 * rises[3] + noise[1]
        made.append(Run(name, frame))
    return written(tmp_path_factory.mktemp("lathe"), *made)


@pytest.mark.long
@pytest.mark.parametrize("study", ["GA", "TS"])
def test_a_study_scores_by_what_grows_along_the_spindle_where_there_is_no_tilt(
    lathe_runs, fitted, study
):
    assert sd.points(lathe_runs, study=study).survey.target == "disp_z"
    assert sd.points(lathe_runs).survey.target == "disp_z"
    quick = QUICK if study == "GA" else ["--option", "order=1"]
    table, _ = fitted("--as", study, *quick, of=lathe_runs)
    assert table["provenance"]["options"]["target"] == "growth"


def test_what_a_study_takes_by_name_is_asked_for_where_it_is_not_recorded(tmp_path, refused):
    (path,) = written(tmp_path, make_run("a", 0, hours=1.0))
    words = "front bearing, rear bearing and air: name yours"
    for command in (["fit", path, "-o", str(tmp_path / "c.json")], ["points", path]):
        assert words in refused([*command, "--as", "VAC"])
    for refused in (sd.fit, sd.points):
        with pytest.raises(sd.BadInput, match=words):
            refused(path, study="VAC")
    with pytest.raises(sd.BadInput, match=words):
        sd.compare([path], study="VAC")


def test_pure_rotation_says_what_it_leaves_out(fitted):
    left_out = "pure rotation leaves out the radial drift at the gauge line: RMS X "
    assert left_out in fitted("--model", "mlr", "--form", "pure_rotation")[1]
    assert left_out not in fitted("--model", "mlr")[1]


@pytest.mark.usefixtures("drawn")
def test_a_network_draws_its_convergence_and_a_regression_says_that_it_draws_nothing(
    fitted, tmp_path
):
    quick = ["--option", "iterations=3", "--option", "hidden=4"]
    _, text = fitted("--model", "bp", *quick, "--out", str(tmp_path / "bp"))
    assert (tmp_path / "bp" / "convergence.png").stat().st_size > 10_000
    assert "-4-5, 3 iterations" in text
    _, text = fitted("--model", "mlr", "--out", str(tmp_path / "mlr"))
    assert "nothing to draw" in text
    assert not (tmp_path / "mlr").exists()


def test_points_of_one_run_say_what_they_cannot_and_refuse_an_unknown_option(runs, prints):
    told = prints(["points", runs[0], "--clusters", "2"])
    assert "nan" not in told
    assert "needs a second run" in told
    assert "[um/K]" in told
    with pytest.raises(sd.BadInput, match="points: lamda: is not a known option: threshold, "):
        sd.points(runs[0], lamda=0.9)
    with pytest.raises(sd.BadInput, match=r"points: threshold: .* float is needed"):
        sd.points(runs[0], threshold="0.9")


def test_points_of_thermometers_that_all_stand_still_are_refused():
    run = make_run("a", 0, hours=1.0)
    still = run.frame.assign(**dict.fromkeys(run.temperatures, 21.0))
    with pytest.raises(sd.BadInput, match=r"runs: 0 temperatures move by .* K: 2 or more"):
        sd.points(still)


def test_equation_8_is_of_the_turning_parts_of_the_finite_elements():
    spindle = read_description("jig_borer")
    parts = {part.name: part for part in spindle.parts}
    mass = heat = 0.0
    for name in ("shaft", "nose", "rotor"):
        part, material = parts[name], spindle.materials[parts[name].material]
        ring = pi * (part.r[1] ** 2 - part.r[0] ** 2) * (part.z[1] - part.z[0]) * 1e-9
        mass += ring * material.density
        heat += ring * material.density * material.specific_heat
    (bore, shaft), nose, rotor = parts["shaft"].r, parts["nose"], parts["rotor"]
    long = [part.z[1] - part.z[0] for part in (parts["shaft"], nose, rotor)]
    outside = 2 * pi * (shaft * (long[0] - long[1] - long[2]) + nose.r[1] * long[1])
    outside += 2 * pi * rotor.r[1] * long[2]
    ends = pi * (nose.r[1] ** 2 - bore**2 + shaft**2 - bore**2)
    reckoned = {
        "mass_kg": mass,
        "specific_heat": heat / mass,
        "film": turning_film(8000.0, 2e-3 * shaft),
        "surface_m2": 1e-6 * (outside + ends),
    }
    assert pytest.approx(reckoned, rel=0.01) == EQUATION_8
    assert PRESETS["VAC"].models["vac"]["parts"]["ne"]["mass_kg"] == EQUATION_8["mass_kg"]
