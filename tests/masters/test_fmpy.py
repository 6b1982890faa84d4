"""fmpy, in twenty lines of its own interface instead of this project's loop."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from tests.masters.conftest import agree, example, needs


def test_the_coupled_fmus(
    plant: Path, compensator: Path, signals: Path, reference: pd.DataFrame, tmp_path: Path
) -> None:
    agree(example("in_fmpy.py", plant, compensator, signals, folder=tmp_path), reference)


def test_offsets_that_come_a_step_late_or_early_would_be_noticed(reference: pd.DataFrame) -> None:
    found = reference[["time", "error_X", "error_Y", "error_Z", "drift_Z", "dZ"]]
    agree(found, reference)
    for steps in (-1, 1):
        moved = found.assign(dZ=found["dZ"].shift(steps).bfill().ffill())
        with pytest.raises(AssertionError, match="dZ is off by"):
            agree(moved, reference, tolerance=0.05)


def test_a_missing_master_is_a_failure_in_continuous_integration_only(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    needs("fmpy", "pytest-xdist")
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match="no-such-master is not installed"):
        needs("fmpy", "no-such-master")
    monkeypatch.delenv("CI")
    with pytest.raises(pytest.skip.Exception, match="no-such-master is not installed"):
        needs("no-such-master")
