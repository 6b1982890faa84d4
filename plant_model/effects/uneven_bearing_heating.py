"""A bearing whose race is warmer on one side."""

from __future__ import annotations

from math import hypot

import numpy as np

from plant_model.anatomy import bearings
from plant_model.effects.base import ROUND, Effect, Inputs
from plant_model.effects.bearing_friction import bearing_heat
from plant_model.effects.column_bending import add_tilt
from plant_model.parameters import FloatArray, Parameter


class UnevenBearingHeating(Effect):
    """Tilt alpha (L / w) D, with tau dD/dt = D_ref P / P_ref - D across the race.

    P is the bearings' heat at the present speed and P_ref that at half of the highest speed. Load
    zones, an oil inlet or a rib make one side warmer; up to 5 K around the circumference is
    engineering judgement, as are lag, zone and lever. alpha = 11.5e-6/K for steel; L / w is the
    length over the width of the zone that bends. It causes no tilt at rest.

    If the housing around a bearing is described in sectors, the ring's warm side also conducts more
    heat: g D / 2 more into the sector whose warming tilts that way and as much less into the
    opposite one, with the conductance g from the bearing to the sector; into the others in
    proportion to the cosine of the angle. This part follows P at once.
    """

    title = "Uneven heat around the bearing"
    explanation = "One side of the race is warmer, so the nose tilts as the bearings heat."
    parameters = {
        "difference": Parameter(1.5, "K", 0.0, 5.0, "judgement: outer rings of spindles"),
        "minutes": Parameter(15.0, "min", 3.0, 60.0, "capacity over conductance of a seat"),
        "direction": Parameter(0.0, "deg", -180.0, 180.0, "0 tilts towards X, 90 towards Y"),
        "slenderness": Parameter(0.8, "1", 0.3, 2.0, "length over width of the warm zone"),
        "lever": Parameter(100.0, "mm", 0.0, 500.0, "from the bearing to the gauge line"),
    }
    law = ("minutes",)
    tried = {
        "difference": (2.0,),
        "minutes": (5.0, 15.0, 45.0),
        "direction": ROUND,
        "lever": (0.0, 100.0, 400.0),
    }
    needs = ("bearing_friction",)
    states = ("relative",)
    lags = True
    expansion = 11.5  # 1e-6/K

    def prepare(self) -> None:
        """Find the bearings and their heat at half of the highest speed [W]."""
        highest = {entry.name: entry.most for entry in self.machine.inputs}
        self._bearings = [(item, item.refs["driven_by"][0]) for item in bearings(self.machine)]
        self._reference = sum(
            (
                bearing_heat(self, item, np.array([highest[name] / 2.0]))
                for item, name in self._bearings
            ),
            np.zeros((1, 1)),
        )
        self._aside = self._sectors()

    def _sectors(self) -> FloatArray | None:
        """Return the heat moved to each node per kelvin across the rings [W/K].

        Shape (sets or 1, 1, nodes); None if the housing is not described in sectors.
        """
        machine, index = self.machine, self.machine.node_index
        leaning: dict[int, tuple[float, float]] = {}
        located = machine.of_kind("structure", "located")
        behind = any(item.parameters["at"].value < 0.0 for item in located)
        for item in machine.of_kind("structure", "bend", "ring"):
            way = -1.0 if item.kind == "ring" and behind else 1.0
            turns = [way * item.parameters[tilt].value for tilt in ("yaw", "pitch")]
            for role, sign in (("towards", 1.0), ("away", -1.0)):
                for node in self.nodes(item, role):
                    yaw, pitch = leaning.get(node, (0.0, 0.0))
                    leaning[node] = (yaw + sign * turns[0], pitch + sign * turns[1])
        angle = np.radians(self.own("direction"))
        uneven, any_sector = np.zeros((1, 1, len(machine.nodes))), False
        for bearing, _ in self._bearings:
            outer = bearing.refs["outer"][0]
            passed = moved = np.zeros((1, 1, len(machine.nodes)))
            for item in machine.of_kind("links", "conduction", "contact"):
                if outer not in item.refs["between"]:
                    continue
                (other,) = (name for name in item.refs["between"] if name != outer)
                sector = index.get(other)
                if sector is None or not any(leaning.get(sector, ())):
                    continue
                yaw, pitch = (turn / hypot(*leaning[sector]) for turn in leaning[sector])
                side = yaw * np.cos(angle) + pitch * np.sin(angle)
                unit = np.zeros(len(machine.nodes))
                unit[sector] = 1.0
                g = self.of(item, "conductance")[..., None] * unit
                any_sector = True
                passed, moved = passed + g, moved + 0.5 * g * side[..., None]
            # The sum of heat is kept, even if some sectors have less contact with the bearing.
            whole = np.maximum(np.sum(passed, axis=-1, keepdims=True), 1e-9)
            uneven = uneven + moved - passed / whole * np.sum(moved, axis=-1, keepdims=True)
        return uneven if any_sector else None

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Move heat from the cold side of the housing to the warm one."""
        if self._aside is not None:
            out += (self.own("difference") * self._relative(inputs))[..., None] * self._aside

    def _relative(self, inputs: Inputs) -> FloatArray:
        """Return the bearings' heat over that at the reference speed, (sets or 1, times)."""
        power = sum(
            (bearing_heat(self, item, inputs[name]) for item, name in self._bearings),
            np.zeros((1, 1)),
        )
        return np.asarray(power / np.maximum(self._reference, 1e-9))

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the bearings' heat over that at the reference speed."""
        relative = self._relative(inputs)
        shape = (*np.broadcast_shapes(relative.shape, (1, temperatures.shape[1])), 1)
        return np.broadcast_to(relative[..., None], shape)

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start with an even ring."""
        return np.zeros((len(temperatures), 1))

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the tilt."""
        per_kelvin = self.expansion * self.own("slenderness")
        angle = per_kelvin * self.own("difference") * states[..., 0]
        add_tilt(out, angle, self.own("direction"), self.own("lever"))
