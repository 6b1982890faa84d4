"""What the tests of this room share."""

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from scenarios.cli import main
from tests.scenarios.tiny_fmus import COMPENSATOR, PLANT, build_tiny

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
        problem = "chromium and chromedriver are not installed"
        pytest.fail(problem) if os.environ.get("CI") else pytest.skip(problem)
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
