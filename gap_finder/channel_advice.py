"""What a calibration says of single channels, in plain words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap_finder.regimes import RunResiduals, noise_of
from gap_finder.told import Advice, worst_first
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

WORSE = 1.1
"""Times what the machine file left as it was, from which calibration made a channel worse [1]."""

STILL = 0.02
"""Share of what a displacement moves by, below which the model does not move it [1]."""

MOVED = 10.0
"""A channel has moved from so many times its noise on [1]."""

CONSTANT = 3.0
"""A thermometer is off by a constant in a run if its mean error is so many times what it varies by,
and as many tolerances [1]."""


def about_channels(
    machine: Machine, left: Sequence[RunResiduals], before: Sequence[RunResiduals]
) -> list[Advice]:
    """Return what single channels say.

    Parameters
    ----------
    machine : Machine
        Calibrated.
    left, before : sequence of RunResiduals
        What it leaves of each run, and what it left before calibration.
    """
    return [
        *worse_than_none(machine, left),
        *_not_moved(machine, left),
        *_worse_than_before(machine, left, before),
        *_off_by_a_constant(machine, left),
    ]


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
    return worst_first(found)


def _not_moved(machine: Machine, left: Sequence[RunResiduals]) -> list[Advice]:
    """Return the displacements that nothing in the machine moves."""
    names = left[0].observed.channels
    noise = noise_of(machine, names)
    found = []
    for i, name in enumerate(names):
        if name not in displacement_names(machine):
            continue
        measured = max(_range(one.observed.values[:, i]) for one in left)
        model = max(_range(one.observed.values[:, i] + one.values[:, i]) for one in left)
        if measured > MOVED * noise[i] and model < STILL * measured:
            text = (
                f"{name}: moves by {measured:.2g} um, and nothing in the machine file moves it: no "
                "part grows or bends that way"
            )
            found.append((measured, Advice("not_moved", (name,), text)))
    return worst_first(found)


def _worse_than_before(
    machine: Machine, left: Sequence[RunResiduals], before: Sequence[RunResiduals]
) -> list[Advice]:
    """Return the channels that calibration made worse."""
    names = left[0].observed.channels
    noise = noise_of(machine, names)
    found = []
    for i, name in enumerate(names):
        now, then = _rms_of_both(
            [one.values[:, i] for one in left], [one.values[:, i] for one in before]
        )
        if now > max(WORSE * then, MOVED * noise[i]):
            unit = _unit(machine, name)
            text = (
                f"{name}: {now:.2g} {unit} after calibration, {then:.2g} {unit} before: no number "
                "that may move puts it right together with the others; look at those that decide "
                "it and are fixed"
            )
            found.append((now / max(then, 1e-12), Advice("worse_than_before", (name,), text)))
    return worst_first(found)


def _off_by_a_constant(machine: Machine, left: Sequence[RunResiduals]) -> list[Advice]:
    """Return the thermometers that are off by the same in all of a run."""
    lengths = set(displacement_names(machine))
    found = []
    for i, name in enumerate(left[0].observed.channels):
        runs, errors = [], []
        for one in left:
            values = one.values[:, i][np.isfinite(one.values[:, i])]
            if name in lengths or len(values) < 2:
                continue
            mean = -float(np.mean(values))
            if abs(mean) > CONSTANT * max(float(np.std(values)), float(one.observed.tolerance[i])):
                runs.append(one.observed.run.name)
                errors.append(mean)
        if runs:
            worst = max(errors, key=abs)
            text = (
                f"{name}: shows {worst:+.1f} K beside the model throughout {', '.join(runs)}: the "
                "thermometer may have a constant error there"
            )
            found.append((abs(worst), Advice("off_by_a_constant", (name,), text)))
    return worst_first(found)


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
