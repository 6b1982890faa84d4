"""The effects that may be missing, and the response of every run to each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from gap_finder.keys import driver_keys, driver_of, law_of, unused_with
from gap_finder.leaps import Leaps, leaps_in
from gap_finder.linearise import modelled, simulate_runs
from gap_finder.long_log import is_piece
from gap_finder.observations import Observations
from gap_finder.periods import in_step, likely_periods, quick
from gap_finder.priors import heavy_tail
from gap_finder.switchings import Relay, carried_away, likely_switchings
from plant_model.effect_names import effect_key, name_of
from plant_model.effects import Effect, catalogue
from plant_model.effects.base import possible
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter
from plant_model.simulate import Simulation

SIZES = (0.12, 0.4, 1.0, 2.5)
"""Amplitudes tried, as shares of the distance from off to each end of the usual range; set on no
data."""

LEAST_SCALE, MOST_SCALE = 0.05, 5.0
"""Limits of the factor on a response: the smallest size tried also stands for smaller ones.
Set on no data."""

SHAPES = (0.2, 0.8)
"""Shape parameters tried in addition to the nominal value, as shares of their range; set on no
data."""


@dataclass(frozen=True)
class Candidate:
    """An effect of the catalogue at one size and shape; see `hypotheses.Addition`.

    Attributes
    ----------
    key : str
        As in a machine file.
    values : dict of str to float
        Its parameters.
    answers : tuple of array, each (N,)
        Response of every run, weighted (without robust weights).
    begins : int
        Position of the first run with the effect.
    own : tuple of dict of str to float
        Parameters with a value of their own in each run, by position; empty if there are none.
    seen : tuple of Leaps or Relay
        What was measured of it in each run, by position, for an effect that slips or that a part
        switches; otherwise empty.
    """

    key: str
    values: dict[str, float]
    answers: tuple[FloatArray, ...]
    begins: int = 0
    own: tuple[dict[str, float], ...] = ()
    seen: tuple[Leaps | Relay, ...] = ()

    @property
    def effect(self) -> type[Effect]:
        """Its law."""
        return catalogue()[name_of(self.key)]

    @property
    def is_far_from_linear(self) -> bool:
        """Whether it depends on a temperature that it changes itself.

        If a part switches it, the rows determine when it acts, almost linearly.
        """
        return self.effect.temperature_dependent and not self.is_switched

    @property
    def is_switched(self) -> bool:
        """Whether a part switches it."""
        return any(isinstance(seen, Relay) for seen in self.seen)

    @property
    def is_ordinary(self) -> bool:
        """Whether it is so small that any machine has as much."""
        return abs(self.values[self.effect.amplitude] - self.effect.off) < self.effect.least

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with the effect in force."""
        return with_effect(machine, self.key, self.values)

    def base(self, machine: Machine) -> Machine:
        """Return the machine with the effect at its nominal size, and what runs give as tried."""
        given = {name: v for name, v in self.values.items() if name in self.effect.given}
        return with_effect(machine, self.key, given)

    def marked(self, position: int, observed: Observations) -> Observations:
        """Return a run's observations with what is specific to this run in the candidate."""
        if position < self.begins:
            return replace(observed, absent=observed.absent | {self.key})
        if self.seen:
            return self.seen[position].marked(observed, self.key)
        if not self.own:
            return observed
        named = {f"effects.{self.key}.{n}": v for n, v in self.own[position].items()}
        return replace(observed, own={**observed.own, **named})

    def scaled(self, scale: float) -> Candidate:
        """Return it with its response multiplied by *scale*, within the range of its size."""
        effect = self.effect
        name = effect.proportional or effect.amplitude
        off = 0.0 if effect.proportional else effect.off
        low, high = possible(effect, name)
        value = off + scale * (self.values[name] - off)
        return replace(self, values=self.values | {name: float(np.clip(value, low, high))})

    def read(self, machine: Machine) -> Candidate:
        """Return it with the numbers of a machine."""
        return replace(self, values={n: p.value for n, p in machine.effects[self.key].items()})

    def size_cost(self) -> float:
        """Return the cost of an unusual amplitude and unusual numbers of its law."""
        total = 0.0
        for name in (self.effect.amplitude, *self.effect.law):
            usual = self.effect.parameters[name]
            if name in self.values:
                log = name != self.effect.amplitude and usual.low > 0.0
                total += heavy_tail(self.values[name], usual.low, usual.high, log=log)
        return total


def missing_effects(machine: Machine, without: Sequence[str] = ()) -> list[type[Effect]]:
    """Return the effects of the catalogue that are not in force, except *without*."""
    in_force = {law_of(key) for key in machine.effects}
    return [
        effect
        for name, effect in catalogue().items()
        if (effect.on_channel or name not in in_force)
        and name not in without
        and not effect.handles
        and all(needed in machine.effects for needed in effect.needs)
    ]


def with_effect(machine: Machine, key: str, values: dict[str, float] | None = None) -> Machine:
    """Return the machine with an effect in force, its parameters free to be calibrated.

    Ranges of the catalogue are the usual ones. Amplitude and law may leave them within physical
    limits, but the score penalises unusual values.
    """
    effect = catalogue()[name_of(key)]
    idle = unused_with(machine, key)
    parameters = {}
    for name, p in effect.parameters.items():
        low, high = possible(effect, name)
        parameters[name] = replace(p, low=low, high=high, calibrate=name not in idle)
    grown = replace(machine, effects=machine.effects | {key: parameters})
    return grown.with_values({f"effects.{key}.{name}": v for name, v in (values or {}).items()})


def beyond_usual_range(machine: Machine, key: str) -> tuple[str, ...]:
    """Return the parameters of an effect in force that lie outside their usual range."""
    usual = catalogue()[name_of(key)].parameters
    return tuple(
        name
        for name, parameter in machine.effects[key].items()
        if not usual[name].low <= parameter.value <= usual[name].high
    )


def grid(effect: type[Effect], idle: Sequence[str] = ()) -> list[dict[str, float]]:
    """Return the sizes and shapes at which an effect is tried; *idle* parameters stay nominal.

    Those that the search gives are not fitted, but tried.
    """
    size = effect.parameters[effect.amplitude]
    nominal = {name: p.value for name, p in effect.parameters.items()}
    if effect.tried:
        tried = {name: (value,) for name, value in nominal.items()} | effect.tried
        stay = {*idle} - {*effect.given}
        points = product(*((nominal[n],) if n in stay else tried[n] for n in nominal))
        return [dict(zip(nominal, point, strict=True)) for point in points]
    ends = [end for end in (size.low, size.high) if end != effect.off]
    least, most = possible(effect, effect.amplitude)
    sizes = [effect.off + share * (end - effect.off) for end in ends for share in SIZES]
    sizes = [value for value in sizes if least <= value <= most]
    shapes = [nominal]
    for name, parameter in effect.parameters.items():
        if name not in (effect.amplitude, *idle) and parameter.high > parameter.low:
            shapes += [nominal | {name: _between(parameter, share)} for share in SHAPES]
    return [shape | {effect.amplitude: value} for shape, value in product(shapes, sizes)]


def _between(parameter: Parameter, share: float) -> float:
    low, high = parameter.low, parameter.high
    if low > 0.0 and high > 5.0 * low:
        return float(low * (high / low) ** share)
    return low + share * (high - low)


def keys_of(machine: Machine, effect: type[Effect], observed: Sequence[Observations]) -> list[str]:
    """Return the effect's keys: one for every driver, or for every thermometer not yet affected."""
    if not effect.on_channel:
        return driver_keys(machine, effect)
    warmth = np.array(observed[0].channels)[~observed[0].lengths].tolist()
    keys = [effect_key(effect.name, channel) for channel in warmth]
    return [key for key in keys if key not in machine.effects]


def candidates(
    machine: Machine,
    observed: Sequence[Observations],
    plain: Sequence[Simulation],
    effect: type[Effect],
) -> Iterator[Candidate]:
    """Yield an effect at every size and shape that can be simulated; *plain* is without it."""
    if effect.swings:
        yield from swinging(machine, observed, plain, effect)
        yield from switched(machine, observed, plain, effect)
        return
    bases = _shown(plain, observed)
    leaps: tuple[Leaps, ...] = ()
    if effect.settles:
        pairs = zip(observed, bases, strict=True)
        leaps = tuple(leaps_in(machine, run, base[0]) for run, base in pairs)
        observed = [
            seen.marked(run, effect.name) for run, seen in zip(observed, leaps, strict=True)
        ]
    for key in keys_of(machine, effect, observed):
        tried = grid(effect, unused_with(machine, key))
        own, observed_so = _carried(machine, observed, key)
        if own:
            tried = [entry | own[-1] for entry in tried]
        parameters = effect.parameters
        sets = {f"effects.{key}.{n}": np.array([entry[n] for entry in tried]) for n in parameters}
        try:
            answers = _answers(with_effect(machine, key), observed_so, sets, bases)
        except IntegrationError:
            continue
        for i, values in enumerate(tried):
            of_runs = tuple(answer[i] for answer in answers)
            yield Candidate(key, values, of_runs, own=own[:-1], seen=leaps)
            for begins in range(1, len(observed) if effect.from_one_run_on else 0):
                since = [a * (j >= begins) for j, a in enumerate(of_runs)]
                yield Candidate(key, values, tuple(since), begins)


def _carried(
    machine: Machine, observed: Sequence[Observations], key: str
) -> tuple[tuple[dict[str, float], ...], list[Observations]]:
    """Return what each run inherits from the runs before it, and the observations with it.

    Empty if the effect carries nothing over. Pieces of a log need nothing: each is driven from the
    beginning of the log.
    """
    effect, driver = catalogue()[name_of(key)], driver_of(machine, key)[0]
    if any(is_piece(run.run) for run in observed):
        return (), list(observed)
    runs = [(np.diff(run.drive.grid), run.drive.held) for run in observed]
    own = effect.carried(machine, driver, runs)
    marked = [
        replace(run, own=run.own | {f"effects.{key}.{n}": v for n, v in given.items()})
        for run, given in zip(observed, own, strict=False)
    ]
    return tuple(own), marked if own else list(observed)


def _answers(
    grown: Machine,
    observed: Sequence[Observations],
    sets: dict[str, FloatArray],
    bases: Sequence[FloatArray],
) -> list[FloatArray]:
    """Return the weighted response of every run to every set, each (sets, N)."""
    shown = simulate_runs(grown, observed, sets)
    return [
        run.response(modelled(simulated, run) - base)
        for simulated, run, base in zip(shown, observed, bases, strict=True)
    ]


def _shown(plain: Sequence[Simulation], observed: Sequence[Observations]) -> list[FloatArray]:
    return [modelled(simulated, run) for simulated, run in zip(plain, observed, strict=True)]


def swinging(
    machine: Machine,
    observed: Sequence[Observations],
    plain: Sequence[Simulation],
    effect: type[Effect],
) -> Iterator[Candidate]:
    """Yield an effect that oscillates, at the likeliest periods, with each run's own phase.

    A run may begin anywhere in the cycle. So the phase is fitted to each run, and only the period
    is common to the residuals of all runs.
    """
    period, phase = effect.swings
    bases = _shown(plain, observed)
    shown = [quick(run, run.weighted(base)[0]) for run, base in zip(observed, bases, strict=True)]
    limits = effect.parameters[period]
    nominal = {name: p.value for name, p in effect.parameters.items()}
    for value in likely_periods(observed, shown, limits.low, limits.high):
        values = nominal | {period: value}
        grown = with_effect(machine, effect.name, values)
        phased = [in_step(grown, run) for run in observed]
        answers = (of_run[0] for of_run in _answers(grown, phased, {}, bases))
        own = tuple({phase: run.own[f"effects.{effect.name}.{phase}"]} for run in phased)
        yield Candidate(effect.name, values, tuple(answers), own=own)


def switched(
    machine: Machine,
    observed: Sequence[Observations],
    plain: Sequence[Simulation],
    effect: type[Effect],
) -> Iterator[Candidate]:
    """Yield an effect that a part switches, on the likeliest parts at their likeliest settings.

    The readings of the part's thermometer determine when it is on in each run.
    """
    parts = list(effect.drivers(machine))[1:]
    if not (effect.switched and parts):
        return
    bases = _shown(plain, observed)
    residuals = [run.weighted(base)[0] for run, base in zip(observed, bases, strict=True)]
    carried = [
        carried_away(machine, simulated, run)
        for simulated, run in zip(plain, observed, strict=True)
    ]
    usual = effect.parameters[effect.amplitude].high
    sizes = np.array([effect.off + share * (usual - effect.off) for share in SIZES])
    for switching in likely_switchings(machine, observed, residuals, carried, parts):
        key = effect_key(effect.name, switching.part)
        first = switching.relays[0]
        setting = dict(zip(effect.switched, (first.on_above, first.dead_band), strict=True))
        nominal = {name: p.value for name, p in effect.parameters.items()} | setting
        grown = with_effect(machine, key, setting)
        sets = {f"effects.{key}.{effect.amplitude}": sizes}
        pairs = zip(observed, switching.relays, strict=True)
        marked = [relay.marked(run, key) for run, relay in pairs]
        answers = _answers(grown, marked, sets, bases)
        for i, size in enumerate(sizes):
            of_runs = tuple(answer[i] for answer in answers)
            values = nominal | {effect.amplitude: float(size)}
            yield Candidate(key, values, of_runs, seen=switching.relays)
