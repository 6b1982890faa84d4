"""What the tests of this room share."""

import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from measurement.runs import Run, write_run
from scenarios.cli import main
from scenarios.cosimulation import simulate
from scenarios.recording import Recording
from scenarios.scenario import read_scenario
from scenarios.sweep.plan import Request
from scenarios.sweep.runner import run_sweep
from tests.running import cannot_run
from tests.scenarios.tiny_fmus import COMPENSATOR, PLANT, build_tiny


def names(folder: Path) -> list[str]:
    """Return what is in a folder, in order."""
    return sorted(path.name for path in folder.iterdir())


def written(folder: Path, *runs: Run) -> list[str]:
    """Write runs under their names, and return their files as a command line takes them."""
    return [str(write_run(run, folder / f"{run.name}.csv")) for run in runs]


FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


@pytest.fixture(scope="session")
def tiny_plant(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small plant FMU."""
    return build_tiny(PLANT, "TinyPlant", tmp_path_factory.mktemp("tiny_plant"))


@pytest.fixture(scope="session")
def tiny_compensator(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small compensator FMU."""
    return build_tiny(COMPENSATOR, "TinyCompensator", tmp_path_factory.mktemp("tiny_compensator"))


TINY = """
format = 1
name = "tiny"
title = "A tiny scenario"
duration_s = 20
record_s = 1

[signals]
speed = { kind = "steps", times_s = [0, 10], values = [1000, 2000] }
tool_length = 100.0
"""


MISSING = '\n[[faults]]\nsensor = "T1"\nkind = "missing"\nstart_s = 5\nend_s = 8\n'


@pytest.fixture
def tiny_scenario(tmp_path: Path) -> Path:
    """A scenario file for the small FMUs."""
    path = tmp_path / "tiny.toml"
    path.write_text(TINY, encoding="utf-8")
    return path


@pytest.fixture
def tiny_folder(tmp_path: Path, tiny_plant: Path, tiny_compensator: Path) -> Path:
    """A folder with the small FMUs under the usual names."""
    folder = tmp_path / "fmus"
    folder.mkdir()
    shutil.copy(tiny_plant, folder / "plant.fmu")
    shutil.copy(tiny_compensator, folder / "compensator.fmu")
    return folder


@pytest.fixture
def simulated(tiny_scenario: Path, tiny_plant: Path, tiny_compensator: Path) -> Any:
    """Simulates the tiny scenario with some text added to its file and some keys set."""

    def made(
        *overrides: tuple[str, Any],
        more: str = "",
        plant: Path = tiny_plant,
        compensator: Path | None = tiny_compensator,
    ) -> Recording:
        tiny_scenario.write_text(tiny_scenario.read_text() + more)
        (case,) = read_scenario(tiny_scenario, overrides).cases
        return simulate(case, plant, compensator, quiet=True)

    return made


@pytest.fixture
def sweep(tiny_scenario: Path, tiny_folder: Path, tmp_path: Path) -> Any:
    """Sweeps the tiny scenario into a folder, by what varies and more of a request."""

    def run(
        out: str, *vary: str, workers: int | None = 1, cluster: str | None = None, **more: Any
    ) -> dict[str, Any]:
        request = Request(str(tiny_scenario), vary, **more)
        where = {"workers": workers, "cluster": cluster}
        return run_sweep(request, tmp_path / out, tiny_folder, **where, quiet=True)

    return run


@pytest.fixture
def prints(capsys: pytest.CaptureFixture[str]) -> Callable[[list[str]], str]:
    """Runs a command that must succeed, and returns what it prints."""

    def text_of(argv: list[str]) -> str:
        capsys.readouterr()
        assert main(argv) == 0
        return capsys.readouterr().out

    return text_of


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Callable[[list[str]], str]:
    """Runs a command that must end with exit code 2, and returns the one line that it says."""

    def line_of(argv: list[str]) -> str:
        capsys.readouterr()
        assert main(argv) == 2
        (line,) = capsys.readouterr().err.splitlines()
        return line

    return line_of


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Headless Chromium; absent it is a skip, on a build server a failure."""
    binary = shutil.which("chromium") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if binary is None or driver is None:
        cannot_run("chromium and chromedriver are not installed")
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = binary
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        session = webdriver.Chrome(options=options, service=Service(driver))
        yield session
        session.quit()
