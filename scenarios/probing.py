"""Probe cycles in a replay: when they are due, and the readings of a probe."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.driving import begins_late
from fmu_compensator.runtime.modelfile import Model
from measurement.drift import counted, measured_drift
from measurement.errors import BadInput
from measurement.resampling import SLOW_S, past_rounding
from measurement.rig import Rig
from measurement.runs import FloatArray, Run
from measurement.units import split_column
from scenarios.scenario import Probe


@dataclass(frozen=True)
class Probing:
    """When to probe, and how precisely.

    Attributes
    ----------
    every_s : float, optional
        Probe at fixed intervals, first one interval after the start, such as 60min [s].
    when_um : float, optional
        Probe when the uncertainty of a measured axis, the half-width of its interval, exceeds this,
        such as 3um: the run's own drift then goes to the measured inputs [um].
    noise_um : float
        Standard deviation of a probe, for each displacement (default: 0.5um) [um].
    seed : int
        Seed of the probes' noise, which depends only on it and the run's name.
    most : int, optional
        Largest number of probes per run.
    """

    every_s: float | None = None
    when_um: float | None = None
    noise_um: float = 0.5
    seed: int = 1
    most: int | None = None


def is_due(
    probing: Probing | Probe, since_s: float, half_widths: Sequence[float], *, is_first: bool
) -> bool:
    """Return whether a probe is due.

    Parameters
    ----------
    probing : Probing or Probe
        Setting of a replay, or of a scenario.
    since_s : float
        Time since the last probe, or else the start [s].
    half_widths : sequence of float
        Uncertainty of each measured axis; NaN if unknown [um].
    is_first : bool
        Whether there was no probe so far.
    """
    if probing.every_s is not None and since_s >= probing.every_s:
        return True
    wide = probing.when_um is not None and any(width > probing.when_um for width in half_widths)
    # With a limit that no probe can keep, the machine would otherwise do nothing else.
    return wide and (is_first or since_s >= SLOW_S)


class ProbedRun:
    """The probe cycles of one run, decided row by row.

    Parameters
    ----------
    probing : Probing
    model : Model
        Model whose targets are measured.
    run : Run
        Without unusable displacements.
    rig : Rig
    tool_length_mm : float

    Attributes
    ----------
    rows : list of int
        Rows at which a probe was taken so far.
    """

    def __init__(
        self, probing: Probing, model: Model, run: Run, rig: Rig, tool_length_mm: float
    ) -> None:
        self.probing = probing
        self.rows: list[int] = []
        noisy = _noisy(probing, run, rig)
        pose = counted(rig.targets(noisy), model.input_form)
        pose = pose.rename(columns={name: split_column(str(name))[0] for name in pose.columns})
        self.targets: FloatArray = pose[list(model.targets)].to_numpy(dtype=np.float64)
        drift = measured_drift(noisy, rig, tool_length_mm, model.input_form)
        self._drift = {str(name)[6]: drift[name].to_numpy() for name in drift.columns}
        self._axes = ["XYZ".index(axis) for axis in self._drift]
        self._time_s = run.time_s
        self._known = np.asarray(np.isfinite(self.targets).all(axis=1))
        if begins_late(model, run, rig):
            problem = "begins so late after the temperatures that no probe's drift from the start"
            raise BadInput(run.path or run.name, "displacement", f"{problem} is known")

    def due(self, row: int, half_widths: Sequence[float]) -> bool:
        """Return whether a probe is taken at a row, and remember it.

        Parameters
        ----------
        row : int
            The run's row.
        half_widths : sequence of float
            The compensator's uncertainty along X, Y and Z there [um].
        """
        probing = self.probing
        if not self._known[row] or (probing.most is not None and len(self.rows) >= probing.most):
            return False
        last = float(self._time_s[self.rows[-1] if self.rows else 0])
        since = past_rounding(float(self._time_s[row])) - last
        measured = [half_widths[axis] for axis in self._axes]
        if not is_due(probing, since, measured, is_first=not self.rows):
            return False
        self.rows.append(row)
        return True

    def held(self, axis: str) -> FloatArray:
        """Return the drift measured by the last probe before each row, initially zero [um]."""
        values = np.zeros(len(self._time_s))
        for row in self.rows:
            values[row + 1 :] = self._drift[axis][row]
        return values


def _noisy(probing: Probing, run: Run, rig: Rig) -> Run:
    """Return the run with the probes' noise, except in the reading that drift counts from."""
    random = np.random.default_rng([probing.seed, zlib.crc32(run.name.encode())])
    frame = run.frame.copy()
    for name in rig.columns:
        values = frame[name].to_numpy(dtype=np.float64)
        noise = random.normal(0.0, probing.noise_um, len(values))
        noise[np.flatnonzero(np.isfinite(values))[:1]] = 0.0
        frame[name] = values + noise
    return Run(run.name, frame)
