"""Base class of effects: a name, parameters with one amplitude, and the hooks that it needs.

Arrays are (sets, times, nodes): *sets* is the number of parameter sets simulated at once, *times*
that of instants. A parameter is (sets, 1) or (1, 1), an input (times,), so that products broadcast.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from plant_model.effect_names import effect_key
from plant_model.exchange import Exchange
from plant_model.item_forms import ItemSpec
from plant_model.machine import Item, Machine
from plant_model.parameters import FloatArray, Parameter, Values

Inputs = Mapping[str, FloatArray]
Readings = dict[str, FloatArray]

NONE = np.zeros((1, 1, 0))
"""Passed as temperatures or own states to an effect that does not depend on or have them."""

POSE = ("x", "y", "elongation", "yaw", "pitch", "tool_strain")
"""Components of a pose: radial drift at the gauge line [um], elongation [um], tilt [urad], and
the growth of the tool per length [um/mm]."""

UNITS_S = {"hours": 3600.0, "minutes": 60.0}
"""Names of time constants and their units [s], given by the names."""

ROUND = (-180.0, -135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0)
"""Directions [deg] that the gap finder tries for an effect with a direction, given by
arithmetic: every eighth of a turn."""


class Effect:
    """Base of all effects; a subclass overrides only the hooks that it needs.

    Parameters
    ----------
    machine : Machine
    values : Values
        The parameter sets.
    channel : str
        The sensor that it acts on; empty for an effect of the whole machine.

    Attributes
    ----------
    name : str
        Its name, which is that of its module.
    title, explanation : str
        Texts for reports.
    parameters : dict of str to Parameter
        Its own numbers (nominal values), in addition to those of the items whose law it defines.
    amplitude : str
        Name of its first parameter: at the value ``off`` the effect vanishes exactly.
    handles : dict of (family, kind) to ItemSpec
        The kinds of items whose law it defines.
    temperature_dependent : bool
        Whether ``heat`` or ``conductance`` depend on temperatures or own states; if not, the
        simulation is exact. Its hooks read the same nodes at every call.
    conductance_inputs : tuple of str
        Inputs that its conductances depend on; if its items name them, ``prepare`` sets it.
    needs : tuple of str
        Effects that must be in force with it, because it changes them.
    on_channel : bool
        Whether it acts on one sensor, which the machine file names after a colon:
        ``[effects."sensor_offset:T1"]``. It may then be in force for several sensors.
    given : tuple of str
        Parameters that are not fitted, because runs (:meth:`carried`) or the search give them.
    states : tuple of str
        Names of its own states.
    state_scales : tuple of float
        Change of each own state, in its unit, that counts as much as 1 K in error control; 1 if
        empty.
    lags : bool
        Whether its own states only follow something, dx/dt = (target - x) / tau, and change no
        temperature. It then gives ``target`` and ``time_constants`` instead of ``rate``, and with
        a linear network it is stepped just as exactly and fast.
    settles : bool
        Whether its own states are constant during a step and may jump at its end, as with friction
        and relays. It then gives ``settled`` instead of ``rate``. May depend on the driver.
    known_ahead : bool
        Whether the rates of its own states depend only on held inputs, and its heat only on these
        states and on inputs: then both are known before any temperature, and the effect does not
        slow stepping down. May depend on the driver.
    swings : tuple of str
        For an effect that oscillates by itself: its parameters for the period [min] and for the
        place in the cycle at which a run begins [1]. Used only with the default driver.
    switched : tuple of str
        For an effect that is switched by the temperature of a part, which is then its driver: its
        parameters for the temperature at which it switches on [degC] and for the dead band below
        that [K]. Not used with the default driver.
    from_one_run_on : bool
        Whether it may have begun between two runs, like a fault.
    law : tuple of str
        Parameters that, like the amplitude, define the law: if calibration moves one to an end of
        its range, another law is at work.
    proportional : str
        Parameter that its response is proportional to, if that is not its amplitude.
    least : float
        Amplitude, counted from ``off``, below which it exists on any machine and is not named.
    physical : tuple of float
        Physical limits of the amplitude, if there are others than its sign; else empty.
    tried : dict of str to tuple of float
        Values of a parameter that the gap finder tries, if its usual few would miss effects that
        jump or oscillate.

    Notes
    -----
    The docstrings here state what each hook takes and returns; those of subclasses state only
    their law. Inputs are a mapping from the input's name to an array, shape (times,), in the
    input's unit.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    explanation: ClassVar[str]
    parameters: ClassVar[dict[str, Parameter]]
    amplitude: ClassVar[str]
    off: ClassVar[float] = 0.0
    handles: ClassVar[dict[tuple[str, str], ItemSpec]] = {}
    temperature_dependent: ClassVar[bool] = False
    conductance_inputs: tuple[str, ...] = ()
    needs: ClassVar[tuple[str, ...]] = ()
    on_channel: ClassVar[bool] = False
    given: ClassVar[tuple[str, ...]] = ()
    states: ClassVar[tuple[str, ...]] = ()
    state_scales: ClassVar[tuple[float, ...]] = ()
    lags: ClassVar[bool] = False

    settles: bool = False
    known_ahead: bool = False
    from_one_run_on: ClassVar[bool] = False
    swings: ClassVar[tuple[str, ...]] = ()
    switched: ClassVar[tuple[str, ...]] = ()
    law: ClassVar[tuple[str, ...]] = ()
    proportional: ClassVar[str] = ""
    least: ClassVar[float] = 0.0
    physical: ClassVar[tuple[float, ...]] = ()
    tried: ClassVar[dict[str, tuple[float, ...]]] = {}
    constant_exchanges: Sequence[Exchange] = ()

    def __init_subclass__(cls) -> None:
        """Name it after its module, and take its first parameter as the amplitude."""
        super().__init_subclass__()
        if not hasattr(cls, "name"):
            cls.name = cls.__module__.rpartition(".")[2]
        if not hasattr(cls, "amplitude"):
            cls.amplitude = next(iter(getattr(cls, "parameters", {})), "")

    def __init__(self, machine: Machine, values: Values, channel: str = "") -> None:
        self.machine = machine
        self.values = values
        self.channel = channel
        self.key = effect_key(self.name, channel)
        self.items: list[Item] = [
            item for item in machine.items if (item.family, item.kind) in self.handles
        ]
        self.prepare()

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the possible drivers of the effect on a machine with their texts, default first.

        A driver is a part, an input, or a difference between parts. A machine file names it after a
        colon, ``[effects."slow_structure:column"]``; without one the default drives the effect.
        Empty if there is only one.

        Parameters
        ----------
        machine : Machine

        Returns
        -------
        dict of str to str
            Texts for a report, by the name after the colon.
        """
        return {}

    @classmethod
    def unused(cls, driver: str) -> tuple[str, ...]:
        """Return the parameters that have no effect with a driver: neither tried nor moved.

        Parameters
        ----------
        driver : str
            A name of `drivers`; empty if there is only one.
        """
        return ()

    @classmethod
    def carried(
        cls, machine: Machine, driver: str, runs: Sequence[tuple[FloatArray, Inputs]]
    ) -> list[dict[str, float]]:
        """Return what each run, in their order, takes over from the runs before it.

        Parameters
        ----------
        machine : Machine
        driver : str
        runs : sequence of (array, mapping of str to array)
            Lengths of the steps [s] and held inputs in them, shape (K,) each.

        Returns
        -------
        list of dict of str to float
            ``given`` parameters of each run and, last, of a run after all of them; empty if
            nothing is carried from run to run.
        """
        return []

    @property
    def driver(self) -> str:
        """Its driver; empty if there is only one."""
        return self.channel or next(iter(self.drivers(self.machine)), "")

    @property
    def warms(self) -> bool:
        """Whether temperatures may depend on it, not only the pose or the readings."""
        law = type(self)
        acts = law.heat is not Effect.heat or law.conductance is not Effect.conductance
        follows = not self.states or self.lags or self.settles
        return acts or bool(self.constant_exchanges) or self.temperature_dependent or not follows

    def prepare(self) -> None:
        """Compute what does not change during a simulation."""

    def own(self, parameter: str) -> FloatArray:
        """Return one of the effect's own parameters, shape (sets or 1, 1).

        Parameters
        ----------
        parameter : str
            Its name in ``parameters``.

        Returns
        -------
        array, shape (sets or 1, 1)
            In the parameter's unit.
        """
        return self.values[f"effects.{self.key}.{parameter}"]

    def of(self, item: Item, parameter: str) -> FloatArray:
        """Return a parameter of an item, shape (sets or 1, 1).

        Parameters
        ----------
        item : Item
        parameter : str
            Its name among the item's numbers.

        Returns
        -------
        array, shape (sets or 1, 1)
            In the parameter's unit.
        """
        return self.values[item.parameter_name(parameter)]

    def nodes(self, item: Item, role: str) -> list[int]:
        """Return the positions of the nodes in a role of an item.

        Parameters
        ----------
        item : Item
        role : str
            For example ``between``; a role that the item leaves out has no nodes.
        """
        return [self.machine.node_index[name] for name in item.refs.get(role, ())]

    def scale_of(self, other: str) -> FloatArray:
        """Return the ``scale`` of another effect, (sets or 1, 1), zero if it is not in force.

        Parameters
        ----------
        other : str
            Name of an effect that has a parameter ``scale``.
        """
        if other not in self.machine.effects:
            return np.zeros((1, 1))
        return self.values[f"effects.{other}.scale"]

    def table(self, columns: Sequence[FloatArray]) -> FloatArray:
        """Return numbers of several items, each (sets or 1, 1), as one array (sets, 1, items).

        Parameters
        ----------
        columns : sequence of array, each (sets or 1, 1)
            May be empty.
        """
        if not columns:
            return np.zeros((1, 1, 0))
        return np.stack(np.broadcast_arrays(*columns), axis=-1)

    def conductance(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray
    ) -> Sequence[Exchange]:
        """Return heat exchanges that vary; ``prepare`` puts the others into ``constant_exchanges``.

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        temperatures : array, shape (sets, times, nodes)
            [degC]; without nodes unless ``temperature_dependent``.
        states : array, shape (sets, times, own states)
        """
        return ()

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add heat [W] to *out*, shape (sets, times, nodes).

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        temperatures : array, shape (sets, times, nodes)
            [degC]; without nodes unless ``temperature_dependent``.
        states : array, shape (sets, times, own states)
        out : array, shape (sets, times, nodes)
            Changed in place [W].
        """

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return d(states)/dt, shape (sets, times, own states).

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        temperatures : array, shape (sets, times, nodes)
            [degC]
        states : array, shape (sets, times, own states)

        Raises
        ------
        TypeError
            If the effect has states that do not lag but does not give a rate.
        """
        if not self.lags:
            raise TypeError(f"{self.name} has states but no rate")
        return (self.target(inputs, temperatures) - states) / self.time_constants()[:, None, :]

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the values that lagging own states follow, (sets or 1, times, own states).

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        temperatures : array, shape (sets, times, nodes)
            [degC]

        Raises
        ------
        TypeError
            If the effect does not lag.
        """
        raise TypeError(f"{self.name} lags behind nothing")

    def time_constants(self) -> FloatArray:
        """Return those of lagging own states [s], (sets or 1, own states); infinite: constant.

        By default the first state lags by the parameter ``hours`` or ``minutes``; a second one
        keeps the value at the start.

        Raises
        ------
        TypeError
            If the effect has neither parameter.
        """
        unit = next((unit for unit in UNITS_S if unit in self.parameters), "")
        if not unit:
            raise TypeError(f"{self.name} has no time constants")
        lag = UNITS_S[unit] * self.own(unit)
        return np.concatenate([lag, np.full_like(lag, np.inf)], axis=1)[:, : len(self.states)]

    def state_decay(self) -> FloatArray:
        """Return the rates at which own states decay by themselves [1/s], (sets or 1, own states).

        This decay is part of ``rate``; knowing it allows steps longer than its time constant.
        """
        if self.lags:
            return np.asarray(1.0 / self.time_constants())
        return np.zeros((1, len(self.states)))

    def settled(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return own states, (sets, own states), after a step that ends at *temperatures*.

        Parameters
        ----------
        inputs : mapping of str to array, shape (1,)
            In force during the step; the input named by `leaps_of` holds leaps seen at its end.
        temperatures : array, shape (sets, nodes)
            Of the nodes [degC].
        states : array, shape (sets, own states)

        Raises
        ------
        TypeError
            If the effect does not settle.
        """
        raise TypeError(f"{self.name} does not settle")

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Return the own states at the start, shape (sets or 1, own states).

        Parameters
        ----------
        temperatures : array, shape (sets, nodes)
            Of the nodes [degC].
        inputs : mapping of str to array, shape (1,)

        Raises
        ------
        TypeError
            If the effect has states that do not lag but does not give a start.

        Notes
        -----
        Lagging states start at their target, as if the machine had long been in this state.
        """
        if not self.lags:
            raise TypeError(f"{self.name} has states but no start")
        return self.target(inputs, temperatures[:, None, :])[:, 0]

    def error_at_start(self) -> FloatArray:
        """Return how much its sensor reads too high at the start of a run [K], (sets or 1, 1)."""
        shown = {self.channel: np.zeros((1, 1))}
        if self.on_channel:
            self.reading({}, np.zeros((1, 1, len(self.states))), np.zeros(1), shown)
        return shown[self.channel]

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add to the pose.

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        rise : array, shape (sets, times, nodes)
            Temperature change since the start [K].
        states : array, shape (sets, times, own states)
        out : array, shape (sets, times, 6)
            The pose, in the order and the units of `POSE`; changed in place.
        """

    def reading(
        self, inputs: Inputs, states: FloatArray, time_s: FloatArray, readings: Readings
    ) -> None:
        """Change the readings of sensors.

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        states : array, shape (sets, times, own states)
        time_s : array, shape (times,)
            Since the run's start [s].
        readings : dict of str to array, shape (sets, times)
            By sensor [degC, um]; changed in place.
        """


TIMES_USUAL = 10.0
"""Factor by which an amplitude or a number of a law may exceed its usual range if physics sets no
other limit [1]: large enough that the prior of its size decides. Set on no
data."""


def possible(effect: type[Effect], parameter: str) -> tuple[float, float]:
    """Return the range of possible values of a parameter of an effect, usual or not.

    The catalogue's range states what is usual. An amplitude may exceed it by `TIMES_USUAL`, or up
    to its physical limits; it keeps its sign if the usual range has only one. A positive number
    that defines the law, such as hours, may be smaller or larger by the same factor; any other
    (a direction, a share) stays in its range.

    Parameters
    ----------
    effect : type of Effect
    parameter : str
        Name of one of its own parameters.

    Returns
    -------
    low, high : float
        In the parameter's unit.
    """
    usual = effect.parameters[parameter]
    if parameter != effect.amplitude:
        if parameter not in effect.law or usual.low <= 0.0:
            return usual.low, usual.high
        return usual.low / TIMES_USUAL, usual.high * TIMES_USUAL
    if effect.physical:
        low, high = effect.physical
        return low, high
    return TIMES_USUAL * min(usual.low, 0.0), TIMES_USUAL * max(usual.high, 0.0)


def amplitude(nominal: float, low: float, high: float, source: str) -> Parameter:
    """Return the usual kind of amplitude: a factor that is 1 at the effect's nominal size."""
    return Parameter(nominal, "1", low, high, source)
