"""``spindle-drift fit``."""

import argparse
import json
from pathlib import Path

import pytest

from fmu_compensator.runtime.modelfile import load_model
from measurement.runs import Run, write_run
from spindle_drift.commands import fit
from tests.fmu_compensator.conftest import make_run
from tests.refusing import refusal


@pytest.fixture
def run_files(tmp_path: Path) -> list[str]:
    return [
        str(write_run(make_run(name, seed, hours=2.0), tmp_path / f"{name}.csv"))
        for seed, name in enumerate("abc")
    ]


def call(*arguments: str) -> int:
    parser = argparse.ArgumentParser()
    fit.add_arguments(parser)
    return fit.run(parser.parse_args(arguments))


def test_it_writes_a_file_and_says_how_good_it_is(run_files, tmp_path, capsys):
    out = tmp_path / "compensator.json"
    named = ["--created", "2026-01-31", "--name", "mine"]
    assert call(*run_files, "-o", str(out), "--model", "mlr", *named) == 0
    model = load_model(out)
    assert (model.name, model.created, len(model.chosen)) == ("mine", "2026-01-31", 2)
    # Without a machine file, the shipped five-point rig serves runs that have its columns.
    assert model.table["geometry"]["near_to_gauge_mm"] == 30.0
    text = capsys.readouterr().out
    row = next(line for line in text.splitlines() if line.startswith("Z ")).split()
    assert float(row[1]) > 3 > 0.4 > float(row[3]) > 0  # without it, and in runs left out
    assert text.startswith("promise, from 3 runs and 3 conditions left out: X ")
    assert "share of samples in the 90 % interval, worst axis: like " in text
    assert f"wrote {out}" in text


@pytest.mark.parametrize(("machine", "told"), [([], True), (["--machine", "jig_borer"], False)])
def test_a_rig_that_nobody_described_is_told(machine, told, run_files, tmp_path, capsys):
    said = "S1, S2 30 mm outside the gauge line, S3, S4 100 mm further out, S5 towards +Z"
    out = tmp_path / "compensator.json"
    assert call(*run_files[:2], *machine, "--points", "T1,T4", "-o", str(out)) == 0
    assert (said in capsys.readouterr().out) is told
    # A machine says which sensors count; here all have a column.
    assert [sensor.name for sensor in load_model(out).sensors] == ["T1", "T2", "T3", "T4"]


def test_few_runs_without_a_model_promise_nothing(run_files, tmp_path, capsys):
    out = tmp_path / "c.json"
    assert call(*run_files[:2], "-o", str(out), "--share", "0.7", "--lambda", "0.99") == 0
    assert "no promise for other runs: " in capsys.readouterr().out
    model = load_model(out)
    assert model.provenance["figures"]["unseen"] is None
    assert model.table["error_model"]["kind"] == "gaussian"  # it stands alone
    assert model.limits.share == 0.7


def test_the_figures_as_json(run_files, tmp_path, capsys):
    out = tmp_path / "c.json"
    usual = ["-o", str(out), "--model", "mlr", "--json"]
    call(*run_files, *usual, "--points", "T4,T1", "--input-form", "absolute")
    shown = json.loads(capsys.readouterr().out)
    assert shown["chosen"] == ["T4", "T1"]
    assert shown["figures"]["unseen"]["like"]["X"]["model"] > 0
    assert load_model(out).input_form == "absolute"


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--points", "T9"], "T9"),
        (["--machine", "no_such_machine"], "no_such_machine"),
        (["--option", "hidden=3"], "--model"),
    ],
)
def test_a_refusal_writes_nothing(run_files, tmp_path, options, told):
    out = tmp_path / "c.json"
    assert told in refusal(call, *run_files, "-o", str(out), *options)
    assert not out.exists()


@pytest.mark.parametrize("name", ["speed", "dZ", "time", "measured_elongation"])
def test_a_thermometer_with_a_name_that_the_fmu_needs_is_refused(name, tmp_path):
    runs = [make_run(run, seed, hours=2.0) for seed, run in enumerate("ab")]
    files = [
        str(
            write_run(
                Run(run.name, run.frame.rename(columns={"T2_degC": f"{name}_degC"})),
                tmp_path / f"{run.name}.csv",
            )
        )
        for run in runs
    ]
    out = tmp_path / "c.json"
    said = refusal(call, *files, "--model", "mlr", "-o", str(out))
    assert f"rename the column in all runs, e.g. {name}_1_degC" in said
    assert not out.exists()
