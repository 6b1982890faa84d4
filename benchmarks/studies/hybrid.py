"""The hybrid study's own experiment: two tests of 4 h and 1 h at rest, and workpieces.

76 samples at 4 min, each test done three times and averaged; thermometers at the front bearing, at
the rear bearing and in the air; axial error only. The constituents are made as in the study:
a regression on the three temperatures, a natural exponential whose steady growth comes from finite
elements and its time constant from tau = m c / (alpha S), and the finite elements as they are. The
hybrid is weighed on the first test and judged on the second. Then two groups of five workpieces are
cut, with compensation and without; a workpiece's size errors count from the first of its group.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.results_page import as_table
from benchmarks.studies.machines import Pair, truth
from benchmarks.studies.tables import shown_range
from fmu_compensator.driving import answers, inputs_of
from fmu_compensator.fit.columns import MeasuredColumns
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.runtime.modelfile import parse_model
from measurement.drift import measured_drift
from measurement.figures import figures_of_merit
from measurement.rig import FivePointRig
from measurement.runs import Run
from scenarios.presets import EQUATION_8, HYBRID

SAMPLE_S, SAMPLES, REPEATS = 240.0, 76, 3
POINTS = "T6,T1,T5"
"""Front bearing, rear bearing, air."""
TAUS: Mapping[str, Mapping[str, Any]] = {
    "equation (8)": EQUATION_8,
    "finite elements": {"tau_s": "fem"},
    **{f"{tau:g} s": {"tau_s": tau} for tau in (300.0, 900.0, 1200.0, 1800.0, 3600.0)},
}
"""Where the natural exponential's time constant comes from; the first is the study's way."""


def as_studied(tau: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return the options of the hybrid's parts, with a time constant of `TAUS`."""
    return {**HYBRID, "ne": {"steady": "fem", **tau}}


STOP = (14400.0, 0.0)
FIRST = ((0.0, 4000.0), (3600.0, 8000.0), (6000.0, 0.0), (6600.0, 8000.0), (9600.0, 12000.0), STOP)
SECOND = (
    (0.0, 10000.0),
    (2400.0, 6000.0),
    (5400.0, 12000.0),
    (9000.0, 0.0),
    (9900.0, 8000.0),
    STOP,
)
"""Speeds from a moment on, with a short stop in each [s, r/min]."""
HALL = ({"mean": 20.5, "amplitude": 0.5}, {"mean": 21.0, "amplitude": 1.0})
COOLANT_DEGC = 20.5
MACHINES = ("jig_borer", "elements")
FIGURES = ("sse", "mae", "mape")
MODELS = {
    "no_model": "No model",
    "truth": "Ceiling: the truth without noise",
    "mlr": "MLR",
    "ne": "NE",
    "fem": "FEM",
    "cosine": "VAC hybrid",
    "least_squares": "VAC's least-squares twin",
    "adaptive": "VAC with adaptive weights",
}
PARTS = ("mlr", "ne", "fem")
HYBRIDS = ("cosine", "least_squares", "adaptive")
CUT_MIN = (20.0, 60.0, 100.0, 140.0, 180.0)
"""When the workpieces of a group are finished [min]."""
GROUPS = ((20.0, 8000.0), (24.0, 12000.0))
"""Hall, which the coolant follows, and speed of each group [degC, r/min]."""
TOOL_MM = 130.0


@dataclass(frozen=True)
class Hybrid:
    """What one seed of the experiment gave.

    Attributes
    ----------
    machine : str
    seed : int
    figures : dict of str to tuple
        SSE [um^2], MAE [um] and MAPE [%] of each model on the second test.
    weights : tuple of float
        Of the constituents in the hybrid [1].
    pieces : tuple of (before, after)
        Mean size error of each group's workpieces in R and L [um]; empty without a five-point rig.
    sweep : dict of str to tuple
        By the source of tau: figures of the natural exponential and of the hybrid, and the weight
        of the former in the latter [1].
    """

    machine: str
    seed: int
    figures: dict[str, tuple[float, ...]]
    weights: tuple[float, ...]
    pieces: tuple[tuple[tuple[float, float], tuple[float, float]], ...]
    sweep: dict[str, tuple[tuple[float, ...], tuple[float, ...], float]] = field(
        default_factory=dict
    )


def experiment(machine: str, seed: int) -> list[Hybrid]:
    """Return the experiment on one machine."""
    tests = [averaged(machine, number, seed) for number in (0, 1)]
    rig = MeasuredColumns(["elongation_um"])
    learnt = prepare([tests[0].measured], rig, "rise")
    judged = prepare([tests[1].measured], rig, "rise", sensors=learnt.sensors).runs[0]
    exact = prepare([tests[1].exact], rig, "rise", sensors=learnt.sensors).runs[0].targets
    predicted = {"no_model": np.zeros_like(exact), "truth": exact}

    def figures(values: np.ndarray) -> tuple[float, ...]:
        return tuple(figures_of_merit(judged.targets, values)[key] for key in FIGURES)

    def fitted(recipe: Recipe) -> tuple[FittedModel, np.ndarray]:
        chosen, _ = recipe.choose(learnt, learnt.runs)
        model = recipe.fit(learnt, learnt.runs, chosen)
        return model, model.predict(recipe.rows(judged, chosen))

    for kind, options in HYBRID.items():
        predicted[kind] = fitted(Recipe(kind, POINTS, options=options))[1]
    sweep = {}
    for name, tau in TAUS.items():
        parts = as_studied(tau)
        hybrid = {"models": PARTS, "parts": parts}
        model, values = fitted(Recipe("vac", POINTS, options={**hybrid, "combination": "cosine"}))
        alone = fitted(Recipe("ne", POINTS, options=parts["ne"]))[1]
        found = model.report()["weights"]["steady"]["elongation"]
        sweep[name] = (figures(alone), figures(values), found["ne"])
        if tau is EQUATION_8:
            predicted["cosine"], weights = values, tuple(found[kind] for kind in PARTS)
    for name in HYBRIDS[1:]:
        options = {"models": PARTS, "parts": HYBRID, "combination": name}
        predicted[name] = fitted(Recipe("vac", POINTS, options=options))[1]
    told = {name: figures(values) for name, values in predicted.items()}
    return [Hybrid(machine, seed, told, weights, _workpieces(machine, seed), sweep)]


def _scenario(
    speeds: Sequence[tuple[float, float]], hall: Mapping[str, float] | float
) -> list[tuple[str, Any]]:
    """Return the iso230_3 scenario with other speeds and temperatures outside."""
    fixed = isinstance(hall, float)
    air = hall if fixed else {"kind": "sine", "period_s": 20000.0, **hall}
    steps = {"kind": "steps", "times_s": [t for t, _ in speeds], "values": [n for _, n in speeds]}
    return [
        ("", "iso230_3"),
        ("signals.ambient", air),
        ("signals.coolant_inlet", hall if fixed else COOLANT_DEGC),
        ("signals.speed", steps),
    ]


def averaged(machine: str, number: int, seed: int) -> Pair:
    """Return a test's samples, each the mean of three runs."""
    scenario = _scenario((FIRST, SECOND)[number], HALL[number])
    pairs = [
        truth(machine).record(scenario, False, 1000 * seed + 10 * number + again)
        for again in range(REPEATS)
    ]
    frames = [_samples(pair.measured.frame) for pair in pairs]
    mean = sum(frames[1:], start=frames[0]) / REPEATS
    name = f"test_{number + 1}"
    return Pair(Run(name, mean), Run(name, _samples(pairs[0].exact.frame)))


def _samples(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the samples, with the axial error as elongation."""
    time = frame["time_s"].to_numpy()
    rows = np.searchsorted(time, SAMPLE_S * np.arange(SAMPLES) - 1e-6)
    found = frame.iloc[rows].reset_index(drop=True)
    if "elongation_um" not in found:
        found = found.assign(elongation_um=-found["S5_um"])
    kept = [name for name in found.columns if not name.startswith("S")]
    return found[kept]


def _workpieces(machine: str, seed: int) -> tuple[Any, ...]:
    """Return mean size errors (R, L) of each group without and with the hybrid's compensation."""
    rig = truth(machine).rig
    if not isinstance(rig, FivePointRig):
        return ()
    learnt = truth(machine).record(_scenario(FIRST, HALL[0]), False, 1000 * seed).measured
    options = {"models": ",".join(PARTS), "parts": HYBRID}
    table = fit_compensator([learnt], rig, "vac", points=POINTS, **options)
    model = parse_model(compensator_text(table), "vac")
    found = []
    for number, (hall, speed) in enumerate(GROUPS):
        scenario = _scenario(((0.0, speed), STOP), hall)
        pair = truth(machine).record(scenario, False, 1000 * seed + 20 + number)
        drift = measured_drift(pair.exact, rig, TOOL_MM, "rise").to_numpy()
        readings, turning = inputs_of(model, pair.measured)
        inputs = zip(pair.measured.time_s, readings, turning, repeat(None))
        left = drift + [output[:3] for output in answers(model, inputs, TOOL_MM)]
        rows = np.searchsorted(pair.exact.time_s, 60.0 * np.array(CUT_MIN) - 1e-6)
        # The first workpiece of a group is the reference.
        sizes = [errors[rows][1:] - errors[rows][0] for errors in (drift, left)]
        found.append(tuple(tuple(np.abs(size[:, [0, 2]]).mean(axis=0).tolist()) for size in sizes))
    return tuple(found)


def hybrid_table(found: Sequence[Hybrid]) -> str:
    """Return SSE, MAE and MAPE of every model: mean (worst seed)."""
    rows = []
    for name, title in MODELS.items():
        cells = [title]
        for machine in MACHINES:
            here = np.array([one.figures[name] for one in found if one.machine == machine])
            cells += [shown_range(column, max) for column in here.T]
        rows.append(cells)
    heads = [
        f"{truth(m).title}: {f}" for m in MACHINES for f in ("SSE [um2]", "MAE [um]", "MAPE [%]")
    ]
    return as_table(["model", *heads], rows)


def tau_table(found: Sequence[Hybrid]) -> str:
    """Return by the source of tau how the hybrid does, and in how many seeds it beats its parts."""
    rows = []
    for name in TAUS:
        cells = [name]
        for machine in MACHINES:
            here = [one for one in found if one.machine == machine and one.sweep]
            alone, hybrid = (np.array([one.sweep[name][k][0] for one in here]) for k in (0, 1))
            weight = np.mean([one.sweep[name][2] for one in here])
            won = sum(_wins(one, name) for one in here)
            cells += [shown_range(alone, max, 0), shown_range(hybrid, max, 0)]
            cells += [f"{weight:.2f}", f"{won} of {len(here)}"]
        rows.append(cells)
    heads = ("SSE of NE", "SSE of the hybrid", "weight of NE", "beats all parts")
    return as_table(
        ["tau from", *(f"{truth(m).title}: {h}" for m in MACHINES for h in heads)], rows
    )


def _wins(one: Hybrid, tau: str) -> bool:
    """Return whether the hybrid beats its three parts in all three figures."""
    alone, hybrid, _ = one.sweep[tau]
    parts = (alone, one.figures["mlr"], one.figures["fem"])
    return all(mine < theirs[k] for theirs in parts for k, mine in enumerate(hybrid))


def workpiece_table(found: Sequence[Hybrid]) -> str:
    """Return what is left of the workpieces' size errors: mean (worst seed)."""
    rows = []
    here = [one for one in found if one.pieces]
    for number, (hall, speed) in enumerate(GROUPS):
        for axis, name in enumerate(("R", "L")):
            before, after = (
                np.array([one.pieces[number][k][axis] for one in here]) for k in (0, 1)
            )
            better = 100.0 * (1.0 - after / before)
            group = f"{number + 1}: {hall:g} degC, {speed:g} r/min"
            cells = [shown_range(before, max, 1), shown_range(after, max, 1)]
            rows.append([group, name, *cells, shown_range(better, min, 0), "60"])
    head = ["group", "size", "error before [um]", "after [um]", "better by [%]", "study [%]"]
    return as_table(head, rows)
