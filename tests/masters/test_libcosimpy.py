"""libcosimpy: the Open Simulation Platform's co-simulation library."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from tests.masters.conftest import STOP_S, agree, example, needs


@pytest.fixture(autouse=True)
def installed() -> None:
    """Skip, or fail, where it is missing."""
    needs("libcosimpy")


def test_the_coupled_fmus(
    plant: Path, compensator: Path, signals: Path, reference: pd.DataFrame, tmp_path: Path
) -> None:
    agree(example("in_libcosimpy.py", plant, compensator, signals, folder=tmp_path), reference)


def test_the_ssp(ssp: Path, reference: pd.DataFrame, tmp_path: Path) -> None:
    agree(example("ssp_in_libcosimpy.py", ssp, STOP_S, folder=tmp_path), reference)
