"""What a calibrated machine says of its own description, in plain words.

Nothing is tried and nothing is named here, as ``find-gap`` does: it is what can be read off a
calibration at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gap_finder.calibrate import ParameterEstimate
from gap_finder.observations import Observations
from gap_finder.regimes import RunResiduals, noise_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

MOST = 6
"""Lines of a kind, and runners-up, at most, the worst first: as many as a page shows, and set on no
data."""


@dataclass(frozen=True)
class Advice:
    """One thing that the description may lack.

    Attributes
    ----------
    kind : str
        ``sensors_disagree``, ``far_from_usual``, ``worse_than_no_model`` or ``not_moved``.
    place : tuple of str
        The sensors, parameter or channel.
    text : str
        One line for a person.
    """

    kind: str
    place: tuple[str, ...]
    text: str


def advice(
    machine: Machine, left: Sequence[RunResiduals], parameters: Sequence[ParameterEstimate]
) -> list[Advice]:
    """Return what a calibrated machine says of its description.

    Parameters
    ----------
    machine : Machine
        Calibrated.
    left : sequence of RunResiduals
        What it leaves of the runs that it was calibrated on.
    parameters : sequence of ParameterEstimate
        What calibration says of its numbers.
    """
    return [
        *worse_than_none(machine, left),
        *not_moved(machine, left),
        *disagreeing(machine, [one.observed for one in left]),
        *_far(parameters),
    ]


def _worst_first(found: Sequence[tuple[float, Advice]]) -> list[Advice]:
    return [one for _, one in sorted(found, key=lambda pair: -pair[0])][:MOST]


def worse_than_none(machine: Machine, left: Sequence[RunResiduals]) -> list[Advice]:
    """Return the channels that the model predicts worse than if each stayed at its first value."""
    found = []
    for i, name in enumerate(left[0].observed.channels):
        without = [_moved(one.observed.values[:, i]) for one in left]
        model, none = _rms_of_both([one.values[:, i] for one in left], without)
        if model > none:
            unit = _unit(machine, name)
            text = (
                f"{name}: the model leaves {model:.2g} {unit}, holding the first reading leaves "
                f"{none:.2g} {unit}: worse than no model"
            )
            found.append((model / max(none, 1e-12), Advice("worse_than_no_model", (name,), text)))
    return _worst_first(found)


def not_moved(machine: Machine, left: Sequence[RunResiduals]) -> list[Advice]:
    """Return the displacements that move, and that the model moves by less than the noise."""
    names = left[0].observed.channels
    noise = noise_of(machine, names)
    found = []
    for i, name in enumerate(names):
        if name not in displacement_names(machine):
            continue
        measured = max(_range(one.observed.values[:, i]) for one in left)
        model = max(_range(one.observed.values[:, i] + one.values[:, i]) for one in left)
        if measured > left[0].observed.tolerance[i] and model < noise[i]:
            text = (
                f"{name}: moves by {measured:.2g} um, and nothing in the machine file moves it: no "
                "part grows or bends that way"
            )
            found.append((measured, Advice("not_moved", (name,), text)))
    return _worst_first(found)


def disagreeing(machine: Machine, observed: Sequence[Observations]) -> list[Advice]:
    """Return the parts whose thermometers differ by more than a constant and their tolerances."""
    names = observed[0].channels
    found = []
    for node in machine.nodes:
        there = [one.name for one in machine.sensors if one.of == node.name and one.name in names]
        for pair in combinations(there, 2):
            i, j = (names.index(name) for name in pair)
            apart = [one.values[:, i] - one.values[:, j] for one in observed]
            known = np.concatenate([part[np.isfinite(part)] for part in apart])
            if len(known) < 3:
                continue
            spread = float(np.std(known))
            if spread > float(np.hypot(*(observed[0].tolerance[k] for k in (i, j)))):
                text = (
                    f"{node.name}: {pair[0]} and {pair[1]} sit on this one lump but differ by "
                    f"{spread:.2g} K beyond a constant: it has two temperatures"
                )
                found.append((spread, Advice("sensors_disagree", pair, text)))
    return _worst_first(found)


def _far(parameters: Sequence[ParameterEstimate]) -> list[Advice]:
    """Return the numbers that calibration takes out of the range in which they are expected."""
    found = []
    for one in parameters:
        if not one.is_far:
            continue
        unit = "" if one.unit == "1" else f" {one.unit}"
        source = f" ({one.source})" if one.source else ""
        text = (
            f"{one.name}: {one.value:.3g}{unit}, {abs(one.deviations):.1f} deviations "
            f"{'below' if one.value < one.prior else 'above'} {one.prior:.3g}{source}: "
            "look at it, or at what has a similar effect"
        )
        found.append((abs(one.deviations), Advice("far_from_usual", (one.name,), text)))
    return _worst_first(found)


def _unit(machine: Machine, name: str) -> str:
    return "um" if name in displacement_names(machine) else "K"


def _moved(values: FloatArray) -> FloatArray:
    known = values[np.isfinite(values)]
    return values - known[0] if len(known) else values


def _range(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0


def _rms_of_both(one: Sequence[FloatArray], other: Sequence[FloatArray]) -> tuple[float, float]:
    """Return the root mean squares of two series where both are known; 0 if nowhere."""
    parts = np.concatenate(one), np.concatenate(other)
    known = np.isfinite(parts[0]) & np.isfinite(parts[1])
    if not known.any():
        return 0.0, 0.0
    first, second = (float(np.sqrt(np.mean(part[known] ** 2))) for part in parts)
    return first, second
