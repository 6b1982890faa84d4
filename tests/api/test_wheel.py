"""An installed wheel, far from the checkout, is whole: commands, FMUs, scenarios, the API."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.conftest import ROOMS, ROOT
from tests.running import python

CODE = """
import sys
from pathlib import Path
import spindle_drift as sd
runs = [sd.simulate("jig_borer", "training_down", every_s=60.0, noise_seed=1)]
compensator = sd.fit(runs, model="mlr", machine="jig_borer")
fmu = sd.build_fmu(compensator, "mine", name="mine")
found = sd.run_scenario("step_speed", "out", compensator=fmu, settings={"duration_s": 300})
assert (Path("out") / "report.html").is_file() and len(found.frames) >= 2
here, *own = sys.argv[1:]
for name, module in list(sys.modules.items()):
    if name.partition(".")[0] in own:
        assert module.__file__ is None or module.__file__.startswith(here), module.__file__
assert not {"tests", "docs", "benchmarks", "build_fmu"} & set(sys.modules)
print("version", sd.__version__)
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the wheel holds."""
    work = tmp_path_factory.mktemp("wheel")
    # A copy, so that nothing that an earlier build left in the checkout gets into the wheel.
    source = work / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for room in ROOMS:
        shutil.copytree(ROOT / room, source / room, ignore=shutil.ignore_patterns("__pycache__"))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(work), str(source)], check=True, cwd=work)
    (wheel,) = work.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(work / "site")
    return work / "site"


@pytest.mark.long
def test_it_holds_the_rooms_and_nothing_else(installed):
    tops = {path.name for path in installed.iterdir() if not path.name.endswith(".dist-info")}
    assert tops == set(ROOMS)
    assert (installed / "spindle_drift" / "py.typed").is_file()


@pytest.mark.long
def test_it_fits_builds_an_fmu_and_runs_a_scenario(installed, tmp_path):
    code = ("-c", CODE, str(installed), *ROOMS)
    assert python(*code, folder=tmp_path, path=str(installed)).startswith("version ")
    assert {path.name for path in tmp_path.iterdir()} == {"mine", "out", "dist"}


@pytest.mark.long
def test_its_command_lists_scenarios_and_imports(installed, tmp_path):
    assert "step_speed" in python(
        "-m", "scenarios.cli", "list", folder=tmp_path, path=str(installed)
    )
    (tmp_path / "log.csv").write_text("t [s];T1 [K]\n0;293,15\n1;293,2\n2;293,3\n")
    argv = ["-m", "scenarios.cli", "import", "log.csv", "-o", "runs"]
    assert "log.csv" in python(*argv, folder=tmp_path, path=str(installed))
    assert (tmp_path / "runs" / "log.csv").read_text().splitlines()[1] == "0.0,20.0"


def test_the_licence_in_the_package_is_that_of_the_project():
    copy = ROOT / "fmu_packaging" / "assets" / "LICENSE.txt"
    assert copy.read_text() == (ROOT / "LICENSE").read_text()
