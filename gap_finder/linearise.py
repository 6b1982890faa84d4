"""Weighted residuals of observations and their derivatives by parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap_finder.in_run import given_in_run, machine_in_run, start_responses
from gap_finder.observations import Observations
from gap_finder.priors import Priors
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.simulate import Driven, Simulation, simulate_all

DIFFERENCE = 0.005
"""Step of the numerical derivative, in standard deviations of the prior: short beside the usual
range of an effect's parameter, whose prior is ten times as wide. Set on no data."""

OFFSET_UM = 30.0
"""Standard deviation of a displacement channel's zero in each run [um]: large, because a run may
start with the spindle turning, and the file does not say when the sensor was zeroed. Set on no
data."""

START_K = 0.3
"""Standard deviation of each node's temperature at the start of a run [K]; set on no data."""

BIAS_K = 0.15
"""Standard deviation of a thermometer's error common to all runs, from mounting and calibration
[K]; set on no data."""


def simulate_at(
    machine: Machine,
    observed: Observations,
    parameters: Mapping[str, FloatArray] | None = None,
    start: FloatArray | None = None,
    *,
    near: bool = False,
) -> Simulation:
    """Simulate a run at its first row and then at the instants of its observations.

    Parameters
    ----------
    machine : Machine
    observed : Observations
        Effects that had not begun in its run are left out.
    parameters : mapping of str to array, shape (sets,), optional
        Values instead of the machine's, by full name; the run's own values take precedence.
    start : array, optional
        Temperatures of the nodes at the start [degC]; by default as in the machine file.
    near : bool
        Step all sets to first order about the first.

    Returns
    -------
    Simulation
        At K + 1 instants.
    """
    return simulate_runs(machine, [observed], parameters, start, near=near)[0]


def simulate_runs(
    machine: Machine,
    observed: Sequence[Observations],
    parameters: Mapping[str, FloatArray] | None = None,
    start: FloatArray | None = None,
    *,
    near: bool = False,
) -> list[Simulation]:
    """Simulate several runs, as :func:`simulate_at` does one; similar runs are stepped together.

    Parameters
    ----------
    machine, parameters, near
        As in :func:`simulate_at`.
    observed : sequence of Observations
    start : array, shape (sets or 1, nodes), optional
        Starting temperatures, instead of those that the runs give [degC].

    Returns
    -------
    list of Simulation
        One for each run.
    """
    alike: dict[object, list[int]] = {}
    for i, run in enumerate(observed):
        alike.setdefault((run.absent, *sorted(run.own.items())), []).append(i)
    simulations: dict[int, Simulation] = {}
    for places in alike.values():
        first = observed[places[0]]
        in_force, own = machine_in_run(machine, first)
        given = given_in_run(parameters, first)
        runs = [
            Driven(run.run.frame, run.drive, np.append(run.run.time_s[0], run.time_s), start)
            for run in (observed[i] for i in places)
        ]
        shown = simulate_all(in_force, runs, given | own, bounded=False, near=near)
        simulations |= dict(zip(places, shown, strict=True))
    return [simulations[i] for i in range(len(observed))]


def modelled(simulation: Simulation, observed: Observations) -> FloatArray:
    """Return the channels of a simulation, shape (sets, K, C), displacements from their zero.

    Parameters
    ----------
    simulation : Simulation
        At the run's first row and then at the K instants.
    observed : Observations

    Returns
    -------
    array, shape (sets, K, C)
        [degC, um]
    """
    shown = np.stack([simulation.readings[name] for name in observed.channels], axis=-1)
    zeroed = np.flatnonzero(observed.lengths)
    instants = np.append(observed.run.time_s[0], observed.time_s)
    at = np.interp(observed.zero_s[zeroed], instants, np.arange(len(instants)))
    before, share = np.floor(at).astype(int), at % 1.0
    after = np.minimum(before + 1, len(instants) - 1)
    zero = shown[:, before, zeroed] * (1.0 - share) + shown[:, after, zeroed] * share
    shown[..., zeroed] -= zero[:, None]
    return shown[:, 1:]


@dataclass(frozen=True)
class Linearisation:
    """Weighted residual and derivatives of a run at a point.

    Attributes
    ----------
    residual : array, shape (N,)
        Model minus measurement.
    by_parameter : array, shape (N, P)
        Derivatives in the fitting scale of the priors.
    by_start : array, shape (N, laws)
        Derivatives by where each lagging law starts, one prior standard deviation each.
    by_both : array, shape (P, N, laws)
        Derivatives of these by the parameters.
    """

    residual: FloatArray
    by_parameter: FloatArray
    by_start: FloatArray
    by_both: FloatArray

    def about_start(self, start: FloatArray) -> Linearisation:
        """Return it with the parameters' derivatives where the laws start there, (laws,)."""
        return replace(self, by_parameter=self.by_parameter + (self.by_both @ start).T)


def residuals_of(
    machine: Machine,
    observed: Sequence[Observations],
    parameters: Mapping[str, FloatArray],
    *,
    near: bool = False,
) -> list[FloatArray]:
    """Return the weighted residuals of every run, each (sets, N)."""
    shown = simulate_runs(machine, observed, parameters, near=near)
    pairs = zip(observed, shown, strict=True)
    return [run.weighted(modelled(simulated, run)) for run, simulated in pairs]


def points_of(
    machine: Machine, observed: Sequence[Observations], priors: Priors, points: FloatArray
) -> list[list[Linearisation]]:
    """Return every run at several points, (S, P), of the fitting scale, without derivatives by it.

    Returns
    -------
    list of list of Linearisation
        By run and point; NaN at points from which the machine cannot be stepped.
    """
    values = priors.values(points)
    try:
        residuals = residuals_of(machine, observed, values)
    except IntegrationError:  # A single extreme point stops all of them.
        if len(points) == 1:
            residuals = [np.full((1, run.weights.size), np.nan) for run in observed]
        else:
            each = [points_of(machine, observed, priors, point[None]) for point in points]
            return [[one for (one,) in of_run] for of_run in zip(*each, strict=True)]
    runs = []
    for run, left in zip(observed, residuals, strict=True):
        starts = _by_starts(machine, run, values, len(points))
        none = np.zeros((left.shape[1], 0)), np.zeros((0, *starts.shape[1:]))
        runs.append(
            [Linearisation(r, none[0], s, none[1]) for r, s in zip(left, starts, strict=True)]
        )
    return runs


def linear_about(
    machine: Machine, observed: Sequence[Observations], priors: Priors, point: FloatArray
) -> list[Linearisation]:
    """Linearise every run about a point, (P,), in the priors' fitting scale."""
    # A difference that would leave the physical range goes the other way.
    way = np.where(point + DIFFERENCE > priors.high, -DIFFERENCE, DIFFERENCE)
    sets = point + np.concatenate([np.zeros((1, len(way))), np.diag(way)])
    values = priors.values(sets)
    parts = []
    for run, left in zip(observed, residuals_of(machine, observed, values, near=True), strict=True):
        starts = _by_starts(machine, run, values, len(sets))
        by_parameter = ((left[1:] - left[0]) / way[:, None]).T
        by_both = (starts[1:] - starts[0]) / way[:, None, None]
        parts.append(Linearisation(left[0], by_parameter, starts[0], by_both))
    return parts


def _by_starts(
    machine: Machine, observed: Observations, parameters: Mapping[str, FloatArray], sets: int
) -> FloatArray:
    """Return a run's weighted response to where each lagging law starts, (sets, N, laws)."""
    responses, _ = start_responses(machine, observed, parameters)
    by_start = observed.response(responses).swapaxes(1, 2)
    return np.broadcast_to(by_start, (sets, *by_start.shape[1:]))


def nuisance_columns(machine: Machine, observed: Observations) -> FloatArray:
    """Return the columns of a run's own unknowns: zeros, unclear switches, starting temperatures.

    Returns
    -------
    array, shape (N, displacements + unclear switches + nodes)
        Weighted responses to one prior standard deviation each.
    """
    lengths = np.flatnonzero(observed.lengths).tolist()
    columns = [observed.response_in(channel, OFFSET_UM) for channel in lengths]
    base = simulate_at(machine, observed)
    at_start = base.temperatures[0, 0]
    starts = np.tile(at_start, (len(machine.nodes) + 1, 1))
    starts[1:] += START_K * np.eye(len(machine.nodes))
    answers = modelled(simulate_at(machine, observed, start=starts, near=True), observed)
    change = observed.response(answers[1:] - answers[0])
    for drive in observed.earlier:
        earlier = modelled(simulate_at(machine, replace(observed, drive=drive)), observed)
        columns.append(observed.response(earlier[0] - answers[0]))
    return np.hstack([observed.columns(columns), change.T])


def bias_columns(observed: Observations) -> FloatArray:
    """Return the response to each thermometer's constant error, (N, channels); 0 of lengths."""
    errors = np.where(observed.lengths, 0.0, BIAS_K).tolist()
    return observed.columns([observed.response_in(i, error) for i, error in enumerate(errors)])
