"""What a calibration shows about a machine's description, in plain words.

Unlike ``find-gap``, this tries and names no effects: it only reads the result of one calibration.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gap_finder.calibrate import ParameterEstimate
from gap_finder.observations import Observations
from gap_finder.regimes import RunResiduals, mean_squares, range_of
from measurement.faults.series import UNUSUALLY
from plant_model.machine import Machine

MOST_LINES = 6
"""Most lines of a kind, and most runners-up, worst first: as many as fit a page. Set on no data."""


@dataclass(frozen=True)
class Advice:
    """A possible defect of the description.

    Attributes
    ----------
    kind : str
        ``odd_run``, ``sensors_disagree``, ``far_from_usual``, ``worse_than_no_model`` or
        ``not_moved``.
    place : tuple of str
        The sensors, parameter or channel.
    text : str
        One readable line.
    """

    kind: str
    place: tuple[str, ...]
    text: str


Weighed = tuple[float, Advice]
"""How bad a defect is, in a measure of its kind, and the advice."""


def advice(
    machine: Machine, left: Sequence[RunResiduals], parameters: Sequence[ParameterEstimate]
) -> list[Advice]:
    """Return what a calibration shows about the machine's description.

    Parameters
    ----------
    machine : Machine
        Calibrated.
    left : sequence of RunResiduals
        Its residuals on the runs that it was calibrated on.
    parameters : sequence of ParameterEstimate
        Its parameters before and after calibration.
    """
    found = (
        odd_runs(left),
        worse_than_none(left),
        not_moved(left),
        disagreeing(machine, [run.observed for run in left]),
        _far(parameters),
    )
    worst_first = (sorted(kind, key=lambda pair: -pair[0])[:MOST_LINES] for kind in found)
    return [line for kind in worst_first for _, line in kind]


def odd_runs(left: Sequence[RunResiduals]) -> Iterator[Weighed]:
    """Yield the channels that one run contradicts: a sign, a unit or two columns may be wrong."""
    if len(left) < 2:
        return
    observed = left[0].observed
    by_run = np.nan_to_num(np.sqrt([mean_squares([run.values]) for run in left]))
    for i, name in enumerate(observed.channels):
        *_, second, worst = np.argsort(by_run[:, i]).tolist()
        most, others = by_run[worst, i], by_run[second, i]
        if others > 0.0 and most > max(UNUSUALLY * others, observed.tolerance[i]):
            run, unit = left[worst].observed.run.name, observed.unit_of(i)
            text = (
                f"{name}: off by {most:.2g} {unit} in {run}, by at most {others:.2g} {unit} in the "
                "others: check signs, units, columns and what happened in that run"
            )
            yield most / others, Advice("odd_run", (name, run), text)


def worse_than_none(left: Sequence[RunResiduals]) -> Iterator[Weighed]:
    """Yield the channels predicted worse than by their first reading, by more than the noise."""
    observed = left[0].observed
    parts = [run.values for run in left], [run.observed.moved for run in left]
    models, nones = (np.nan_to_num(np.sqrt(mean_squares(part))).tolist() for part in parts)
    for i, (name, model, none) in enumerate(zip(observed.channels, models, nones, strict=True)):
        if model > np.hypot(none, observed.noise[i]):
            unit = observed.unit_of(i)
            text = (
                f"{name}: the model is off by {model:.2g} {unit}, holding the first reading by "
                f"{none:.2g} {unit}: worse than no model"
            )
            yield model / max(none, 1e-12), Advice("worse_than_no_model", (name,), text)


def not_moved(left: Sequence[RunResiduals]) -> Iterator[Weighed]:
    """Yield the displacements that move, but that the model moves by less than the noise."""
    observed = left[0].observed
    for i in np.flatnonzero(observed.lengths).tolist():
        measured = max(range_of(run.observed.values[:, i]) for run in left)
        model = max(range_of(run.observed.values[:, i] + run.values[:, i]) for run in left)
        if measured > observed.tolerance[i] and model < observed.noise[i]:
            name = observed.channels[i]
            text = (
                f"{name}: moves by {measured:.2g} um, but nothing in the machine file moves it: no "
                "part grows or bends in that direction"
            )
            yield measured, Advice("not_moved", (name,), text)


def disagreeing(machine: Machine, observed: Sequence[Observations]) -> Iterator[Weighed]:
    """Yield the parts whose thermometers differ by more than a constant and their tolerances."""
    names = observed[0].channels
    for node in machine.nodes:
        on_part = [sensor.name for sensor in machine.sensors if sensor.of == node.name]
        there = [name for name in on_part if name in names]
        for pair in combinations(there, 2):
            i, j = (names.index(name) for name in pair)
            apart = [run.values[:, i] - run.values[:, j] for run in observed]
            measured = np.concatenate([part[np.isfinite(part)] for part in apart])
            if len(measured) < 3:
                continue
            spread = float(np.std(measured))
            if spread > float(np.hypot(*(observed[0].tolerance[k] for k in (i, j)))):
                text = (
                    f"{node.name}: {pair[0]} and {pair[1]} sit on this one lump but differ by "
                    f"{spread:.2g} K beyond a constant: it has two temperatures"
                )
                yield spread, Advice("sensors_disagree", pair, text)


def unit_after(unit: str) -> str:
    """Return a unit as it stands behind a number; nothing for a number without one."""
    return "" if unit == "1" else f" {unit}"


def _far(parameters: Sequence[ParameterEstimate]) -> Iterator[Weighed]:
    """Yield the parameters that calibration moved out of their expected range."""
    for estimate in parameters:
        if not estimate.is_far:
            continue
        name, value, prior = estimate.name, estimate.value, estimate.prior
        source = f" ({estimate.source})" if estimate.source else ""
        deviations = abs(estimate.deviations)
        text = (
            f"{name}: {value:.3g}{unit_after(estimate.unit)}, {deviations:.1f} deviations "
            f"{'below' if value < prior else 'above'} {prior:.3g}{source}, "
            "or something else acts like it"
        )
        yield deviations, Advice("far_from_usual", (name,), text)
