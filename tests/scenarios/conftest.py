"""What the tests of this room share."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.scenarios.tiny_fmus import COMPENSATOR, PLANT, build_tiny


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
