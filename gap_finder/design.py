"""The responses of the runs to everything that may be wrong, computed once as design matrices.

The columns, each scaled to one prior standard deviation: parameters that calibration moves;
parameters that it does not move but that are known only to a range; constant errors of
thermometers; where in a part a thermometer sits; how much each part's warming moves each
displacement; heat that bypasses the single temperature of a part. Unknowns of one run (zeros,
starting temperatures) are eliminated within that run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations, repeat

import numpy as np
import numpy.typing as npt

from gap_finder.added_paths import AddedPath, path_answers
from gap_finder.directions import fewer
from gap_finder.likelihood import in_units, robust_weights
from gap_finder.linearise import (
    Linearisation,
    bias_columns,
    linear_about,
    modelled,
    nuisance_columns,
    simulate_at,
)
from gap_finder.observations import INDEPENDENT_S, Observations
from gap_finder.priors import Priors
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.simulate import Simulation

PLACE_SHARE = 0.05
"""Share of a neighbouring part's temperature that a thermometer may read (one sd) [1]: beyond two
it is misplaced, see `kinds.sensor_place`. Set on the thirty-second split (belt 0022), where 0.1
absorbed a misplaced thermometer."""

PASSING_SHARE = 0.5
"""Share of the heat that a neighbour would pass on through a part without mass that may bypass its
single temperature (one sd) [1]: in a large part, what touches it close by is warmed first. Set on
one machine of the fifth split (lathe 0000, nothing hidden)."""

LEAST_SLOW = 0.1
"""A part has a single temperature if delay / (delay + `INDEPENDENT_S`) is below this [1]: most
cells of a page are that quick, and would be a thousand columns. Set for time, on no data."""

ROUNDING_SHARE = 1e-9
"""Share of a response's squares that is rounding [1]: given by sums of thousands of doubles."""

LEVER_SHARE = 0.01
"""Error of each part's effect on a displacement, as a share of its range (one sd) [1]; set on no
data."""


@dataclass(frozen=True)
class RunSensitivities:
    """Weighted derivatives of one run that no effect changes much; computed once.

    Attributes
    ----------
    nuisance : array, shape (N, O)
        By the run's own unknowns (zeros, starting temperatures, switches), in fewer directions.
    starts : array, shape (N, nodes)
        By the starting temperatures, which ``nuisance`` includes.
    other : array, shape (N, Q)
        By parameters that calibration does not move, errors, places, levers and bypassing heat.
    weight : array, shape (N,)
        Robust square-root weight.
    """

    nuisance: FloatArray
    starts: FloatArray
    other: FloatArray
    weight: FloatArray


def sensitivities_of(machine: Machine, observed: Observations, fixed: Priors) -> RunSensitivities:
    """Compute a run's derivatives about a calibrated machine, with all columns of ``other``."""
    (by_fixed,) = linear_about(machine, [observed], fixed, fixed.position(machine))
    errors = bias_columns(observed)
    simulated = simulate_at(machine, observed)
    places = _place_columns(machine, observed, simulated)
    levers = _lever_columns(observed, simulated)
    passing = path_answers(machine, observed, passing_paths(machine))
    passed = observed.columns([change[0] for change in passing])
    nuisance = nuisance_columns(machine, observed)
    return RunSensitivities(
        fewer([nuisance])[0],
        nuisance[:, nuisance.shape[1] - len(machine.nodes) :],
        np.hstack([by_fixed.by_parameter, errors, places, levers, passed]),
        robust_weights(by_fixed.residual),
    )


def all_sensitivities(
    calibrated: Machine, observed: Sequence[Observations], pool: Executor | None = None
) -> list[RunSensitivities]:
    """Compute the derivatives of every run about a calibrated machine.

    ``other`` keeps only the directions that change something in these runs. With a pool, runs are
    computed in its processes.
    """
    fixed = Priors.of(calibrated, calibrated=False)
    over_runs = pool.map if pool else map
    parts = list(over_runs(sensitivities_of, repeat(calibrated), observed, repeat(fixed)))
    others = fewer([part.other for part in parts])
    return [replace(part, other=other) for part, other in zip(parts, others, strict=True)]


@dataclass(frozen=True)
class RunDesign:
    """Residual, shared columns and nuisance columns of one run, weighted.

    Attributes
    ----------
    residual : array, shape (N,)
    shared : array, shape (N, Q)
        Unknowns common to all runs; those that calibration moves come first.
    nuisance : array, shape (N, O)
    weight : array, shape (N,)
        Robust square-root weight in the channels' units, already applied to all of them.
    alone : tuple of int
        Parameters that no other run depends on: their columns are the last of ``nuisance``, and 0
        in ``shared``.
    """

    residual: FloatArray
    shared: FloatArray
    nuisance: FloatArray
    weight: FloatArray
    alone: tuple[int, ...] = ()

    @cached_property
    def _inner(self) -> FloatArray:
        """Normal matrix of the nuisance parameters with their prior, (O, O)."""
        return np.asarray(self.nuisance.T @ self.nuisance + np.eye(self.nuisance.shape[1]))

    def cleaned(self, columns: FloatArray) -> FloatArray:
        """Return columns (N, m) minus what nuisance parameters can imitate under their prior."""
        return columns - self.nuisance @ np.linalg.solve(self._inner, self.nuisance.T @ columns)

    def deviations_alone(self, covariance: FloatArray) -> FloatArray:
        """Return standard deviations of the parameters that only this run depends on, (alone,).

        Parameters
        ----------
        covariance : array, shape (Q, Q)
            Of the shared unknowns, over all runs.
        """
        inner = np.linalg.inv(self._inner)
        by_shared = inner @ (self.nuisance.T @ self.shared)
        variance = np.diag(inner) + np.sum((by_shared @ covariance) * by_shared, axis=1)
        return np.asarray(np.sqrt(variance[len(variance) - len(self.alone) :]))


def design_of(
    parts: Sequence[Linearisation],
    sensitivities: Sequence[RunSensitivities],
    units: FloatArray,
) -> list[RunDesign]:
    """Return the design of every run about a calibrated machine, with channels in *units*, (C,)."""
    squares = np.array([np.sum(part.by_parameter**2, axis=0) for part in parts])
    designs = []
    for part, of_run, mine in zip(parts, sensitivities, told_by_one_run(squares), strict=True):
        weight, alone = in_units(of_run.weight, units), np.flatnonzero(mine).tolist()
        shared = np.hstack([part.by_parameter, of_run.other])
        # A parameter that only this run depends on is its own unknown, like a zero.
        own = np.hstack([of_run.nuisance, part.by_start, shared[:, alone]])
        shared[:, alone] = 0.0
        columns = (part.residual * weight, shared * weight[:, None], own * weight[:, None], weight)
        designs.append(RunDesign(*columns, tuple(alone)))
    return designs


def told_by_one_run(squares: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which run is the only one that depends on an unknown, shape (R, Q).

    Parameters
    ----------
    squares : array, shape (R, Q)
        Of each run's response to each unknown.
    """
    return np.asarray((squares > 0.0) & (squares.sum(axis=0) - squares <= ROUNDING_SHARE * squares))


def _place_columns(machine: Machine, observed: Observations, simulated: Simulation) -> FloatArray:
    """Return the response to thermometers that partly read a neighbour of their part, (N, m)."""
    index = machine.node_index
    temperatures = simulated.temperatures[0, 1:]
    columns = []
    for sensor in machine.sensors:
        if sensor.of not in index or sensor.name not in observed.channels:
            continue
        channel = observed.channels.index(sensor.name)
        for item in machine.items:
            pair = item.refs.get("between", ())
            if sensor.of not in pair or item.kind == "coolant_unevenness":
                continue
            (other,) = (name for name in pair if name != sensor.of)
            if other in index:
                difference = temperatures[:, index[other]] - temperatures[:, index[sensor.of]]
                columns.append(observed.response_in(channel, PLACE_SHARE * difference))
    return observed.columns(columns)


def passing_paths(machine: Machine) -> list[AddedPath]:
    """Return paths by which heat bypasses the single temperature of a part, one sd each.

    Heat from one neighbour reaches the part's other neighbours at once, in proportion to their
    conductances, with the steady flow through a part without mass. The quicker a part evens out
    compared with the time that a misfit lasts (`INDEPENDENT_S`), the less heat bypasses it.
    """
    joined: dict[str, dict[str, float]] = {node.name: defaultdict(float) for node in machine.nodes}
    for item in machine.of_kind("links", "conduction", "contact"):
        for near, far in permutations(item.refs["between"]):
            joined[near][far] += machine.parameters[f"links.{item.name}.conductance"].value
    paths = []
    for node in machine.nodes:
        around = {part: g for part, g in sorted(joined[node.name].items()) if g > 0.0}
        total = sum(around.values())
        if len(around) < 2:
            continue
        delay_s = node.capacity.value / total
        slow = delay_s / (delay_s + INDEPENDENT_S)
        if slow < LEAST_SLOW:
            continue
        # Two neighbours are one path, in either direction.
        for part in list(around)[: 1 if len(around) == 2 else None]:
            others = {name: g / (total - around[part]) for name, g in around.items()}
            del others[part]
            steady = around[part] * (total - around[part]) / total
            paths.append(
                AddedPath(
                    (part, *others), (PASSING_SHARE * slow * steady,), shares=(*others.values(),)
                )
            )
    return paths


def _lever_columns(observed: Observations, simulated: Simulation) -> FloatArray:
    """Return the response to parts that move a displacement more than modelled, (N, m)."""
    base = modelled(simulated, observed)[0]
    rise = simulated.temperatures[0, 1:] - simulated.temperatures[0, 0]
    columns = []
    for channel in np.flatnonzero(observed.lengths).tolist():
        spread = np.ptp(base[:, channel])
        for node in range(rise.shape[1]):
            size = max(float(np.max(np.abs(rise[:, node]))), 1e-3)
            lever = rise[:, node] / size * LEVER_SHARE * spread
            columns.append(observed.response_in(channel, lever))
    return observed.columns(columns)
