"""fmpy, in twenty lines of its own interface instead of this project's loop."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from tests.masters.conftest import agree, example


def test_the_coupled_fmus(
    plant: Path, compensator: Path, signals: Path, reference: pd.DataFrame, tmp_path: Path
) -> None:
    agree(example("in_fmpy.py", plant, compensator, signals, folder=tmp_path), reference)
