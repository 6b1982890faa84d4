"""libcosimpy: the Open Simulation Platform's co-simulation library."""

import re
import shutil
import sys

import pytest

from tests.conftest import ROOT
from tests.masters.conftest import STOP_S, TOLERANCE, agree, example, needs, run


@pytest.fixture(autouse=True)
def installed() -> None:
    """Skip, or fail, where it is missing."""
    needs("libcosimpy")


def test_the_coupled_fmus(plant, compensator, signals, reference, tmp_path):
    agree(example("in_libcosimpy.py", plant, compensator, signals, folder=tmp_path), reference)


def test_the_ssp(ssp, reference, tmp_path):
    agree(example("ssp_in_libcosimpy.py", ssp, STOP_S, folder=tmp_path), reference)


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
