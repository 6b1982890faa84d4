"""Thermometers that stand still while the calibrated model moves.

The check for frozen thermometers by the data alone (``measurement.faults``) must be cautious: a
motor temperature written in whole kelvin may rightly stand still for hours. A model that follows
the thermometer in all other runs can decide. It only judges readings that stay exactly the same,
and never declares a moving reading wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap_finder.calibrate import Calibration, Progress, calibrate, quiet
from gap_finder.data_faults import DataFault, without_bad_readings
from gap_finder.observations import INDEPENDENT_S, Observations, observe
from gap_finder.regimes import RunResiduals, mean_squares, range_of, residuals
from measurement.faults.series import UNUSUALLY, resolution_of, stretches, valid
from measurement.resampling import WARMS_K
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.sensors import column_of


def standing_still(machine: Machine, observed: Sequence[Observations]) -> list[DataFault]:
    """Return the thermometers that stand still while the calibrated model moves.

    Parameters
    ----------
    machine : Machine
        Calibrated.
    observed : sequence of Observations
        Of two runs or more; only their channels are checked.

    Notes
    -----
    A standstill shorter than `INDEPENDENT_S` does little harm. During a longer one the model must
    move by as much as a warming machine, and unusually far compared with the thermometer's
    resolution, its tolerance and its residual in the other runs: a model that does not follow a
    thermometer cannot tell that it is broken.
    """
    left = [residuals(machine, run) for run in observed]
    faults = []
    for run in left:
        others = [other for other in left if other is not run]
        for i, name in enumerate(run.observed.channels):
            column = column_of(machine, name)
            span = None if run.observed.lengths[i] else _longest(run.observed, column)
            if span is None:
                continue
            moved, usual = _moved(run, i, span), _usual(others, i)
            with_column = [run.run for run in observed if column in run.run.frame]
            step = resolution_of(with_column, column)
            if moved < max(WARMS_K, UNUSUALLY * max(step, usual, float(run.observed.tolerance[i]))):
                continue
            text = (
                f"{name} in {run.observed.run.name}: exactly the same for "
                f"{(span[1] - span[0]) / 60:.0f} min from {span[0] / 60:.0f} min on, while the "
                f"calibrated model moves by {moved:.1f} K"
            )
            faults.append(DataFault(run.observed.run.name, name, "frozen", *span, text))
    return faults


def calibrated(
    machine: Machine,
    runs: Sequence[Run],
    *,
    starts: int = 2,
    seed: int = 0,
    progress: Progress = quiet,
) -> tuple[Calibration, list[Observations], list[DataFault]]:
    """Calibrate a machine on runs, and again without readings that then prove to stand still.

    Parameters
    ----------
    machine : Machine
    runs : sequence of Run
    starts, seed, progress
        As in `calibrate`.

    Returns
    -------
    calibration : Calibration
    observed : list of Observations
        Without the readings that stand still.
    faults : list of DataFault
    """
    progress("calibrating")
    observed = observe(machine, runs)
    calibration = calibrate(machine, observed, starts=starts, seed=seed, progress=progress)
    faults = standing_still(calibration.machine, observed)
    if faults:
        observed = observe(machine, [without_bad_readings(machine, run, faults) for run in runs])
        again = [calibration.machine]
        calibration = calibrate(machine, observed, starts=1, start_from=again, progress=progress)
    return calibration, observed, faults


def _longest(observed: Observations, column: str) -> tuple[float, float] | None:
    """Return start and end of a column's longest standstill [s]; None below `INDEPENDENT_S`."""
    if column not in observed.run.frame.columns:
        return None
    rows, values = valid(observed.run, column)
    if len(rows) < 3:
        return None
    starts, ends = (observed.run.time_s[rows[places]] for places in stretches(values))
    k = int(np.argmax(ends - starts))
    return (float(starts[k]), float(ends[k])) if ends[k] - starts[k] >= INDEPENDENT_S else None


def _moved(run: RunResiduals, channel: int, span: tuple[float, float]) -> float:
    """Return how far the model moves while the reading stands still [K]."""
    rows = (run.observed.time_s >= span[0]) & (run.observed.time_s <= span[1])
    return range_of(run.values[rows, channel])


def _usual(left: Sequence[RunResiduals], channel: int) -> float:
    """Return the median over runs of a channel's root mean square residual [K]."""
    rms = np.sqrt([mean_squares([run.values])[channel] for run in left])
    measured = rms[np.isfinite(rms)]
    return float(np.median(measured)) if measured.size else float("inf")
