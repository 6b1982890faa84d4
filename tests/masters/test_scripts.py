"""The scripts of docs/examples, a master each: all give what this project's loop gives."""

import re
import shutil
import sys

import fmpy
import pytest
from fmpy.validation import validate_fmu

from scenarios.cli import main
from scenarios.wiring import PROBED
from tests.conftest import ROOT
from tests.masters.conftest import (
    INPUTS,
    SCENARIO,
    SETTINGS,
    STEP_S,
    STOP_S,
    TOLERANCE,
    VARIANT,
    agree,
    example,
    needs,
    run,
)

ecos, cosim = needs("ecospy", "tbb"), needs("libcosimpy")


@pytest.mark.parametrize(
    "script",
    [
        "in_fmpy.py",
        pytest.param("in_ecospy.py", marks=ecos),
        pytest.param("in_libcosimpy.py", marks=cosim),
    ],
)
def test_the_coupled_fmus(script, plant, compensator, signals, reference, tmp_path):
    agree(example(script, plant, compensator, signals, folder=tmp_path), reference)


@needs("fmu-manipulation-toolbox")
def test_both_nested_into_one(plant, compensator, signals, reference, tmp_path):
    agree(example("in_one_fmu.py", plant, compensator, signals, folder=tmp_path), reference)
    machine = str(tmp_path / "machine.fmu")
    assert validate_fmu(machine) == []
    variables = fmpy.read_model_description(machine).modelVariables
    inputs = {variable.name for variable in variables if variable.causality == "input"}
    # What a probe measures, now and then, stays open as well.
    assert {name for name in inputs if not name.startswith(PROBED)} == {*INPUTS, "torque"}


@ecos
@pytest.mark.long
def test_the_coupled_fmus_in_fmi_3(shipped_in_fmi3, compensator, signals, reference, tmp_path):
    if "native" not in compensator.name:
        pytest.skip("only FMUs in C have FMI 3.0")
    in_fmi3 = [shipped_in_fmi3 / f"{kind}_native_fmi3.fmu" for kind in ("plant", "compensator")]
    agree(example("in_ecospy.py", *in_fmi3, signals, folder=tmp_path), reference)


@pytest.mark.parametrize(
    ("script", "times"),
    [
        pytest.param("ssp_in_ecospy.py", (STEP_S, STOP_S), marks=ecos),
        pytest.param("ssp_in_libcosimpy.py", (STOP_S,), marks=cosim),
    ],
)
def test_the_ssp(script, times, ssp, reference, tmp_path):
    agree(example(script, ssp, *times, folder=tmp_path), reference)


def test_an_ssp_of_version_2(shipped_in_fmi3, reference, tmp_path):
    out = tmp_path / "two.ssp"
    fmus = [
        f"--{role}={shipped_in_fmi3}/{role}_native_fmi3.fmu" for role in ("plant", "compensator")
    ]
    settings = [f"--set={key}={value}" for key, value in SETTINGS.items()]
    arguments = ["ssp", SCENARIO, "--ssp", "2", "--variant", VARIANT, "-o", str(out)]
    assert main([*arguments, *fmus, *settings]) == 0
    agree(example("ssp_in_fmpy.py", out, STEP_S, STOP_S, folder=tmp_path), reference)


@cosim
def test_the_lines_of_the_page(ssp, reference, tmp_path):
    page = (ROOT / "docs" / "embedding.md").read_text(encoding="utf-8")
    (lines,) = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    shutil.copy(ssp, tmp_path / "step_speed.ssp")
    done = run(sys.executable, "-c", lines, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    # Among lines of the library's log.
    (found,) = re.findall(r"^\[(-?[\d.e-]+)\]$", done.stdout, re.MULTILINE)
    (wanted,) = reference.loc[reference["time"] == 3600.0, "error_Z"]
    assert float(found) == pytest.approx(wanted, abs=TOLERANCE)
