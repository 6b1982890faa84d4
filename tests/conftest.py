"""What several rooms' tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SHARED_DATA = ROOT.parent / "shared" / "data"


@pytest.fixture(scope="session")
def lathe_runs() -> list[Path]:
    """The measured lathe runs, in order of date."""
    runs = sorted(path for path in (SHARED_DATA / "lathe").glob("2*.csv"))
    if not runs:
        pytest.skip("the measured lathe runs are not beside this checkout")
    return runs


@pytest.fixture(scope="session")
def electric_spindle_run() -> Path:
    """The measured record of an electric spindle."""
    path = SHARED_DATA / "electric_spindle" / "first_3000_min.csv"
    if not path.is_file():
        pytest.skip("the measured electric spindle record is not beside this checkout")
    return path
