"""What the lathe's X depends on: lagged speed, feed and hall, each run predicted from the others.

    python -m benchmarks.lathe_x DATA [--without 20200929 20200821]

It uses no thermal model. X is a sum of

- speed through two lags in series, like the bearing seats, which warm after the bearings;
- speed through one long lag, like the parts behind the seats;
- feed through a long lag, like the slides and the bed;
- the hall temperature through a short and through a long lag.

The zero of each recording is unknown, so each run's mean is subtracted from both sides. Lags are
chosen and factors fitted for each left-out run from the others only. Frozen and saturated
displacement is left out.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gap_finder.data_faults import without_faults
from measurement.runs import Run, read_run
from plant_model.machine_file import read_machine
from studies.fit.lagged import lagged

Array = npt.NDArray[np.float64]

TERMS = (
    ("speed, twice", "um per 1000 r/min", (10.0, 20.0, 40.0)),
    ("speed", "um per 1000 r/min", (100.0, 200.0, 300.0)),
    ("feed", "um per m/min", (100.0, 300.0)),
    ("hall", "um/K", (10.0, 20.0, 40.0)),
    ("hall", "um/K", (120.0, 240.0)),
)
"""Name, unit of the factor, and the lags tried [min]."""

HALL = "TC08_degC"
TARGET = "disp_x_um"


@dataclass(frozen=True)
class Moments:
    """One run's contribution to the normal equations of least squares.

    Attributes
    ----------
    name : str
    matrix : array, shape (F, F)
    right : array, shape (F,)
    square : float
        Mean square of X about the run's mean [um2].
    """

    name: str
    matrix: Array
    right: Array
    square: float

    def missed(self, factors: Array, columns: Sequence[int]) -> float:
        """Return the mean squared residual with these factors [um2]."""
        own, right = self.matrix[np.ix_(columns, columns)], self.right[list(columns)]
        return max(float(self.square - 2.0 * factors @ right + factors @ own @ factors), 0.0)


def regressors(run: Run) -> Array:
    """Return every term at every lag, then the speed itself, shape (rows, F)."""
    frame = run.frame
    elapsed = np.diff(run.time_s, prepend=run.time_s[0])
    hall = frame[HALL].to_numpy(dtype=np.float64)
    drives = {
        "speed": frame["speed_rpm"].to_numpy(dtype=np.float64) / 1e3,
        "feed": frame["feed_mm_min"].to_numpy(dtype=np.float64) / 1e3,
        # Relative to its first minutes: a cabinet's control makes single readings swing by 1 K.
        "hall": hall - hall[run.time_s < run.time_s[0] + 300.0].mean(),
    }
    columns = []
    for name, _, lags in TERMS:
        drive = drives[name.partition(",")[0]][:, None]
        for minutes in lags:
            value = lagged(drive, elapsed, 60.0 * minutes)
            if name.endswith("twice"):
                value = lagged(value, elapsed, 60.0 * minutes)
            columns.append(value[:, 0])
    return np.column_stack([*columns, drives["speed"]])


def moments(run: Run) -> Moments:
    """Return the moments of a run's X while the spindle turns, about their means."""
    target = run.frame[TARGET].to_numpy(dtype=np.float64)
    rows = np.isfinite(target) & (run.frame["speed_rpm"].to_numpy() > 0.0)
    left = regressors(run)[rows]
    left, right = left - left.mean(axis=0), target[rows] - target[rows].mean()
    count = len(right)
    return Moments(run.name, left.T @ left / count, left.T @ right / count, right @ right / count)


def choices() -> list[tuple[int, ...]]:
    """Return the columns of every combination of lags."""
    starts = np.cumsum([0, *(len(lags) for _, _, lags in TERMS)])
    ranges = [range(a, b) for a, b in pairwise(starts)]
    return list(product(*ranges))


def fitted(runs: Sequence[Moments], columns: Sequence[int]) -> tuple[Array, float]:
    """Return the factors and the mean squared residual, with equal weight for every run."""
    matrix = np.sum([one.matrix for one in runs], axis=0)
    right = np.sum([one.right for one in runs], axis=0)
    factors = np.linalg.solve(matrix[np.ix_(columns, columns)], right[list(columns)])
    return factors, sum(one.missed(factors, columns) for one in runs) / len(runs)


def chosen(runs: Sequence[Moments]) -> tuple[int, ...]:
    """Return the columns of the lags with the smallest residual."""
    return min(choices(), key=lambda columns: fitted(runs, columns)[1])


def main() -> int:
    """Fit, judge and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="folder of the run files")
    parser.add_argument("--without", nargs="+", default=[], metavar="RUN", help="never opened")
    args = parser.parse_args()
    paths = [p for p in sorted(args.data.glob("2*.csv")) if p.stem not in args.without]
    if len(paths) < 3:
        print(f"{args.data}: {len(paths)} runs named by date are left; three or more are needed")
        return 2
    sound, _ = without_faults(read_machine("lathe"), [read_run(path) for path in paths])
    runs = [moments(run) for run in sound]
    print(f"{'run left out':<14}{'X':>8}{'left':>8}{'with speed at once':>20}   um rms")
    left, instant = [], []
    for i, one in enumerate(runs):
        rest = runs[:i] + runs[i + 1 :]
        columns = chosen(rest)
        more = (*columns, len(one.right) - 1)
        left.append(one.missed(fitted(rest, columns)[0], columns))
        instant.append(one.missed(fitted(rest, more)[0], more))
        shown = np.sqrt([one.square, left[-1], instant[-1]])
        print(f"{one.name:<14}{shown[0]:>8.1f}{shown[1]:>8.1f}{shown[2]:>20.1f}")
    table = np.sqrt([[one.square for one in runs], left, instant])
    for name, row in (("median", np.median(table, axis=1)), ("rms", np.sqrt((table**2).mean(1)))):
        print(f"{name:<14}{row[0]:>8.1f}{row[1]:>8.1f}{row[2]:>20.1f}")
    columns = chosen(runs)
    lags = [minutes for _, _, each in TERMS for minutes in each]
    print("\nX, fitted to all of them:")
    for (name, unit, _), column, factor in zip(
        TERMS, columns, fitted(runs, columns)[0], strict=True
    ):
        print(f"{factor:>8.1f} {unit:<18} {name} behind {lags[column]:.0f} min")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
