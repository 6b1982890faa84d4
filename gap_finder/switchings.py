"""Coolers switched by a part's temperature: the relay settings common to all runs' residuals.

For any setting, the readings of the part's thermometer determine when the relay was on. So settings
are compared without simulation: by how well the residuals follow the heat that resting coolant does
not carry away, with thermal lags. Only the best settings are simulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from gap_finder.observations import BIN_S, SHARP_S, Observations
from gap_finder.periods import MOST_TRIED, quick, without_slow
from gap_finder.reference import LAGS_MIN, LEAST_PREDICTED, lagged
from measurement.faults.series import valid
from plant_model.drive import Drive
from plant_model.effect_names import switched_by
from plant_model.effects.coolant_jacket import flows_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Values
from plant_model.sensors import column_of
from plant_model.simulate import Simulation

DEAD_BANDS = (0.3, 0.5, 0.8, 1.2, 1.8, 2.7, 4.0, 6.0)
"""Dead bands tried [K]; set on no data."""

LEVELS = tuple(np.linspace(0.05, 0.98, 40).tolist())
"""Levels at which the relay switches on, as shares of the part's temperature range in the runs
[1]."""

QUICK_MIN = LAGS_MIN[:5]
"""Time constants with which channels may follow the relay [min]: slower ones do not oscillate."""

SWITCHINGS, RUNS = 4, 2
"""Least number of switchings over all runs, and of runs with any: a cooler that only switches on
once as a machine warms cannot be told from other effects of warmth. Set on no data."""


@dataclass(frozen=True)
class Watched:
    """Readings of a part's thermometer in one run.

    Attributes
    ----------
    time_s, temperature : array, shape (T,)
        [s, degC]
    """

    time_s: FloatArray
    temperature: FloatArray

    def on_between(
        self, on_above: FloatArray, dead_band: FloatArray, ends: FloatArray
    ) -> FloatArray:
        """Return the share of each span in which relays are on, shape (settings, K).

        Parameters
        ----------
        on_above, dead_band : array, shape (settings,)
        ends : array, shape (K + 1,)
            Ends of consecutive spans [s].
        """
        on = relay(self.temperature, on_above, dead_band)
        steps = np.diff(self.time_s, append=self.time_s[-1])
        since = np.concatenate([np.zeros((len(on), 1)), np.cumsum(on * steps, axis=1)], axis=1)
        at = np.append(self.time_s, max(float(ends[-1]), float(self.time_s[-1])) + 1.0)
        since[:, -1] = since[:, -2] + on[:, -1] * (at[-1] - at[-2])
        on_until = np.array([np.interp(ends, at, on_s) for on_s in since])
        return np.asarray(np.diff(on_until, axis=1) / np.maximum(np.diff(ends), 1e-9))


@dataclass(frozen=True)
class Relay:
    """A relay in one run, switched by the readings of its part's thermometer.

    Attributes
    ----------
    watched : Watched
    on_above, dead_band : float
        [degC, K]
    """

    watched: Watched
    on_above: float
    dead_band: float

    def marked(self, observed: Observations, key: str) -> Observations:
        """Return observations with the relay's state added to the inputs of an effect."""
        return observed.with_series(switched_by(key), self._in_steps)

    def _in_steps(self, drive: Drive) -> FloatArray:
        setting = (np.array([self.on_above]), np.array([self.dead_band]))
        (on,) = self.watched.on_between(*setting, drive.grid)
        # The state at the end of a step applies to the next one.
        return np.append(on[1:], on[-1])


@dataclass(frozen=True)
class Switching:
    """A part that may switch a cooler.

    Attributes
    ----------
    part : str
    relays : tuple of Relay
        One for each run, all at the same setting.
    share : float
        Share of the quick residuals that follows it [1].
    """

    part: str
    relays: tuple[Relay, ...]
    share: float


def watched(machine: Machine, observed: Observations, part: str) -> Watched | None:
    """Return the readings of a part's thermometer in a run; None if there are none.

    Parameters
    ----------
    machine : Machine
    observed : Observations
    part : str
    """
    run = observed.run
    for sensor in machine.sensors:
        column = column_of(machine, sensor.name)
        if sensor.of != part or sensor.name not in observed.channels or column not in run.frame:
            continue
        rows, values = valid(run, column)
        if len(rows) > 1:
            time = run.time_s[rows]
            which = np.floor((time - time[0]) / SHARP_S)
            _, first, counts = np.unique(which, return_index=True, return_counts=True)
            return Watched(time[first], np.add.reduceat(values, first) / counts)
    return None


def carried_away(machine: Machine, simulated: Simulation, observed: Observations) -> FloatArray:
    """Return the heat that coolant carries away at the observations [W], shape (K,).

    Parameters
    ----------
    machine : Machine
    simulated : Simulation
        Of one parameter set, at the run's first row and then at the K observations.
    observed : Observations
    """
    inputs = observed.drive.inputs_at(observed.time_s)
    temperatures = simulated.temperatures[:, 1:]
    heat = np.zeros((1, len(observed.time_s)))
    for flow in flows_of(machine, Values(machine.parameters)):
        heat += flow.conductance * np.maximum(-flow.warmer(machine, inputs, temperatures), 0.0)
    return np.asarray(heat[0])


def likely_switchings(
    machine: Machine,
    observed: Sequence[Observations],
    residuals: Sequence[FloatArray],
    carried: Sequence[FloatArray],
    parts: Sequence[str],
) -> list[Switching]:
    """Return the parts and relay settings that the residuals of all runs follow best.

    Parameters
    ----------
    machine : Machine
    observed : sequence of Observations
    residuals : sequence of array, each (N,)
        Model minus measurement, weighted.
    carried : sequence of array, each (K,)
        Modelled heat that coolant carries away at the observations [W].
    parts : sequence of str
        Parts that may switch the cooler.

    Returns
    -------
    list of Switching
        Best first, at most `MOST_TRIED`; empty if no repeated change in the residuals follows any
        of them.
    """
    shown = np.concatenate(
        [
            quick(run, residual).reshape(len(run.time_s), -1)
            for run, residual in zip(observed, residuals, strict=True)
        ]
    )
    switchings = []
    for part in parts:
        seen = [measured for run in observed if (measured := watched(machine, run, part))]
        if len(seen) < len(observed):
            continue
        low = min(float(run.temperature.min()) for run in seen)
        high = max(float(run.temperature.max()) for run in seen)
        levels = [low + share * (high - low) for share in LEVELS]
        settings = [(on, band) for on, band in product(levels, DEAD_BANDS) if on - band > low]
        step = (high - low) * (LEVELS[1] - LEVELS[0])
        for on, band in _apart(settings, _shares(observed, shown, carried, seen, settings)):
            finer = [
                (on + a * step, band * b)
                for a, b in product(np.linspace(-1.0, 1.0, 15), np.geomspace(0.7, 1.4, 11))
            ]
            shares = _shares(observed, shown, carried, seen, finer)
            best = int(np.argmax(shares))
            if shares[best] >= LEAST_PREDICTED:
                relays = tuple(Relay(run, *finer[best]) for run in seen)
                switchings.append(Switching(part, relays, float(shares[best])))
    return sorted(switchings, key=lambda switching: -switching.share)[:MOST_TRIED]


def _apart(
    settings: Sequence[tuple[float, float]], shares: FloatArray
) -> list[tuple[float, float]]:
    """Return the best settings with different dead bands, at most `MOST_TRIED`.

    A wide band and a narrow one below the same level may switch at nearly the same instants.
    """
    chosen: list[tuple[float, float]] = []
    for place in np.argsort(-shares).tolist():
        on, band = settings[place]
        if shares[place] <= 0.0 or len(chosen) == MOST_TRIED:
            break
        if all(not 0.5 < band / other < 2.0 for _, other in chosen):
            chosen.append((on, band))
    return chosen


def relay(
    temperature: FloatArray, on_above: FloatArray, dead_band: FloatArray
) -> npt.NDArray[np.bool_]:
    """Return when relays switched by a temperature are on, shape (settings, K).

    Parameters
    ----------
    temperature : array, shape (K,)
    on_above, dead_band : array, shape (settings,)
        Relays that start within the dead band are off.
    """
    on = np.zeros((len(on_above), len(temperature)), dtype=bool)
    now = np.zeros(len(on_above), dtype=bool)
    for k, value in enumerate(temperature.tolist()):
        now = (now & (value >= on_above - dead_band)) | (value > on_above)
        on[:, k] = now
    return on


def _shares(
    observed: Sequence[Observations],
    shown: FloatArray,
    carried: Sequence[FloatArray],
    seen: Sequence[Watched],
    settings: Sequence[tuple[float, float]],
) -> FloatArray:
    """Return the share of the quick residuals that follows each relay; 0 if it rarely switches.

    Parameters
    ----------
    observed, carried
        As in `likely_switchings`.
    shown : array, shape (K of all runs, C)
        Residuals without slow changes.
    seen : sequence of Watched
        The part in every run.
    settings : sequence of (float, float)
        Levels and dead bands.
    """
    shares, every = np.zeros(len(settings)), float(np.sum(shown**2))
    times, warms = [run.time_s for run in observed], ~observed[0].lengths
    on_above, dead_band = np.array(settings).reshape(-1, 2).T
    states = [
        measured.on_between(on_above, dead_band, _ends(time))
        for time, measured in zip(times, seen, strict=True)
    ]
    relays = [on > 0.5 for on in states]
    counts = np.array([np.sum(on[:, 1:] != on[:, :-1], axis=1) for on in relays])
    often = (counts.sum(axis=0) >= SWITCHINGS) & (np.sum(counts > 0, axis=0) >= RUNS)
    if not often.any() or every <= 0.0:
        return shares
    kept = np.concatenate(
        [
            _followed(time, heat * (1.0 - on[often]))
            for time, on, heat in zip(times, states, carried, strict=True)
        ],
        axis=1,
    )
    basis = np.linalg.qr(kept)[0]
    along = np.swapaxes(basis, 1, 2) @ shown
    # Warmth while the relay is on may be its cause, but never its effect.
    warmer = ((kept.sum(axis=2)[:, None] @ basis) @ along)[:, 0] < 0.0
    sign = np.where(warmer | ~warms, 1.0, -1.0)
    shares[often] = np.sum(np.sum(along**2, axis=1) * sign, axis=1) / every
    return shares


def _ends(time_s: FloatArray) -> FloatArray:
    """Return the ends of spans about observations, shape (K + 1,)."""
    middle = (time_s[1:] + time_s[:-1]) / 2.0
    return np.concatenate([time_s[:1] - BIN_S / 2.0, middle, time_s[-1:] + BIN_S / 2.0])


def _followed(time_s: FloatArray, heat: FloatArray) -> FloatArray:
    """Return the heat filtered by each lag, without slow changes, shape (settings, K, lags).

    Parameters
    ----------
    time_s : array, shape (K,)
    heat : array, shape (settings, K)
    """
    steps = np.diff(time_s, prepend=time_s[0])
    return without_slow(lagged(steps, heat, heat[:, 0], QUICK_MIN), axis=1)
