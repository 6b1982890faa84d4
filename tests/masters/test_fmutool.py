"""fmutool of the fmu-manipulation-toolbox: schema and rules that no schema can express."""

import sys
from pathlib import Path

import pytest

from tests.masters.conftest import needs, run

pytestmark = needs("fmu-manipulation-toolbox")

CLEAN = "No semantic error against the FMI-"
KINDS = ("compensator", "plant")


def said(fmu: Path, folder: Path) -> tuple[str, list[str]]:
    """Return all that the checker says, and its complaints."""
    program = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"
    done = run(sys.executable, "-c", program, "-input", fmu, "-check", folder=folder)
    text = done.stdout + done.stderr
    return text, [line for line in text.splitlines() if line.startswith(("ERROR", "WARNING"))]


@pytest.mark.long
def test_every_fmu_keeps_the_rules(shipped_in_c, shipped_in_fmi3, tmp_path):
    forms = ((shipped_in_c, ""), (shipped_in_c, "_native"), (shipped_in_fmi3, "_native_fmi3"))
    for fmu in (folder / f"{kind}{form}.fmu" for kind in KINDS for folder, form in forms):
        text, complaints = said(fmu, tmp_path)
        assert not complaints, fmu
        version = 3 if "fmi3" in fmu.name else 2
        assert f"{CLEAN}{version} standard" in text, text
        assert f"compliant with FMI-{version}.0" in text, text
