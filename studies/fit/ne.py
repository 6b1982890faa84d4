"""Natural exponential model of the effect of speed, restarted at every change of speed."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor, whole, within
from fmu_compensator.fit.training import Array, TrainingRun, row_weights
from measurement.errors import BadInput, refuse_other
from measurement.resampling import SLOW_S
from measurement.spectrum import SAME_SPEED_SHARE, STILL_RPM
from plant_model.parameters import ROOM_DEGC
from studies.finite_elements import FiniteElementSpindle, read_description
from studies.fit.by_run import RIDGE
from studies.fit.lagged import lagged, needed

SHORTEST_TAU_S, LONGEST_TAU_S = 60.0, 36_000.0
"""A minute to ten hours: a judgement, set on no data [s]."""
RATIOS = (0.5, 1.0, 2.0)
"""Ratios of the time constant at standstill to the one while turning: still air cools less, a
coolant that keeps flowing cools as before. Set on no data."""
STEADY = ("fitted", "fem")
TAU_OF = ("mass_kg", "specific_heat", "film", "surface_m2")


class NaturalExponential(FittedModel):
    """See its twin in the runtime for the equation.

    Parameters
    ----------
    speeds_rpm : array (s,)
        Speeds with their own steady drift [rpm].
    steady : array (m, s)
        Steady drift [um, urad].
    tau_s, tau_stopped_s : array (m,)
        Time constants [s].
    """

    title = "Natural exponential"
    by_temperature = False
    history = True

    def __init__(
        self, speeds_rpm: Array, steady: Array, tau_s: Array, tau_stopped_s: Array
    ) -> None:
        self.speeds_rpm, self.steady = speeds_rpm, steady
        self.tau_s, self.tau_stopped_s = tau_s, tau_stopped_s

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        knots: int = 5,
        tau_s: float | str | None = None,
        steady: str = "fitted",
        description: str = "jig_borer",
        mass_kg: float | None = None,
        specific_heat: float | None = None,
        film: float | None = None,
        surface_m2: float | None = None,
    ) -> NaturalExponential:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names; every run needs the speed.
        knots : int
            Maximum number of speeds with their own steady drift; it is linear between them.
        tau_s : float or "fem", optional
            The time constant, instead of fitting it [s]. ``fem``: the time until the growth of the
            finite-element spindle is within 1/e of its final value, warming up at the mean speed
            and cooling at standstill.
        mass_kg, specific_heat, film, surface_m2 : float, optional
            Instead of *tau_s*: tau = m c / (alpha S) [kg, J/(kg K), W/(m2 K), m2]. All four, or
            none.
        steady : {"fitted", "fem"}
            ``fem``: the steady growth is that of the finite-element spindle, unchanged for
            ``elongation`` and with a fitted factor for other targets.
        description : str
            Description of the finite-element spindle: the shipped one, or a file
            (docs/methods.md).

        Raises
        ------
        BadInput
            For a value that is not allowed, a run without speed, a spindle that never turns, or
            too few rows.
        """
        refuse_other("ne", "steady", steady, STEADY)
        refuse_poor(task)
        given = dict(zip(TAU_OF, (mass_kg, specific_heat, film, surface_m2), strict=True))
        for run in task.runs:
            if not np.isfinite(run.speed).any():
                raise BadInput(run.name, "speed_rpm", "is not known in every run: ne needs it")
        speeds = _knots(task, whole("ne", "knots", knots, 1, 20))
        runs = [run.at(needed(run, SLOW_S)) for run in task.runs]
        spindle = None
        if steady == "fem" or tau_s == "fem":
            spindle = FiniteElementSpindle(read_description(description))
        taus = _time_constants(task, tau_s, given, spindle)
        shape = None
        if steady == "fem":
            assert spindle is not None
            shape = np.array([spindle.zss(float(speed)) for speed in speeds])
        fits = [
            _fit_target(runs, speeds, target, taus, shape, is_shape=name == "elongation")
            for target, name in enumerate(task.target_names)
        ]
        return cls(
            speeds,
            np.array([steady for steady, _, _ in fits]),
            np.array([tau for _, tau, _ in fits]),
            np.array([stopped for _, _, stopped in fits]),
        )

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        names = ("speeds_rpm", "steady", "tau_s", "tau_stopped_s")
        return {name: getattr(self, name).tolist() for name in names}

    def report(self) -> dict[str, Any]:
        """Return the time constants and steady drifts."""
        return self.table()


def approach(time_s: Array, held: Array, knots: Array, tau_s: float, stopped_s: float) -> Array:
    """Return the fraction of each speed's steady drift that is reached, shape (n, knots) [1]."""
    corners = np.concatenate([[0.0], knots])
    # Linear interpolation between the knots is a weighted sum of hat functions.
    hats = np.column_stack(
        [
            np.interp(held, corners, np.eye(len(corners))[number])
            for number in range(1, len(corners))
        ]
    )
    elapsed = np.diff(time_s, prepend=time_s[0])
    return lagged(hats, elapsed, np.where(held >= STILL_RPM, tau_s, stopped_s))


def _knots(task: Task, most: int) -> Array:
    """Return the speeds seen in training, or quantiles if there are many."""
    speeds = np.concatenate([np.abs(run.speed) for run in task.runs])
    turning = np.sort(speeds[speeds >= STILL_RPM])
    if not len(turning):
        raise BadInput("training runs", "speed_rpm", "is never above 0: there is nothing to fit")
    different = _different(turning)
    if len(different) > most:
        different = _different(np.quantile(turning, np.linspace(0.0, 1.0, most)))
    return different


def _different(speeds: Array) -> Array:
    """Return the medians of sorted speeds that are the same, since a measured speed fluctuates."""
    same, medians, first = SAME_SPEED_SHARE * speeds[-1], [], 0
    while first < len(speeds):
        after = int(np.searchsorted(speeds, speeds[first] + same, side="right"))
        medians.append(np.median(speeds[first:after]))
        first = after
    return np.array(medians)


def time_constant(mass_kg: float, specific_heat: float, film: float, surface_m2: float) -> float:
    """Return tau = m c / (alpha S), the time constant of a body of uniform temperature [s]."""
    return mass_kg * specific_heat / (film * surface_m2)


def _time_constants(
    task: Task,
    tau_s: float | str | None,
    given: dict[str, float | None],
    spindle: FiniteElementSpindle | None,
) -> tuple[float, float] | None:
    """Return the time constants turning and at standstill [s]; None if they are to be fitted."""
    there = {name: value for name, value in given.items() if value is not None}
    if tau_s is not None and there:
        raise BadInput("ne", "tau_s", f"cannot stand beside {next(iter(there))}")
    if there and len(there) < len(TAU_OF):
        missing = next(name for name in TAU_OF if name not in there)
        raise BadInput("ne", missing, "is missing: tau = m c / (alpha S) needs all four")
    if there:
        checked = [within("ne", name, value, 1e-6, 1e9) for name, value in there.items()]
        tau = within("ne", "tau", time_constant(*checked), SHORTEST_TAU_S, LONGEST_TAU_S)
        return tau, tau
    if tau_s == "fem":
        assert spindle is not None
        speed = np.concatenate([np.abs(run.speed) for run in task.runs])
        mean = float(speed[np.isfinite(speed) & (speed > STILL_RPM)].mean())
        warm = spindle.steady(mean)
        return (
            _step_response(spindle, mean, np.full(len(warm), ROOM_DEGC)),
            _step_response(spindle, 0.0, warm),
        )
    if tau_s is None:
        return None
    tau = within("ne", "tau_s", tau_s, SHORTEST_TAU_S, LONGEST_TAU_S)
    return tau, tau


def _step_response(spindle: FiniteElementSpindle, speed: float, start: Array) -> float:
    """Return the time until growth from a start is within 1/e of its final value at a speed [s]."""
    time = np.arange(0.0, LONGEST_TAU_S, SHORTEST_TAU_S)
    run = spindle.transient(time, np.full(len(time), speed), ROOM_DEGC, ROOM_DEGC, start=start)
    goal = float(spindle.growth_row @ (spindle.steady(speed) - start))
    grown = np.maximum.accumulate(run.growth_um / goal)
    return float(np.interp(1.0 - np.exp(-1.0), grown, time))


def _fit_target(
    runs: list[TrainingRun],
    knots: Array,
    target: int,
    taus: tuple[float, float] | None,
    shape: Array | None,
    *,
    is_shape: bool,
) -> tuple[Array, float, float]:
    """Return steady drifts and the two time constants of one target.

    With *taus* these are not fitted; with *shape* the steady drifts are proportional to it, or
    equal to it if *is_shape*.
    """
    held = [run.held_speed for run in runs]
    y = np.concatenate([run.targets[run.known, target] for run in runs])
    root = np.sqrt(np.concatenate([row_weights(run.time_s[run.known]) for run in runs]))

    def solved(tau_s: float, stopped_s: float) -> tuple[float, Array]:
        x = np.concatenate(
            [
                approach(run.time_s, speed, knots, tau_s, stopped_s)[run.known]
                for run, speed in zip(runs, held, strict=True)
            ]
        )
        if shape is not None:
            x = (x @ shape)[:, None]
        gram = (root[:, None] * x).T @ (root[:, None] * x)
        moment = (root[:, None] * x).T @ (root * y)
        pull = RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram))
        steady = np.linalg.solve(gram + pull, moment)
        if shape is not None and is_shape:
            steady = np.ones(1)
        left = float(np.sum((root * (y - x @ steady)) ** 2))
        return left, steady if shape is None else steady[0] * shape

    def best_tau(ratio: float) -> tuple[float, float]:
        def cost(log_tau: float) -> float:
            tau = float(np.exp(log_tau))
            return solved(tau, ratio * tau)[0]

        grid = np.log(np.geomspace(SHORTEST_TAU_S, LONGEST_TAU_S, 9))
        costs = [cost(point) for point in grid]
        at = int(np.argmin(costs))
        minimum = minimize_scalar(
            cost,
            bounds=(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]),
            method="bounded",
            options={"xatol": 0.02},
        )
        return float(minimum.fun), float(np.exp(minimum.x))

    if taus is not None:
        return solved(*taus)[1], *taus
    stops = any((speed < STILL_RPM)[1:].any() for speed in held)
    tried = [(*best_tau(ratio), ratio) for ratio in (RATIOS if stops else (1.0,))]
    _, tau, ratio = min(tried)
    return solved(tau, ratio * tau)[1], tau, ratio * tau
