"""ecos: a program that is not Python, so the Python library must be brought to it."""

from __future__ import annotations

import re
import shutil
import sys
from importlib import metadata
from importlib.util import find_spec
from operator import itemgetter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

from tests.masters.conftest import EXAMPLES, STEP_S, STOP_S, agree, needs, run

WANTED = ("error_X", "error_Y", "error_Z", "drift_Z", "T1")
SIX_DIGITS = 5.1e-7
"""[um] The program writes six digits behind the point."""


@pytest.fixture(autouse=True)
def installed() -> None:
    """Skip, or fail, where it is missing."""
    needs("ecospy", "tbb")


def table(path: Path) -> pd.DataFrame:
    """Return the program's table with the variables' own names."""
    frame = pd.read_csv(path, skipinitialspace=True)
    frame.columns = [column.partition("[")[0].strip() for column in frame.columns]
    named = {f"plant::{name}": name for name in WANTED}
    named |= {f"compensator::{name}": name for name in ("dX", "dY", "dZ")}
    return frame[["time", *named]].rename(columns=named)


def test_the_ssp(ssp: Path, reference: pd.DataFrame, tmp_path: Path) -> None:
    script = EXAMPLES / "ssp_in_ecos.sh"
    done = run("bash", script, ssp, STEP_S, STOP_S, folder=tmp_path, PYTHON=sys.executable)
    assert done.returncode == 0, done.stdout + done.stderr
    agree(table(tmp_path / f"{ssp.stem}.csv"), reference, SIX_DIGITS)


def test_the_ssp_in_c_without_python(
    ssp: Path,
    reference: pd.DataFrame,
    compensator: Path,
    program: tuple[Path, dict[str, str]],
    tmp_path: Path,
) -> None:
    if "native" not in compensator.name:
        pytest.skip("its FMUs are in Python")
    path, environment = program
    command = [path, "simulate", "--path", ssp, "--stepSize", STEP_S, "--stopTime", STOP_S]
    done = run(*command, "--parameterSet", "scenario", folder=tmp_path, **environment)
    assert done.returncode == 0, done.stdout + done.stderr
    agree(table(tmp_path / f"{ssp.stem}.csv"), reference, SIX_DIGITS)


def before_texts(path: Path) -> pd.DataFrame:
    """Return the columns before the first text: the program does not quote a comma inside one."""
    head, *rows = (line.split(",") for line in path.read_text().splitlines())
    count = next(place for place, name in enumerate(head) if "[STR]" in name)
    names = [re.sub(r".*::|\[.*", "", name).strip() for name in head[:count]]
    return pd.DataFrame([[float(cell) for cell in row[:count]] for row in rows], columns=names)


@pytest.fixture
def program(tmp_path: Path) -> tuple[Path, dict[str, str]]:
    """The program, marked as one, and the environment in which it finds its library; no Python."""
    spec = find_spec("ecospy")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    path = tmp_path / "ecos"
    shutil.copy(Path(spec.submodule_search_locations[0]) / "binaries" / "ecos", path)
    path.chmod(0o755)
    library = next(file for file in metadata.files("tbb") or () if file.name == "libtbb.so.12")
    folder = Path(str(library.locate())).resolve().parent
    return path, {"LD_LIBRARY_PATH": str(folder), "LD_PRELOAD": ""}


def test_without_the_python_library_the_program_dies(
    shipped: Path, program: tuple[Path, dict[str, str]], tmp_path: Path
) -> None:
    path, environment = program
    command = (path, "simulate", "--path", shipped / "compensator.fmu", "--stepSize", 1)
    done = run(*command, folder=tmp_path, **environment)
    assert done.returncode < 0, "docs/embedding.md says otherwise"
    assert not (tmp_path / "compensator.csv").exists()


def test_the_c_fmu_runs_as_it_is(
    shipped_in_c: Path, program: tuple[Path, dict[str, str]], tmp_path: Path
) -> None:
    path, environment = program
    fmu = shipped_in_c / "compensator_native.fmu"
    rows = [warm(time_s) for time_s in (0.0, 100.0, 300.0)]
    (tmp_path / "warm.xml").write_text(SCENARIO.format(actions="".join(map(action, rows))))
    command = (path, "simulate", "--path", fmu, "--stepSize", 10, "--stopTime", 600)
    done = run(*command, "--scenarioConfig", "warm.xml", folder=tmp_path, **environment)
    assert done.returncode == 0, done.stdout + done.stderr
    found = before_texts(tmp_path / "compensator_native.csv")
    times = np.arange(0.0, 601.0, 10.0)
    held = [
        max((row for row in rows if row["time"] <= time), key=itemgetter("time")) for time in times
    ]
    inputs = pd.DataFrame(held).assign(time=times).to_records(index=False)
    start = {name: value for name, value in rows[0].items() if name != "time"}
    wanted = simulate_fmu(
        str(fmu), stop_time=600.0, output_interval=10.0, input=inputs, start_values=start
    )
    assert abs(wanted["dZ"][-1]) > 1.0
    for name in ("dX", "dY", "dZ", "elongation"):
        assert found[name].to_numpy() == pytest.approx(wanted[name], rel=0, abs=SIX_DIGITS), name


def test_the_plant_in_c_runs_as_it_is(
    shipped_in_c: Path, program: tuple[Path, dict[str, str]], tmp_path: Path
) -> None:
    path, environment = program
    fmu = shipped_in_c / "plant_native.fmu"
    row = {"time": 0.0, "speed": 9000.0, "dZ": 20.0}
    (tmp_path / "warm.xml").write_text(SCENARIO.format(actions=action(row)))
    command = (path, "simulate", "--path", fmu, "--stepSize", 10, "--stopTime", 600)
    done = run(*command, "--scenarioConfig", "warm.xml", folder=tmp_path, **environment)
    assert done.returncode == 0, done.stdout + done.stderr
    head, *rows = (tmp_path / "plant_native.csv").read_text().splitlines()
    names = [re.sub(r".*::|\[.*", "", name).strip() for name in head.split(",")]
    found = pd.DataFrame([map(float, line.split(",")) for line in rows], columns=names)
    start = {name: value for name, value in row.items() if name != "time"}
    outputs = ["T4", "drift_Z", "error_Z", "drift_Y"]
    wanted = simulate_fmu(
        str(fmu), stop_time=600.0, output_interval=10.0, start_values=start, output=outputs
    )
    assert abs(wanted["drift_Z"][-1]) > 1.0
    for name in outputs:
        assert found[name].to_numpy() == pytest.approx(wanted[name], rel=0, abs=SIX_DIGITS), name


SCENARIO = """<?xml version="1.0" encoding="UTF-8"?>
<ecos:Scenario xmlns:ecos="http://github.com/Ecos-platform/libecos/resources/schema/ScenarioConfig">
{actions}</ecos:Scenario>
"""


def warm(time_s: float) -> dict[str, float]:
    """Return the inputs from a time on: every thermometer a little warmer, each by its own rate."""
    readings = {f"T{k}": 20.0 + k * time_s / 1000.0 for k in range(1, 12)}
    return {"time": time_s, **readings, "speed": 6000.0, "tool_length": 150.0}


def action(row: dict[str, float]) -> str:
    """Return the same in the program's own form of a scenario."""
    lines = [
        f'<ecos:variable id="instance::{name}"><ecos:real value="{value}"/></ecos:variable>\n'
        for name, value in row.items()
        if name != "time"
    ]
    return f'<ecos:action t="{row["time"]}" eps="0.01">\n{"".join(lines)}</ecos:action>\n'
