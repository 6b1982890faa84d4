"""What every effect is: a name, parameters with one amplitude, and the hooks that it needs.

Arrays are (sets, times, nodes): *sets* counts parameter sets that are simulated at once, *times*
instants. A parameter is (sets, 1) or (1, 1), an input (times,), so that products broadcast.
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
"""Temperatures for an effect that does not depend on them, own states of one that has none."""

POSE = ("x", "y", "elongation", "yaw", "pitch", "tool_strain")
"""Axes of a displacement: radial drift at the gauge line [um], elongation [um], tilt [urad], and
the growth of the tool per length [um/mm]."""


ROUND = (-180.0, -135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0)
"""Directions [deg] at which the gap finder tries an effect that has one, given by
arithmetic: every eighth of a turn."""


class Effect:
    """Base of all effects; a subclass overrides the hooks that it needs and no others.

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
        Its name, which is its module's.
    title, explanation : str
        What a report prints.
    parameters : dict of str to Parameter
        Its own numbers (the nominal values), besides those of the items it gives a law to.
    amplitude : str
        The parameter that switches it, the first of them: at ``off`` the effect vanishes exactly.
    handles : dict of (family, kind) to ItemSpec
        The kinds of items that it gives a law to.
    temperature_dependent : bool
        Whether ``heat`` or ``conductance`` depend on temperatures or own states; if not, the
        simulation is exact.
    conductance_inputs : tuple of str
        Inputs that its conductances depend on; an effect whose items name them says so in
        ``prepare``.
    needs : tuple of str
        Effects that must be in force with it, because it changes them.
    on_channel : bool
        Whether it acts on one sensor, which the machine file names behind a colon:
        ``[effects."sensor_offset:T1"]``. It may then be in force for several sensors.
    given : tuple of str
        Parameters that nobody fits, because runs say them (:meth:`carried`) or the search does.
    states : tuple of str
        Names of its own states.
    state_scales : tuple of float
        What error control takes like 1 K, for each own state in its unit; 1 where empty.
    lags : bool
        Whether its own states only follow something, dx/dt = (target - x) / tau, and change no
        temperature. It then gives ``target`` and ``time_constants`` instead of ``rate``, and beside
        a linear network it is stepped as exactly and as fast as that.
    settles : bool
        Whether its own states stay through a step and may jump at its end, as friction and relays
        do. It then gives ``settled`` instead of ``rate``. One driver of a law may and another not.
    known_ahead : bool
        Whether its own states pass at rates that held inputs alone set, and its heat depends on
        these and on inputs: then both are known before any temperature, and nothing is stepped
        more slowly for it. One driver of a law may and another not.
    swings : tuple of str
        For an effect that swings by itself: its parameters for the period [min] and for the place
        in the cycle at which a run begins [1]. On a driver other than the usual it does not.
    switched : tuple of str
        For an effect that a part's temperature switches, its drivers other than the usual being
        parts: its parameters for the temperature at which it switches on [degC] and for the dead
        band below that [K].
    from_one_run_on : bool
        Whether it may have begun between two runs, as a fault does.
    law : tuple of str
        Parameters that, like the amplitude, make the law what it is: one that calibration takes to
        an end of its range says that another law is at work.
    proportional : str
        Parameter that its answer grows in proportion to, if that is not its amplitude.
    least : float
        Amplitude, counted from ``off``, below which it is there on any machine and is not named.
    physical : tuple of float
        What bounds the amplitude where more than its sign does; empty if nothing else.
    tried : dict of str to tuple of float
        Values at which the gap finder tries a parameter, where its usual few would miss what
        jumps or swings.

    Notes
    -----
    The docstrings here say what each hook takes and returns; those of subclasses say only what
    their law is. Inputs are a mapping from the input's name to an array, shape (times,), in the
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
        """Name it after its module, and take its first parameter for the amplitude."""
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
        """Return what may drive the effect on a machine, with the words for it, the usual first.

        A part, an input, or a difference of parts: one law, whose driver a machine file names
        behind a colon, ``[effects."slow_structure:column"]``; without one it is the usual. Empty
        where there is but one.

        Parameters
        ----------
        machine : Machine

        Returns
        -------
        dict of str to str
            Words for a report, by the name that stands behind the colon.
        """
        return {}

    @classmethod
    def unused(cls, driver: str) -> tuple[str, ...]:
        """Return the parameters that say nothing with a driver: neither tried nor moved.

        Parameters
        ----------
        driver : str
            As `drivers` has it; empty where there is but one.
        """
        return ()

    @classmethod
    def carried(
        cls, machine: Machine, driver: str, runs: Sequence[tuple[FloatArray, Inputs]]
    ) -> list[dict[str, float]]:
        """Return what runs in their order leave to those after them.

        Parameters
        ----------
        machine : Machine
        driver : str
        runs : sequence of (array, mapping of str to array)
            Lengths of the steps [s] and held inputs in them, shape (K,) each.

        Returns
        -------
        list of dict of str to float
            ``given`` parameters of every run and, last, of a run after all of them; empty if
            nothing is carried from run to run.
        """
        return []

    @property
    def driver(self) -> str:
        """What drives it, of several; empty where there is but one."""
        return self.channel or next(iter(self.drivers(self.machine)), "")

    @property
    def warms(self) -> bool:
        """Whether temperatures may depend on it, and not only what moves or what is read."""
        law = type(self)
        acts = law.heat is not Effect.heat or law.conductance is not Effect.conductance
        follows = not self.states or self.lags or self.settles
        return acts or bool(self.constant_exchanges) or self.temperature_dependent or not follows

    def prepare(self) -> None:
        """Compute once what does not change while simulating."""

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
            Such as ``between``; a role that the item leaves open has no nodes.
        """
        return [self.machine.node_index[name] for name in item.refs.get(role, ())]

    def scale_of(self, other: str) -> FloatArray:
        """Return the ``scale`` of another effect, (sets or 1, 1), zero if it is not in force.

        Parameters
        ----------
        other : str
            An effect's name that has a parameter ``scale``.
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
        """Return heat exchanges.

        Where nothing changes them, ``prepare`` puts them into ``constant_exchanges`` once.

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        temperatures : array, shape (sets, times, nodes)
            [degC]; without nodes unless ``temperature_dependent``.
        states : array, shape (sets, times, own states)
        """
        return self.constant_exchanges

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
            If the effect has states that do not lag and says no rate.
        """
        if not self.lags:
            raise TypeError(f"{self.name} has states but no rate")
        return (self.target(inputs, temperatures) - states) / self.time_constants()[:, None, :]

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return what lagging own states follow, shape (sets or 1, times, own states).

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
        """Return those of lagging own states [s], (sets or 1, own states); infinite: it stays."""
        raise TypeError(f"{self.name} has no time constants")

    def state_decay(self) -> FloatArray:
        """Return how fast own states decay by themselves [1/s], (sets or 1, own states).

        It is part of ``rate``; to know it lets steps be longer than the states are quick.
        """
        if self.lags:
            return np.asarray(1.0 / self.time_constants())
        return np.zeros((1, len(self.states)))

    def settled(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return own states, (sets, own states), after a step that ends at *temperatures*.

        Parameters
        ----------
        inputs : mapping of str to array, shape (1,)
            In force during the step; under `leaps_of` the effect's key what was seen at its end.
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
            If the effect has states that do not lag and says no start.

        Notes
        -----
        A lag starts where it would stay: the machine has been as it is for long.
        """
        if not self.lags:
            raise TypeError(f"{self.name} has states but no start")
        return self.target(inputs, temperatures[:, None, :])[:, 0]

    def error_at_start(self) -> FloatArray:
        """Return by how much its sensor reads too high when a run starts [K], (sets or 1, 1)."""
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
            Temperature since the start [K].
        states : array, shape (sets, times, own states)
        out : array, shape (sets, times, 6)
            The pose, in the order and the units of `POSE`; changed in place.
        """

    def reading(
        self, inputs: Inputs, states: FloatArray, time_s: FloatArray, readings: Readings
    ) -> None:
        """Change what sensors show.

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
"""How many times its usual range an amplitude or a number of a law may reach where physics sets no
other limit [1]: far enough that the prior of its size decides. Set on no
data."""


def possible(effect: type[Effect], parameter: str) -> tuple[float, float]:
    """Return the range in which a parameter of an effect is possible, usual or not.

    A range of the catalogue says what is usual. An amplitude may be larger than that, as far as
    physics lets it; it never changes its sign where the usual range has but one. A positive number
    that makes the law what it is, such as hours, may be as many times smaller or larger; any other
    (a direction, a share) stays in its range.

    Parameters
    ----------
    effect : type of Effect
    parameter : str
        One of its own.

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
    """Return the usual amplitude: a factor that is 1 when the effect has its nominal size."""
    return Parameter(nominal, "1", low, high, source)
