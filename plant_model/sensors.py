"""Readings of the machine's sensors: thermometers and displacement rig, noise and resolution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.effects import Effect
from plant_model.effects.base import NONE, Inputs
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.structure import drift_at


def displacement_names(machine: Machine) -> list[str]:
    """Return the names of the displacement sensors, in the rig's order.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    list of str
        For a five-point rig: near x and y, distal x and y, axial.
    """
    return list(machine.probes)


def displacements(machine: Machine, pose_now: FloatArray) -> dict[str, FloatArray]:
    """Return all displacement readings for a pose [um].

    Parameters
    ----------
    machine : Machine
    pose_now : array, shape (..., 6)
        In the order of ``effects.base.POSE``.

    Returns
    -------
    dict of str to array, shape (...)
        By sensor name, with the sensor's sign [um].
    """
    rig, axes, signs = machine.rig, machine.probes.values(), machine.signs
    if rig["kind"] == "direct":
        drift = drift_at(pose_now, 0.0)
        seen = [drift[..., "XYZ".index(axis)] for axis in axes]
    else:
        near = rig["near_to_gauge_mm"]
        lengths = np.array([near, near + rig["spacing_mm"], rig["test_bar_mm"]])
        at = drift_at(pose_now[..., None, :], lengths)
        places = zip((0, 0, 1, 1, 2), axes, strict=True)
        seen = [at[..., place, "XYZ".index(axis)] for place, axis in places]
    return {name: signs[name] * drift for name, drift in zip(signs, seen, strict=True)}


def readings(
    machine: Machine,
    effects: Sequence[Effect],
    slices: dict[str, slice],
    inputs: Inputs,
    time_s: FloatArray,
    temperatures: FloatArray,
    states: FloatArray,
    pose_now: FloatArray,
) -> dict[str, FloatArray]:
    """Return the readings of all sensors without noise.

    Parameters
    ----------
    machine : Machine
    effects : sequence of Effect
        Those in force; some change readings.
    slices : dict of str to slice
        Positions of each effect's own states, by its key.
    inputs : mapping of str to array, shape (times,)
    time_s : array, shape (times,)
        Since the run's start [s].
    temperatures : array, shape (sets, times, nodes)
        [degC]
    states : array, shape (sets, times, own states)
    pose_now : array, shape (sets, times, 6)
        In the order of ``effects.base.POSE``.

    Returns
    -------
    dict of str to array, shape (sets, times)
        By sensor [degC, um].
    """
    index = machine.node_index
    shape = temperatures.shape[:2]
    shown: dict[str, FloatArray] = {}
    for sensor in machine.sensors:
        if sensor.of in index:
            shown[sensor.name] = temperatures[..., index[sensor.of]].copy()
        else:
            shown[sensor.name] = np.broadcast_to(inputs[sensor.of], shape).copy()
    shown.update(displacements(machine, pose_now))
    # A lagging sensor replaces its reading, so it comes before the errors added to it.
    for effect in sorted(effects, key=lambda entry: not entry.states):
        own = states[..., slices[effect.key]] if effect.states else NONE
        effect.reading(inputs, own, time_s, shown)
    return shown


def noise_and_resolution(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return the noise (one standard deviation) and the resolution of every sensor, by name.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    dict of str to (noise, resolution)
        [K, um]; 0 if there is none.
    """
    table = {sensor.name: (sensor.noise, sensor.resolution) for sensor in machine.sensors}
    rig = machine.rig
    pair = (rig["noise_um"], rig["resolution_um"])
    return table | dict.fromkeys(displacement_names(machine), pair)


class SensorNoise:
    """Adds each sensor's noise to its reading and rounds it to the sensor's resolution.

    Parameters
    ----------
    machine : Machine

    Attributes
    ----------
    names : list of str
        The sensors, in the order of their noise numbers.
    """

    def __init__(self, machine: Machine) -> None:
        table = noise_and_resolution(machine)
        pairs = np.array(list(table.values()))
        self.names = list(table)
        self._noise = pairs[:, 0, None, None]
        # Rounding to a resolution this fine changes nothing.
        self._resolution = np.where(pairs[:, 1] > 0.0, pairs[:, 1], 1e-12)[:, None, None]

    def added(self, shown: dict[str, FloatArray], normal: FloatArray) -> dict[str, FloatArray]:
        """Return readings with noise and resolution, each (sets, times).

        Parameters
        ----------
        shown : dict of str to array, shape (sets, times)
        normal : array, shape (sensors, sets, times)
            Random numbers with mean 0 and standard deviation 1.
        """
        exact = np.stack([shown[name] for name in self.names])
        counts = np.rint((exact + self._noise * normal) / self._resolution)
        return dict(zip(self.names, np.round(counts * self._resolution, 9), strict=True))


def column_of(machine: Machine, name: str) -> str:
    """Return the run-file column of a sensor's readings.

    Parameters
    ----------
    machine : Machine
    name : str
        One of its thermometers or displacement sensors.
    """
    return f"{name}_um" if name in displacement_names(machine) else f"{name}_degC"
