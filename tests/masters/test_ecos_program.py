"""ecos: a program that is not Python, so the Python library must be brought to it."""

import shutil
import sys
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import pandas as pd
import pytest

from tests.masters.conftest import EXAMPLES, STEP_S, STOP_S, agree, needs, run

pytestmark = needs("ecospy", "tbb")

WANTED = ("error_X", "error_Y", "error_Z", "drift_Z", "T1")
SIX_DIGITS = 5.1e-7
"""[um] The program writes six digits behind the point."""


def table(path: Path) -> pd.DataFrame:
    """Return the program's table with the variables' own names."""
    frame = pd.read_csv(path, skipinitialspace=True)
    frame.columns = [column.partition("[")[0].strip() for column in frame.columns]
    named = {f"plant::{name}": name for name in WANTED}
    named |= {f"compensator::{name}": name for name in ("dX", "dY", "dZ")}
    return frame[["time", *named]].rename(columns=named)


def test_the_ssp(ssp, reference, tmp_path):
    script = EXAMPLES / "ssp_in_ecos.sh"
    done = run("bash", script, ssp, STEP_S, STOP_S, folder=tmp_path, PYTHON=sys.executable)
    assert done.returncode == 0, done.stdout + done.stderr
    agree(table(tmp_path / f"{ssp.stem}.csv"), reference, SIX_DIGITS)


def test_the_ssp_in_c_without_python(ssp, reference, compensator, program, tmp_path):
    if "native" not in compensator.name:
        pytest.skip("its FMUs are in Python")
    path, environment = program
    command = [path, "simulate", "--path", ssp, "--stepSize", STEP_S, "--stopTime", STOP_S]
    done = run(*command, "--parameterSet", "scenario", folder=tmp_path, **environment)
    assert done.returncode == 0, done.stdout + done.stderr
    agree(table(tmp_path / f"{ssp.stem}.csv"), reference, SIX_DIGITS)


@pytest.fixture
def program(tmp_path: Path) -> tuple[Path, dict[str, str]]:
    """The program, marked as one, and the environment in which it finds its library; no Python."""
    spec = find_spec("ecospy")
    path = tmp_path / "ecos"
    shutil.copy(Path(spec.submodule_search_locations[0]) / "binaries" / "ecos", path)
    path.chmod(0o755)
    library = next(file for file in metadata.files("tbb") or () if file.name == "libtbb.so.12")
    folder = Path(str(library.locate())).resolve().parent
    return path, {"LD_LIBRARY_PATH": str(folder), "LD_PRELOAD": ""}


def test_without_the_python_library_the_program_dies(shipped, program, tmp_path):
    path, environment = program
    command = (path, "simulate", "--path", shipped / "compensator.fmu", "--stepSize", 1)
    done = run(*command, folder=tmp_path, **environment)
    assert done.returncode < 0, "docs/embedding.md says otherwise"
    assert not (tmp_path / "compensator.csv").exists()
