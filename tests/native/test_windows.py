"""The binary for Windows, run by Wine, beside the one for Linux."""

import os
import shutil
import subprocess
import zipfile
from collections.abc import Sequence
from pathlib import Path
from random import Random

import fmpy
import pytest

import build_fmu
from fmu_compensator.runtime.modelfile import model_text
from fmu_packaging.native.build import HEADERS
from fmu_packaging.native.compilers import FOR_WINDOWS, STRICT, run_compiler
from tests.fmus.models import five_point_table
from tests.native.made import gaussian
from tests.patience import PATIENCE_S

HOST = Path(__file__).with_name("printing_host.c")
DEBIAN = "/usr/lib/wine"  # where Debian's package puts the program, out of the way


@pytest.fixture(scope="module")
def wine(every_compiler: None) -> str:
    """The program that runs programs for Windows."""
    found = shutil.which("wine64", path=os.pathsep.join([os.environ["PATH"], DEBIAN]))
    problem = "" if found else "wine64 is not there"
    if shutil.which(FOR_WINDOWS) is None:
        problem = f"{FOR_WINDOWS} is not there"
    if problem:
        pytest.fail(problem) if os.environ.get("CI") else pytest.skip(problem)
    return str(found)


def model_of_the_host(folder: Path) -> Path:
    """Write the compensator file whose variables the host knows, and return its path."""
    path = folder / "by_hand.json"
    random = gaussian(Random("any host"), 2, 5, fixed=False)
    path.write_text(model_text(five_point_table() | {"gaussian": random}))
    return path


@pytest.mark.long
def test_windows_gives_the_numbers_and_words_of_linux(wine, compiler, tmp_path):
    model = model_of_the_host(tmp_path)
    assert (
        build_fmu.main(
            ["--native", "--only", "compensator", "--model", str(model), "--out", str(tmp_path)]
        )
        == 0
    )
    path = tmp_path / "compensator_native.fmu"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    guid = fmpy.read_model_description(str(path)).guid
    common = [*STRICT, f"-I{HEADERS}", str(HOST)]
    run_compiler([*compiler, *common, "-o", "host", "-ldl", "-lm"], tmp_path)
    run_compiler([FOR_WINDOWS, *common, "-D__USE_MINGW_ANSI_STDIO=1", "-o", "host.exe"], tmp_path)
    environment = {**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    binaries = tmp_path / "binaries"
    linux, windows = (
        subprocess.run(
            [*command, guid],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=True,
        ).stdout.splitlines()
        for command in (
            ["./host", str(binaries / "linux64" / "compensator_native.so")],
            [wine, "host.exe", "binaries/win64/compensator_native.dll"],
        )
    )
    same_lines(linux, windows)


def same_lines(here: Sequence[str], there: Sequence[str]) -> None:
    """Check what the host prints on two platforms: the same words, and nearly the same numbers."""
    assert len(here) == 300
    assert any("T4 is missing" in line for line in here)
    assert any("conditions outside training make" in line for line in here)
    for one, other in zip(here, there, strict=True):
        assert one.split(" ", 10)[10] == other.split(" ", 10)[10]
        numbers = [[float(word) for word in line.split(" ", 10)[:10]] for line in (one, other)]
        assert numbers[1] == pytest.approx(numbers[0], rel=1e-12, abs=1e-12)
