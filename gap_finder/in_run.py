"""A machine as it is in one run: what has not begun yet, its own values, where laws start.

The model starts a law that lags the hall settled, because a run file goes back no further. But the
hall swings daily, and the law is behind by as much as its lag lets it be: an unknown of every run,
like the starting temperatures of the parts, that decays with the law's own time constant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gap_finder.observations import Observations
from plant_model.effect_names import name_of
from plant_model.effects import Effect, catalogue
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.sensors import readings
from plant_model.structure import pose

SWING_K = 2.0
"""Standard deviation of a hall's daily swing [K]: three kelvin to either side are usual. Set on one
machine outside the benchmark, a gantry, where 1 K costs the right law 7 of its score."""

DAILY = 2.0 * np.pi / 86400.0
"""Its angular frequency, given by the day [1/s]."""


def machine_in_run(
    machine: Machine, observed: Observations
) -> tuple[Machine, dict[str, FloatArray]]:
    """Return the machine without effects that had not begun in a run, and the run's own values.

    Parameters
    ----------
    machine : Machine
    observed : Observations

    Returns
    -------
    machine : Machine
    own : dict of str to array, shape (1,)
        Parameters by full name.
    """
    if observed.absent & machine.effects.keys():
        kept = {key: p for key, p in machine.effects.items() if key not in observed.absent}
        machine = replace(machine, effects=kept)
    own = {name: np.array([v]) for name, v in observed.own.items() if name in machine.parameters}
    return machine, own


def given_in_run(
    parameters: Mapping[str, FloatArray] | None, observed: Observations
) -> dict[str, FloatArray]:
    """Return parameter sets without those of effects that had not begun in a run."""
    absent = tuple(f"effects.{key}." for key in observed.absent)
    return {name: v for name, v in (parameters or {}).items() if not name.startswith(absent)}


def shown_per_kelvin(
    machine: Machine, effects: Sequence[Effect], network: Network, channels: Sequence[str]
) -> FloatArray:
    """Return each channel's reading per kelvin of each part and per own state, (sets, size, C)."""
    slices = network.state_slices()
    nodes, size = network.node_count, network.node_count + network.state_count
    inputs = {entry.name: np.zeros(size + 1) for entry in machine.inputs}
    unit = np.concatenate([np.zeros((1, size)), np.eye(size)])
    unit = np.broadcast_to(unit, (network.sets, *unit.shape))
    rise, states = unit[..., :nodes], unit[..., nodes:]
    moved = pose(effects, slices, inputs, rise, states)
    seen = readings(machine, effects, slices, inputs, np.zeros(size + 1), rise, states, moved)
    shown = np.stack([seen[name] for name in channels], axis=-1)
    return np.asarray(shown[:, 1:] - shown[:, :1])


def start_responses(
    machine: Machine,
    observed: Observations,
    parameters: Mapping[str, FloatArray] | None = None,
) -> tuple[FloatArray, dict[str, float]]:
    """Return the response of a run to where each lagging law starts, one standard deviation each.

    Parameters
    ----------
    machine : Machine
    observed : Observations
    parameters : mapping of str to array, shape (sets,), optional
        Values instead of the machine's, by full name.

    Returns
    -------
    responses : array, shape (sets or 1, laws, K, C)
        [K, um]
    deviations : dict of str to float
        The first set's standard deviation of each law, by key [K]. A law with the time constant tau
        is behind a swing with the angular frequency w by w tau / sqrt(1 + (w tau)^2) of it.
    """
    in_run, own = machine_in_run(machine, observed)
    if not any(_lags_from_start(catalogue()[name_of(key)]) for key in in_run.effects):
        return np.zeros((1, 0, *observed.weights.shape)), {}  # as for most machines, at once
    values = Values(in_run.parameters, given_in_run(parameters, observed) | own, bounded=False)
    effects = effects_in_force(in_run, values)
    lagging = [effect.key for effect in effects if _lags_from_start(effect)]
    network = Network(in_run, values, effects)
    states = [network.state_slices()[key].start for key in lagging]
    rates = network.state_decay()[:, states, None]
    shown = shown_per_kelvin(in_run, effects, network, observed.channels)
    since_s = observed.time_s - observed.run.time_s[0]
    behind_k = SWING_K * DAILY / np.hypot(rates, DAILY)
    settles = behind_k * -np.expm1(-rates * since_s)
    responses = settles[..., None] * shown[:, network.node_count :][:, states, None]
    return responses, dict(zip(lagging, behind_k[0, :, 0].tolist(), strict=True))


def _lags_from_start(effect: Effect | type[Effect]) -> bool:
    return effect.lags and "at_start" in effect.states


def likely_starts(
    machine: Machine, observed: Observations, shown: FloatArray
) -> tuple[FloatArray, dict[str, float]]:
    """Return what a model lacks because its laws start settled, and how far each is behind.

    Parameters
    ----------
    machine : Machine
    observed : Observations
    shown : array, shape (K, C)
        The model's channels [K, um].

    Returns
    -------
    moved : array, shape (K, C)
        To be added to the channels [K, um].
    behind : dict of str to float
        By how much each law is colder at the start than what it follows, by key [K].
    """
    (responses,), deviations = start_responses(machine, observed)
    columns = observed.response(responses).T
    inner = columns.T @ columns + np.eye(len(responses))
    start = -np.linalg.solve(inner, columns.T @ observed.weighted(shown))
    pairs = zip(start.tolist(), deviations.items(), strict=True)
    return np.tensordot(start, responses, 1), {key: s * sd for s, (key, sd) in pairs}
