"""What a calibrated machine says of its own description, in plain words.

Nothing is tried and nothing is named here, as ``find-gap`` does: it is what can be read off a
calibration at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from gap_finder.calibrate import ParameterEstimate
from gap_finder.channel_advice import about_channels
from gap_finder.observations import Observations
from gap_finder.regimes import RunResiduals, noise_of, regimes
from gap_finder.told import Advice, worst_first
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.simulate import simulate

OFF_K = 1.0
"""Heat is told from where it would make a part so much warmer or colder in the end [K]."""

ALIKE = 0.75
"""Share of the runs in which heat must be missing with the same sign to be told [1]."""

APART = 3.0
"""Two thermometers on a part disagree from so many of their noises together [1]."""

LEAST_APART_K = 0.3
"""Two thermometers on a part disagree by no less than this [K]: no part is one temperature to the
last tenth."""


def advice(
    machine: Machine,
    left: Sequence[RunResiduals],
    parameters: Sequence[ParameterEstimate],
    before: Sequence[RunResiduals] | None = None,
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
    before : sequence of RunResiduals, optional
        What it left of them before calibration.
    """
    observed = [one.observed for one in left]
    return [
        *about_channels(machine, left, left if before is None else before),
        *disagreeing(machine, observed),
        *_balances(machine, observed),
        *_far(parameters),
    ]


def disagreeing(machine: Machine, observed: Sequence[Observations]) -> list[Advice]:
    """Return the parts on which two thermometers differ by more than a constant."""
    names = observed[0].channels
    noise = noise_of(machine, names)
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
            if spread > max(APART * float(np.hypot(noise[i], noise[j])), LEAST_APART_K):
                text = (
                    f"{node.name}: {pair[0]} and {pair[1]} sit on this one lump but differ by "
                    f"{spread:.2g} K beyond a constant: it has two temperatures"
                )
                found.append((spread, Advice("sensors_disagree", pair, text)))
    return worst_first(found)


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
    return worst_first(found)


def _balances(machine: Machine, observed: Sequence[Observations]) -> list[Advice]:
    """Return the parts whose heat does not add up, from their thermometers' own readings."""
    told: dict[tuple[int, str], list[float]] = {}
    scale = np.zeros(len(machine.nodes))
    for one in observed:
        balance, total = heat_missing(machine, one)
        scale = np.maximum(scale, total)
        for doing, missing in balance.items():
            for node in np.flatnonzero(np.isfinite(missing)).tolist():
                told.setdefault((node, doing), []).append(float(missing[node]))
    found = []
    for node, entry in enumerate(machine.nodes):
        words, worst = [], 0.0
        for doing in ("running", "standing"):
            power = np.array(told.get((node, doing), []))
            if not len(power):
                continue
            middle = float(np.median(power))
            off = abs(middle) / max(float(scale[node]), 1e-9)
            if off >= OFF_K and float(np.mean(np.sign(power) == np.sign(middle))) >= ALIKE:
                words.append(f"{middle:+.2g} W while {doing}")
                worst = max(worst, off)
        if words:
            text = (
                f"{entry.name}: its thermometer shows heat that the model lacks: "
                f"{' and '.join(words)} ({worst:.1f} K at steady state)"
            )
            found.append((worst, Advice("heat_balance", (entry.name,), text)))
    return worst_first(found)


def heat_missing(
    machine: Machine, observed: Observations
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Return the heat that parts with a thermometer get beside what the model gives them.

    Parameters
    ----------
    machine : Machine
    observed : Observations

    Returns
    -------
    missing : dict of str to array, each (nodes,)
        Mean [W] while ``running`` and while ``standing``; NaN without a thermometer that tells.
    conductance : array, shape (nodes,)
        To everything around each part, at most [W/K].

    Notes
    -----
    C dT/dt of the reading, less what flows by the model's conductances between the readings and
    what its sources give. Parts without a thermometer are as warm as the model has them.
    """
    index = machine.node_index
    shown = simulate(machine, observed.run.frame, at=observed.time_s, drive=observed.drive)
    warm = shown.temperatures[0].copy()
    read = np.zeros(len(machine.nodes), dtype=bool)
    for node, place in index.items():
        on_it = [s.name for s in machine.sensors if s.of == node and s.name in observed.channels]
        columns = observed.values[:, [observed.channels.index(name) for name in on_it]]
        if on_it and np.isfinite(columns).all():
            warm[:, place], read[place] = columns.mean(axis=1), True
    values = Values(machine.parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    gets, most = _flows(network, shown.inputs, warm)
    missing: dict[str, FloatArray] = {}
    for doing, stretches in _stretches(observed).items():
        energy, seconds = np.zeros(len(read)), 0.0
        for rows in stretches:
            time = observed.time_s[rows]
            stored = network.capacity[0] * (warm[rows[-1]] - warm[rows[0]])
            energy += stored - np.trapezoid(gets[rows], time, axis=0)
            seconds += float(time[-1] - time[0])
        if seconds > 0.0:
            # A thermometer in whole kelvin says little of a short stretch.
            blurred = network.capacity[0] * _step(machine) * len(stretches) / seconds
            sharp = read & (blurred < 0.5 * OFF_K * most)
            missing[doing] = np.where(sharp, energy / seconds, np.nan)
    return missing, most


def _step(machine: Machine) -> FloatArray:
    """Return the coarsest resolution of the thermometers on each part [K]."""
    found = np.zeros(len(machine.nodes))
    for sensor in machine.sensors:
        if sensor.of in machine.node_index:
            at = machine.node_index[sensor.of]
            found[at] = max(found[at], sensor.resolution)
    return found


def _flows(
    network: Network, inputs: dict[str, FloatArray], warm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what every part gets at every instant [W], and its largest conductance [W/K]."""
    outside = np.stack([inputs[name] for name in network.machine.boundary_index], axis=1)
    gets = network.heat(inputs)[0] + np.zeros_like(warm)
    driving = [inputs[name] for name in network.conductance_inputs]
    levels = np.stack(driving, axis=1) if driving else np.zeros((len(warm), 0))
    most = np.zeros(warm.shape[1])
    for level in np.unique(levels, axis=0):
        rows = np.flatnonzero(np.all(levels == level, axis=1))
        at = {name: values[rows[:1]] for name, values in inputs.items()}
        matrix, boundary = (part[0] for part in network.conductances(at))
        gets[rows] += outside[rows] @ boundary.T - warm[rows] @ matrix.T
        most = np.maximum(most, np.diag(matrix))
    if not network.linear and not network.state_count:
        none = np.zeros((1, len(warm), 0))
        gets += network.dependent(inputs, outside, warm[None], none)[0][0]
    return gets, most


def _stretches(observed: Observations) -> dict[str, list[npt.NDArray[np.int64]]]:
    """Return the rows of every stretch in which the machine runs, and in which it stands."""
    found: dict[str, list[npt.NDArray[np.int64]]] = {}
    for start, end, regime in regimes(observed):
        rows = np.flatnonzero((observed.time_s >= start) & (observed.time_s <= end))
        if len(rows) > 1:
            found.setdefault("standing" if "standing" in regime else "running", []).append(rows)
    return found
