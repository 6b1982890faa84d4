"""The benchmark of broken sensors counts what it says it counts."""

import numpy as np
import pytest

from benchmarks.sensor_faults import run as benchmark
from benchmarks.sensor_faults.breaking import BREAKAGES, planted
from measurement.faults import Fault
from tests.measurement.faults.test_broken import SOUND


@pytest.mark.parametrize("how", BREAKAGES, ids=lambda how: how.name)
def test_every_breakage_changes_its_span_alone(how):
    column = "T6_degC" if how.unit == "degC" else "disp_z_um"
    broken, (start, end) = planted(SOUND, column, how, np.random.default_rng(3))
    changed = (broken.frame[column] != SOUND.frame[column]).to_numpy()
    assert changed.any()
    assert ((SOUND.time_s[changed] >= start) & (SOUND.time_s[changed] <= end)).all()
    assert broken.frame.drop(columns=column).equals(SOUND.frame.drop(columns=column))


def test_a_fault_counts_as_found_where_it_covers_half_of_the_span():
    def found(start: float, end: float, column: str = "T1_degC") -> tuple[bool, float]:
        fault = Fault("r", column, "frozen", start, end, "")
        return benchmark.judge([fault], 0, "T1_degC", (600.0, 1800.0))

    assert found(600.0, 1800.0) == (True, 0.0)
    assert found(0.0, 1800.0) == (True, 10.0)
    assert found(600.0, 1000.0)[0] is False
    assert found(600.0, 1800.0, "T2_degC")[0] is False
    assert found(1900.0, 2800.0)[0] is False


def test_the_command_counts(capsys, monkeypatch):
    few = tuple(how for how in BREAKAGES if how.name in ("level +30 K", "step +10 um"))
    monkeypatch.setattr(benchmark, "BREAKAGES", few)
    assert benchmark.main(["setting", "--cases", "1"]) == 0
    shown = capsys.readouterr().out
    assert "| Planted, share found | simulated jig borer, alone |" in shown
    assert "| step +10 um | 0/1 (" in shown
    assert "| level +30 K | 1/1 (1/1) |" in shown
