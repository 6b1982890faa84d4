"""One displacement probe on a bracket that moves as it warms."""

from __future__ import annotations

from collections import Counter

import numpy as np

from plant_model.anatomy import outside
from plant_model.effects.fixture_warming import FixtureWarming
from plant_model.machine import Machine
from plant_model.parameters import Parameter


class ProbeWarming(FixtureWarming):
    """One radial reading moves by k y, tau dy/dt = (1 - s) dT_hall + s dT_nose - y.

    dT counts from the start of the run, the nose is the front of the housing. A bracket longer than
    the others, of another material or clamped at the other side grows apart from them; sizes are
    those of a whole fixture (`fixture_warming`), towards either side. Only a probe with another one
    on its axis is listed: where a single one measures an axis, nothing tells its bracket from a
    part that moves that axis.
    """

    name = "probe_warming"
    title = "Bracket of one probe warming"
    explanation = "One probe's bracket grows, and its reading moves apart from the other's."
    parameters = {
        "growth": Parameter(2.0, "um/K", -6.0, 6.0, "50 to 450 mm of steel or aluminium"),
        "minutes": FixtureWarming.parameters["minutes"],
        "nose_share": FixtureWarming.parameters["nose_share"],
    }
    tried = {
        "growth": (-2.0, 2.0),
        "minutes": FixtureWarming.tried["minutes"],
        "nose_share": FixtureWarming.tried["nose_share"],
    }

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the probes that measure an axis beside another one."""
        on_axis = Counter(machine.probes.values())
        return {
            name: f"the bracket of {name}"
            for name, axis in machine.probes.items()
            if on_axis[axis] > 1
        }

    def prepare(self) -> None:
        """Find hall, nose and the probe."""
        nose = next(iter(FixtureWarming.drivers(self.machine)))
        self._hall, self._part = outside(self.machine), self.machine.node_index[nose]
        probe = {self.driver} & set(self.machine.signs)
        self._moved = {name: np.asarray(float(self.machine.signs[name])) for name in probe}
