"""The Python API: its names, its examples, and that it gives what the commands give."""

import ast
import doctest
import inspect
import json
import re
import sys
from typing import TypeGuard

import numpy as np
import pandas as pd
import pytest

import spindle_drift as sd
from measurement.runs import write_run
from scenarios.cli import main
from scenarios.fmu_files import build_compensator
from scenarios.replay import model_of, replay, rig_of_model
from spindle_drift._inputs import DoubtfulData, as_runs
from tests.running import output_of

FUNCTIONS = [name for name in sd.__all__ if inspect.isfunction(getattr(sd, name))]
FUNCTIONS += ["Compensator", "Machine"]


def test_a_name_is_imported_from_where_type_checkers_read_it():
    (declared,) = (part for part in ast.parse(inspect.getsource(sd)).body if is_for_checkers(part))
    homes = {
        alias.name: part.module
        for part in declared.body
        if isinstance(part, ast.ImportFrom)
        for alias in part.names
    }
    assert homes == sd._HOME
    for name in sd.__all__:
        assert getattr(sd, name).__module__.startswith(sd._HOME[name]), name
    with pytest.raises(AttributeError, match="no attribute 'fitt'"):
        sd.fitt  # noqa: B018


def is_for_checkers(part: ast.stmt) -> TypeGuard[ast.If]:
    return isinstance(part, ast.If) and ast.unparse(part.test) == "TYPE_CHECKING"


def test_the_import_alone_loads_nothing_heavy():
    code = "import sys, spindle_drift; print(sorted({'numpy', 'pandas', 'scipy'} & {*sys.modules}))"
    assert output_of(sys.executable, "-c", code) == "[]\n"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_name_is_documented_and_typed(name):
    found = getattr(sd, name)
    text = inspect.getdoc(found) or ""
    assert "Parameters\n----------" in text
    assert "Examples\n--------" in text
    for parameter in inspect.signature(found).parameters.values():
        assert parameter.annotation is not inspect.Parameter.empty
        assert re.search(rf"\b{parameter.name}( :|, )|\*\*{parameter.name}", text), parameter.name


SLOW = {"build_fmu", "calibrate", "compare", "find_gap", "fit", "run_scenario"}
"""Whose examples are no matter of a change: what they do is asked elsewhere, of less."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (name in SLOW)) for name in FUNCTIONS]
)
def test_every_example_runs(name, shipped_in_c, tmp_path, monkeypatch):
    (tmp_path / "dist").symlink_to(shipped_in_c)
    monkeypatch.chdir(tmp_path)
    found = getattr(sd, name)
    (case,) = [
        case
        for case in doctest.DocTestFinder(recurse=False).find(found, name, globs={})
        if case.examples
    ]
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    said: list[str] = []
    runner.run(case, out=said.append)
    assert runner.tries >= 2
    assert runner.failures == 0, "".join(said)


@pytest.fixture(scope="module")
def runs() -> list[sd.Run]:
    names = ["training_down", "training_random", "training_stops"]
    return [sd.simulate("jig_borer", name, every_s=60.0, noise_seed=1) for name in names]


@pytest.fixture(scope="module")
def fitted(runs: list[sd.Run]) -> sd.Compensator:
    return sd.fit(runs[:2], model="thermal_states", machine="jig_borer")


def test_frames_paths_and_runs_are_taken_alike(runs, tmp_path):
    path = write_run(runs[0], tmp_path / "training_down.csv")
    found = [sd.summary(given).to_dict() for given in (runs[0], path, str(path))]
    assert found[0] == found[1] == found[2]
    frame = sd.summary(runs[0].frame).to_dict()
    assert frame.pop("name") == "run"
    assert frame.items() <= found[0].items()


def test_what_is_fitted_is_what_the_command_fits(runs, tmp_path):
    paths = [str(write_run(run, tmp_path / f"{run.name}.csv")) for run in runs]
    out = tmp_path / "c.json"
    argv = ["fit", *paths, "--model", "mlr", "--machine", "jig_borer", "-o", str(out)]
    assert main(argv) == 0
    read = [sd.read_run(path) for path in paths]
    ours = sd.fit(read, "mlr", machine="jig_borer").save(tmp_path / "ours.json")
    assert ours.read_text() == out.read_text()
    figures = sd.Compensator.load(out).figures
    assert list(figures.columns) == ["no_model", "training", "like", "unlike", "promised"]
    assert figures["like"].notna().all()
    table = json.loads(out.read_text())
    del table["provenance"]["figures"]["unseen"]["like"]["Z"]
    out.write_text(json.dumps(table))
    figures = sd.Compensator.load(out).figures
    assert list(figures.index[figures["like"].isna()]) == ["Z"]


def test_offsets_are_those_of_the_fmu(fitted, runs, tmp_path):
    file = fitted.save(tmp_path / "c.json")
    fmu = build_compensator(file, tmp_path)
    model = model_of(fmu)
    run = sd.Run("cut", runs[2].frame.iloc[:200])
    theirs = replay(fmu, model, run, rig_of_model(model), 150.0, keep_frozen=True).frame
    ours = fitted.judge(run, tool_length_mm=150.0)
    for name in ours.columns:
        np.testing.assert_allclose(ours[name], theirs[name], atol=1e-9, err_msg=str(name))
    codes = fitted.predict(run, tool_length_mm=150.0)["status_1"]
    np.testing.assert_array_equal(codes, theirs["status_1"])


def test_a_drift_opposite_to_what_was_learnt_is_doubted(fitted, runs):
    frame = runs[2].frame
    moved = {name: -frame[name] for name in frame if str(name).endswith("_um")}
    with pytest.warns(DoubtfulData, match="drifts with the opposite sign .* in run"):
        fitted.judge(frame.assign(**moved))


def test_runs_are_judged_at_one_tool_length(fitted, runs):
    (report,) = fitted.monitor(runs[2]).runs
    judged = fitted.judge(runs[2])
    for error in report.errors:
        drift = judged[f"drift_{error.axis}_um"].to_numpy()
        assert error.none == pytest.approx(np.sqrt(np.nanmean(drift**2)), rel=0.02)
    longer = fitted.judge(runs[2], tool_length_mm=fitted.model.limits.tool_length_mm[1])
    assert longer["drift_Y_um"].abs().max() > 1.1 * judged["drift_Y_um"].abs().max()


def test_a_missing_thermometer_is_refused_and_an_unused_one_is_not(fitted, runs):
    with pytest.raises(sd.BadInput, match=f"column {fitted.used[0]}_degC: is missing"):
        fitted.predict(runs[0].frame.drop(columns=f"{fitted.used[0]}_degC"))
    spare = [name for name in fitted.sensors if name not in fitted.used]
    without = runs[0].frame.drop(columns=[f"{name}_degC" for name in spare])
    pd.testing.assert_frame_equal(fitted.predict(without), fitted.predict(runs[0]))


def test_files_that_are_in_the_way_stay(fitted, tmp_path):
    thesis = tmp_path / "thesis.tex"
    thesis.write_text("mine")
    machine = sd.Machine("jig_borer")
    for save in (fitted.save, machine.save):
        with pytest.raises(sd.BadInput, match="exists and is no"):
            save(thesis)
        with pytest.raises(sd.BadInput, match="does not exist: make it first"):
            save(tmp_path / "new" / "file")
    assert thesis.read_text() == "mine"
    assert fitted.save(thesis, force=True) == thesis
    assert fitted.save(thesis) == thesis  # it is ours by now


def test_a_machine_keeps_what_it_was_given(tmp_path):
    machine = sd.Machine("jig_borer")
    name = str(machine.parameters.index[machine.parameters["calibrate"].fillna(False)][0])
    value = 1.05 * machine.parameters.loc[name, "value"]
    path = machine.with_values({name: value}).save(tmp_path / "m.toml")
    assert sd.Machine(path).parameters.loc[name, "value"] == pytest.approx(value)
    with pytest.raises(sd.BadInput, match="nothing_like_it"):
        machine.with_values({"nothing_like_it": 1.0})
    with pytest.raises(sd.BadInput, match="speed_rpm"):
        sd.simulate(machine, pd.DataFrame({"time_s": [0.0, 1.0]}))
    fast = {"time_s": [0.0, 60.0], "T5_degC": 20.0, "T9_degC": 20.0, "speed_rpm": [0.0, 2e5]}
    with pytest.raises(sd.BadInput, match=r"speed_rpm: 200000 at 60 s is outside 0\.\.20000 rpm"):
        sd.simulate(machine, pd.DataFrame(fast))


def test_a_comparison_is_that_of_the_command(runs, tmp_path, capsys):
    paths = [str(write_run(run, tmp_path / f"{run.name}.csv")) for run in runs]
    options = ["--models", "mlr,ridge", "--json"]
    assert main(["compare", "--train", *paths[:2], "--validate", paths[2], *options]) == 0
    told = json.loads(capsys.readouterr().out)
    found = sd.compare(paths[:2], paths[2:], models=["mlr", "ridge"])
    assert json.loads(json.dumps(found.details))["models"] == told["models"]
    assert found.best in ("mlr", "ridge")
    with pytest.raises(sd.BadInput, match="is the same run as"):
        sd.compare(paths[:2], paths[:1])


def test_runs_of_one_name_are_told_apart_by_their_folders(runs, tmp_path):
    paths = [tmp_path / day / "run.csv" for day in ("mon", "tue")]
    for path, run in zip(paths, runs, strict=False):
        path.parent.mkdir()
        write_run(run, path)
    assert [run.name for run in as_runs(paths)] == ["mon_run", "tue_run"]


def test_an_imported_log_can_be_saved(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("Zeit [min];T1 [°C];p\n0;20,0;1\n1;20,5;1\n2;20,75;1\n", encoding="utf-8")
    found = sd.import_log(log, split="none")
    assert list(found.left_out) == ["p"]
    assert found.table["hours"].tolist() == [2.0 / 60.0]
    (path,) = found.save(tmp_path / "runs")
    assert sd.read_run(path).frame["T1_degC"].tolist() == [20.0, 20.5, 20.75]
    with pytest.raises(sd.BadInput, match="import_log: splitt: is not a known field"):
        sd.import_log(log, splitt="none")


def test_results_can_be_looked_at(fitted, runs, tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    from matplotlib import pyplot

    compared = sd.compare(runs[:2], runs[2:], models=["mlr"])
    judged = fitted.plot(runs[0], machine="jig_borer")
    assert [ax.get_ylabel() for ax in judged.axes] == ["X [µm]", "Y [µm]", "Z [µm]"]
    lines = {line.get_label() for line in judged.axes[0].lines}
    assert lines >= {"No compensation", "Compensated"}
    assert any("interval" in str(label) for label in lines)
    drift = fitted.judge(runs[0], machine="jig_borer")["drift_Z_um"].to_numpy()
    assert judged.axes[2].lines[0].get_ydata().min() == pytest.approx(drift.min())
    bars = compared.plot("elongation").axes[0]
    assert len(bars.get_yticks()) == len(compared.table)
    with pytest.raises(sd.BadInput, match="elongation, yaw"):
        compared.plot("growth")
    table = pd.DataFrame(
        {"time": [0, 60, 120], "T1 [degC]": [20.0, 21.0, 22.0], "x [um]": [0, 1, 2]}
    )
    table.to_csv(tmp_path / "log.csv", index=False)
    log = sd.import_log(tmp_path / "log.csv", units={"time": "s"})
    assert [ax.get_ylabel() for ax in log.plot().axes] == ["temperature [°C]", "displacement [µm]"]
    pyplot.close("all")
