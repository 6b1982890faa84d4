"""Compensator files and runs that the tests of this room share."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.rig import POSE, DirectRig, FivePointRig
from measurement.runs import Run
from tests.five_point import readings_of
from tests.fmu_compensator.gaussians import knows_nothing
from tests.fmu_compensator.models.made import lag
from tests.fmus import models


@pytest.fixture
def five_point_table() -> dict[str, Any]:
    """A compensator with a five-point rig: four sensors, of which T1 and T4 are used."""
    table = models.five_point_table(sensors=4)
    for sensor in table["sensors"]:
        sensor |= {"low": 0.0, "high": 80.0, "rate_per_s": 0.01, "stale_after_s": 600.0}
        sensor |= {"trained_low": -1.0}
    coefficients = [[2.0, 1.0], [5.0, 0.0], [0.0, -4.0], [0.5, 0.0], [0.0, 0.25]]
    limits = {"offset_um": 30.0, "hold_s": 20.0, "tool_length_mm": [0.0, 200.0]}
    runs = [{"name": "a", "sha256": "0" * 64, "rows": 10}]
    return table | {
        "created": "2026-01-31",
        "chosen": ["T4", "T1"],
        "error_model": table["error_model"] | {"coefficients": coefficients},
        "limits": table["limits"] | limits,
        "gaussian": knows_nothing(5),
        "provenance": table["provenance"] | {"runs": runs, "notes": ["nothing left out"]},
    }


@pytest.fixture
def direct_table(five_point_table: dict[str, Any]) -> dict[str, Any]:
    """A compensator with one displacement column each for X and Z."""
    axes = {"disp_x": {"axis": "X", "sign": 1}, "disp_z": {"axis": "Z", "sign": -1}}
    numbers = {"intercept": [0.0, 0.0], "coefficients": [[1.0, 0.0], [0.0, 3.0]]}
    return five_point_table | {
        "geometry": {"kind": "direct", "axes": axes},
        "error_model": {"kind": "mlr", "targets": ["disp_x", "disp_z"], **numbers},
        "gaussian": knows_nothing(2),
    }


@pytest.fixture
def as_model() -> Callable[[dict[str, Any]], Model]:
    """Turns a table into a model, through text as a file would."""
    return lambda table: parse_model(json.dumps(table), "test.json")


RIG = FivePointRig(spacing_mm=100.0, near_to_gauge_mm=30.0)
DIRECT_RIG = DirectRig.model_validate({"axes": {"disp_x": {"axis": "X"}, "disp_z": {"axis": "Z"}}})


def make_run(
    name: str = "run",
    seed: int = 0,
    *,
    hours: float = 4.0,
    step_s: float = 60.0,
    noise: float = 0.02,
    start: float = 21.0,
) -> Run:
    """Return a run of a machine that is linear in the rises of T1 and T4; T2 copies T1."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, hours * 3600 + 1, step_s)
    # Two lags of one random speed, so that the two temperatures are alike but not the same.
    held = int(1800 / step_s)
    speed = np.repeat(random.integers(0, 13, len(time) // held + 1) * 1000.0, held)[: len(time)]
    fast, slow = (lag(speed / 1000, tau_s, step_s) for tau_s in (900.0, 5400.0))
    frame = pd.DataFrame({"time_s": time, "speed_rpm": speed})
    rises = {"T1": fast, "T2": 0.9 * fast, "T3": np.zeros_like(time), "T4": 0.6 * slow}
    for column, rise in rises.items():
        frame[f"{column}_degC"] = start + rise + noise * random.standard_normal(len(time))
    moved = (2.0 * fast + 3.0 * slow, 4.0 * slow, -2.0 * fast, 0.5 * slow, 0.3 * fast)
    pose = pd.DataFrame(dict(zip(POSE, moved, strict=True)))
    return Run(name, pd.concat([frame, readings_of(RIG, pose)], axis=1))
