"""Sparse identification of the residual's dynamics (pysindy's STLSQ, bagged). [1]_

A state is the residual of one thermometer e(t) [K], measured minus calibrated model, smoothed over
half an hour. It is driven by a library of the heat terms that effects of the catalogue stand for,
computed from the inputs and the temperatures of the calibrated model, each scaled to a standard
deviation of one: de/dt = a e + sum c_j u_j(t). Every thermometer has an equation of its own, since
all of them as one state gave equations that ran away. Threshold and ridge are those with which the
equations of the other runs follow a left-out run best. An effect is named if its term keeps a
coefficient in more than half of the bags. What is left on the held-out run is the residual less
e(t), simulated from zero.

It cannot name what moves the nose without heat, nor a broken sensor, since the library of a method
that looks for equations of motion has no term for these.

.. [1] S. L. Brunton, J. L. Proctor and J. N. Kutz, Discovering governing equations from data by
   sparse identification of nonlinear dynamical systems, PNAS 113 (2016) 3932-3937,
   doi:10.1073/pnas.1517384113. A. A. Kaptanoglu et al., PySINDy: a comprehensive Python package for
   robust sparse system identification, JOSS 7 (2022) 3994, doi:10.21105/joss.03994.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import pysindy as ps
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from benchmarks.gap.rivals.question import Question, Told
from gap_finder.linearise import simulate_at
from gap_finder.observations import BIN_S, Observations
from gap_finder.regimes import RunResiduals, residuals
from plant_model.machine import Machine
from plant_model.sensors import displacement_names

Array = NDArray[np.float64]

TITLE = "Sparse identification (pysindy)"
SMOOTHED_S = 1800.0
THRESHOLDS = (0.01, 0.03, 0.1, 0.3, 1.0)
"""Of coefficients [K/h for a term's standard deviation]."""
RIDGES = (1.0, 30.0)
BAGS = 20
INCLUDED = 0.5


def answer(question: Question) -> Told:
    """Identify the dynamics on the calibration runs."""
    known = [residuals(question.machine, one) for one in question.observed]
    lengths = displacement_names(question.machine)
    count = sum(name not in lengths for name in known[0].observed.channels)
    states = [_smooth(-one.values[:, :count]) for one in known]
    terms = [heat_terms(question.machine, one) for one in question.observed]
    names = [name for name in terms[0] if name not in question.without]
    drives, scale = _scaled([np.column_stack([one[n] for n in names]) for one in terms])
    choice = min(
        product(THRESHOLDS, RIDGES), key=lambda one: _left_out(states, drives, Choice(*one))
    )
    coefficients = identified(states, drives, Choice(*choice), BAGS)
    size = np.abs(coefficients[:, 1:]).max(axis=0)
    named = [names[j] for j in np.argsort(-size) if size[j] > 0.0]
    left = []
    for one in question.left:
        own = heat_terms(question.machine, one.observed)
        drive = np.column_stack([own[n] for n in names]) / scale
        values = one.values.copy()
        values[:, :count] += simulated(coefficients, drive)
        left.append(RunResiduals(one.observed, values))
    return Told(named, left, Choice(*choice)._asdict())


class Choice(NamedTuple):
    """What coefficients must reach [K/h], and the ridge of their regression."""

    threshold: float
    ridge: float


def heat_terms(machine: Machine, observed: Observations) -> dict[str, Array]:
    """Return the heat terms of a run by the effect that they stand for, each (K,)."""
    result = simulate_at(machine, observed)
    node = {name: result.temperatures[0, 1:, i] for name, i in machine.node_index.items()}
    time, frame = observed.time_s, observed.run.frame

    def at(column: str) -> Array:
        if column not in frame:
            return np.zeros_like(time)
        return np.interp(time, frame["time_s"], frame[column].ffill().bfill())

    n = at("speed_rpm") / 20e3
    air, coolant, torque = at("T5_degC"), at("T9_degC"), at("torque_Nm")
    inner, outer = node["front_inner"], node["front_outer"]
    surface, jacket = node["housing_front_xm"], node["jacket_front"]
    palmgren = n ** (5.0 / 3.0)
    turned_h = np.concatenate([[0.0], np.cumsum(np.diff(time) * (n[:-1] > 0.0))]) / 3600.0
    warmer = surface - air
    return {
        "viscosity_temperature": palmgren * (inner - 25.0),
        "thermal_preload": n * np.maximum(inner - outer, 0.0),
        "friction_speed_exponent": palmgren * np.log(np.maximum(n, 1e-3)),
        "bearing_run_in": palmgren * np.exp(-turned_h / 2.0),
        "joint_resistance": (outer - surface) ** 2,
        "motor_iron_loss": n**2,
        "windage": n**3,
        "copper_loss": torque**2,
        "cutting_heat": np.abs(torque) * n,
        "forced_convection": n**0.7 * warmer,
        "natural_convection": np.abs(warmer) ** 0.25 * warmer,
        "radiation": (surface + 273.15) ** 4 - (air + 273.15) ** 4,
        "coolant_degradation": time / 3600.0 * (jacket - coolant),
        "coolant_supply_offset": np.ones_like(time),
        "tool_heating": node["shaft_front"] - air,
    }


def identified(
    states: Sequence[Array], drives: Sequence[Array], choice: Choice, bags: int = 1
) -> Array:
    """Return the coefficients of every state's equation.

    Parameters
    ----------
    states : sequence of array, each (K, S)
        [K], a sample a minute.
    drives : sequence of array, each (K, U)
    choice : Choice
    bags : int
        Data sets drawn anew from the samples; one for all samples as they are.

    Returns
    -------
    array, shape (S, 1 + U)
        Of the state [1/h] and of the drives [K/h]; with bags their median, zero where fewer than
        half of the bags keep it.
    """
    single = range(states[0].shape[1])
    return np.array([_equation([x[:, [i]] for x in states], drives, choice, bags) for i in single])


def _equation(states: Sequence[Array], drives: Sequence[Array], choice: Choice, bags: int) -> Array:
    optimizer = ps.STLSQ(threshold=choice.threshold, alpha=choice.ridge)
    if bags > 1:
        optimizer = ps.EnsembleOptimizer(optimizer, bagging=True, n_models=bags)
    model = ps.SINDy(
        optimizer=optimizer,
        feature_library=ps.IdentityLibrary(),
        differentiation_method=ps.FiniteDifference(),
    )
    with warnings.catch_warnings():
        # That nothing is left above a threshold is an answer, too.
        warnings.simplefilter("ignore")
        np.random.seed(0)  # noqa: NPY002 - the bags are drawn from numpy's own state
        model.fit(list(states), t=BIN_S / 3600.0, u=list(drives))
    if bags == 1:
        return np.asarray(model.coefficients()[0])
    every = np.array(optimizer.coef_list)[:, 0]
    lasting = np.mean(every != 0.0, axis=0) > INCLUDED
    return np.where(lasting, np.median(every, axis=0), 0.0)


def simulated(coefficients: Array, drive: Array) -> Array:
    """Return e(t) from zero, exact for drives that hold their value, shape (K, S)."""
    step = BIN_S / 3600.0
    rate, heating = coefficients[:, 0], drive @ coefficients[:, 1:].T
    growth = np.exp(rate * step)
    # The integral of the growth over a step; of its series where the rate is all but zero.
    share = np.where(np.abs(rate) < 1e-9, step, np.expm1(rate * step) / np.where(rate, rate, 1.0))
    out = np.zeros_like(heating)
    for k in range(len(drive) - 1):
        # A model that runs away is wrong enough at 100 K.
        out[k + 1] = np.clip(growth * out[k] + share * heating[k], -100.0, 100.0)
    return out


def _left_out(states: Sequence[Array], drives: Sequence[Array], choice: Choice) -> float:
    """Return the squared error of each run as the equations of the others simulate it."""
    total = 0.0
    for k, (state, drive) in enumerate(zip(states, drives, strict=True)):
        others = [i for i in range(len(states)) if i != k]
        coefficients = identified([states[i] for i in others], [drives[i] for i in others], choice)
        total += float(np.sum((state - simulated(coefficients, drive)) ** 2))
    return total


def _smooth(values: Array) -> Array:
    filled = np.nan_to_num(values)
    return np.asarray(gaussian_filter1d(filled, SMOOTHED_S / BIN_S / 2.0, axis=0))


def _scaled(drives: list[Array]) -> tuple[list[Array], Array]:
    together = np.concatenate(drives)
    spread = together.std(axis=0)
    scale = np.where(spread > 1e-9, spread, np.maximum(np.abs(together).max(axis=0), 1e-9))
    return [drive / scale for drive in drives], scale
