"""Fit one model on one machine's training run, and judge it on every protocol's run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.learning import learnt
from benchmarks.studies.entrants import ENTRANTS, NO_MODEL, PERSISTENCE, TRUTH
from benchmarks.studies.machines import EVERY_S, Pair, truth
from fmu_compensator.fit.contestants import held
from fmu_compensator.fit.data import PreparedRun, prepare
from measurement.drift import tool_tip_drift
from measurement.errors import BadInput
from measurement.rig import POSE, FivePointRig
from studies.fit.bp import BackPropagation

TOOL_MM = 130.0
"""The distal sensors, at which the studies judge X and Y."""
SHOWN = 3
"""Elongation, yaw and pitch come first among the targets."""


@dataclass(frozen=True)
class Score:
    """One model, one seed, one protocol.

    Attributes
    ----------
    machine, model, protocol : str
    seed : int
    eta : tuple of float
        Predictive ability of elongation (yaw, pitch): 1 - sum|e| / sum|y| [%].
    better : tuple of float
        What compensation takes off the mean size of the tip's drift along X, Y, Z [%]. Only with a
        five-point rig.
    axial_um : tuple of float
        Largest size of the axial drift before and after, mean size before and after [um].
    report : dict
        Diagnostics of the fit; of the first protocol only.
    """

    machine: str
    model: str
    protocol: str
    seed: int
    eta: tuple[float, ...]
    better: tuple[float, ...]
    axial_um: tuple[float, ...]
    report: dict[str, Any]


@lru_cache(maxsize=1)
def _runs(machine: str, seed: int) -> dict[str, Pair]:
    return truth(machine).runs(seed)


def judge_all(machine: str, seed: int, only: str | None = None) -> list[Score]:
    """Return how every model does, or one alone, on a machine's runs of one seed."""
    takes_part = [
        name
        for name, entrant in ENTRANTS.items()
        if machine in (entrant.machines or (machine,)) and only in (None, name)
    ]
    return [score for name in takes_part for score in judge(machine, seed, name)]


def judge(machine: str, seed: int, name: str) -> list[Score]:
    """Return how a model does under every protocol; nothing where the machine cannot carry it.

    Parameters
    ----------
    machine : str
        Of `benchmarks.studies.machines.TRUTHS`.
    seed : int
        Of the noise, the unseen spectrum and the model's start.
    name : str
        Of `ENTRANTS`.
    """
    entrant, rig = ENTRANTS[name], truth(machine).rig
    pairs = _runs(machine, seed)
    if entrant.step_s is not None:
        every = round(entrant.step_s / EVERY_S)
        pairs = {protocol: pair.thinned(every) for protocol, pair in pairs.items()}
    recipe = entrant.recipe(seed) if entrant.is_fitted else None
    try:
        runs = [pair.measured for pair in pairs.values()]
        _, unseen, fitted, chosen = learnt(recipe, [pairs["fit"].measured], runs, rig)
    except BadInput:  # a study's points that this machine does not have
        return []
    report = fitted.report() if fitted else {}
    if isinstance(fitted, BackPropagation):  # a report keeps the curve's beginning
        report["curve"] = fitted.training.curve
    found = []
    for (protocol, pair), run in zip(pairs.items(), unseen, strict=True):
        rows = recipe.rows(run, chosen) if recipe else run.history(chosen)
        told = rows.targets if entrant.measured else None
        if fitted is not None:
            predicted = fitted.predict(rows, told)
        elif entrant.kind == PERSISTENCE:
            predicted = held(rows, told)
        elif entrant.kind == NO_MODEL:
            predicted = np.zeros_like(rows.targets)
        else:
            assert entrant.kind == TRUTH
            predicted = _exact(pair, rig, run)
        known = rows.known
        figures = _figures(rows.targets[known], predicted[known], rig)
        found.append(Score(machine, name, protocol, seed, *figures, report))
        report = {}
    return found


def _exact(pair: Pair, rig: Any, run: PreparedRun) -> np.ndarray:
    """Return the targets without noise, at the rows of the measured run."""
    exact = prepare([pair.exact], rig, "rise").runs[0]
    assert np.array_equal(exact.time_s, run.time_s)
    return exact.targets


def _figures(
    measured: np.ndarray, predicted: np.ndarray, rig: Any
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Return eta, what is better, and the axial drift."""
    shown = measured[:, :SHOWN] if isinstance(rig, FivePointRig) else measured
    left = shown - predicted[:, : shown.shape[1]]
    eta = 100.0 * (1.0 - np.abs(left).sum(axis=0) / np.abs(shown).sum(axis=0))
    before, after = np.abs(shown[:, 0]), np.abs(left[:, 0])
    axial = (before.max(), after.max(), before.mean(), after.mean())
    better: tuple[float, ...] = ()
    if isinstance(rig, FivePointRig):
        drift, offset = (
            tool_tip_drift(pd.DataFrame(pose, columns=list(POSE)), rig, TOOL_MM).to_numpy()
            for pose in (measured, predicted)
        )
        rest = np.abs(drift - offset).mean(axis=0) / np.abs(drift).mean(axis=0)
        better = tuple(float(value) for value in 100.0 * (1.0 - rest))
    return tuple(float(v) for v in eta), better, tuple(float(v) for v in axial)
