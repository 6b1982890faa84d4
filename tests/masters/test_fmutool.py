"""fmutool of the fmu-manipulation-toolbox: schema and rules that no schema can express."""

from __future__ import annotations

import io
import sys
import zipfile
from pathlib import Path

import pytest

from tests.masters.conftest import native_fmu, needs, run

CLEAN = "No semantic error against the FMI-"
KINDS = ("compensator", "plant")


@pytest.fixture(autouse=True)
def installed() -> None:
    """Skip, or fail, where it is missing."""
    needs("fmu-manipulation-toolbox")


def said(fmu: Path, folder: Path) -> tuple[str, list[str]]:
    """Return all that the checker says, and its complaints."""
    program = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"
    done = run(sys.executable, "-c", program, "-input", fmu, "-check", folder=folder)
    text = done.stdout + done.stderr
    return text, [line for line in text.splitlines() if line.startswith(("ERROR", "WARNING"))]


def test_every_fmu_keeps_the_rules(fmus: Path, in_fmi3: tuple[Path, Path], tmp_path: Path) -> None:
    python = [fmus / f"{kind}.fmu" for kind in KINDS]
    for fmu in (*python, *(native_fmu(fmus, kind) for kind in KINDS), *in_fmi3):
        text, complaints = said(fmu, tmp_path)
        assert not complaints, fmu
        version = 3 if "fmi3" in fmu.name else 2
        assert f"{CLEAN}{version} standard" in text, text
        assert f"compliant with FMI-{version}.0" in text, text


def test_a_broken_rule_is_found(fmus: Path, tmp_path: Path) -> None:
    stream = io.BytesIO()
    fmu = fmus / "plant.fmu"
    with zipfile.ZipFile(fmu) as whole, zipfile.ZipFile(stream, "w") as broken:
        for name in whole.namelist():
            data = whole.read(name)
            if name == "modelDescription.xml":
                assert data.count(b'name="drift_Z"') == 1
                data = data.replace(b'name="drift_Z"', b'name="drift_Y"')
            broken.writestr(name, data)
    other = tmp_path / "broken.fmu"
    other.write_bytes(stream.getvalue())
    text, complaints = said(other, tmp_path)
    assert CLEAN not in text
    assert any("drift_Y" in line for line in complaints)
