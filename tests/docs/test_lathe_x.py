"""The lags behind the lathe's X: found again where they are known."""

import numpy as np
import pandas as pd
import pytest

from benchmarks.lathe_x import TERMS, choices, chosen, fitted, moments, regressors
from measurement.runs import Run

LAGS = (20.0, 200.0, 300.0, 40.0, 240.0)
FACTORS = (-21.0, 37.0, 5.0, -8.0, 12.0)


def made(name: str, speeds: tuple[float, float], hall_per_hour: float) -> Run:
    """Return five hours, speed and hall changing halfway, with X after the known law."""
    time = np.arange(0.0, 5 * 3600.0, 60.0)
    late = time > 2.5 * 3600.0
    frame = pd.DataFrame(
        {
            "time_s": time,
            "speed_rpm": np.where(late, speeds[1], speeds[0]),
            "feed_mm_min": np.where(late, 3000.0, 5000.0),
            "TC08_degC": 20.0 + hall_per_hour * np.where(late, time / 3600.0, 0.0),
            "disp_x_um": 0.0,
        }
    )
    columns = regressors(Run(name, frame))[:, wanted()]
    # The zero of every recording is its own.
    frame["disp_x_um"] = columns @ np.array(FACTORS) + len(name)
    return Run(name, frame)


def wanted() -> list[int]:
    """Return the columns of the known lags."""
    flat = [(i, lag) for i, (_, _, lags) in enumerate(TERMS) for lag in lags]
    return [flat.index(pair) for pair in enumerate(LAGS)]


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    speeds = [(2000.0, 1000.0), (1000.0, 2000.0), (2000.0, 2000.0), (1000.0, 1000.0)]
    return [made("r" * (i + 1), pair, 2.0 * i - 3.0) for i, pair in enumerate(speeds)]


def test_known_lags_and_factors_are_found(runs):
    found = [moments(run) for run in runs]
    columns = chosen(found)
    assert list(columns) == wanted()
    factors, left = fitted(found, columns)
    assert factors == pytest.approx(FACTORS, rel=1e-3)
    assert left < 1e-6
    # Any other lags leave more.
    assert min(fitted(found, other)[1] for other in choices() if other != columns) > left
