"""Joints between bearing and housing that tighten or loosen."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import bearings, incidence
from plant_model.effects.base import Effect, Inputs
from plant_model.exchange import Exchange
from plant_model.parameters import FloatArray, Parameter

USUAL_K = 2.0
"""Ring above housing at which the part of the excess is taken that counts as constant [K]. It does
not change the result, but the parts of a step that error control needs. Set on the jig borer, as a
page and in lumps, over seven hours of random speeds: with gains of 0.25 and 0.5 /K a page takes 662
and 676 parts instead of 976 and 1,483, and no temperature is off by more than 0.03 K; at 4 K fewer
still, but 0.07 K off."""


class JointResistance(Effect):
    """Conductance of a bearing's seat G = G0 f^0.95, with y = k (T_outer - T_housing).

    f = 1 + y if the seat tightens, 1 / (1 - y) if it opens, limited to 0.2..5. If it tightens, f is
    the ratio of contact pressure to that when cold: the warmer the outer ring is than the housing,
    the harder it presses into its bore; a seat of 110 mm gains 0.7 um per kelvin in radius,
    compared with 1 to 5 um of fit (engineering judgement). Contact conductance grows with
    pressure^0.95: Yovanovich's correlation (Thermal contact correlations, in Spacecraft Radiative
    Transfer and Temperature Control, AIAA 1982) of the theory of Cooper, Mikic and Yovanovich, Int.
    J. Heat Mass Transf. 12 (1969) 279-300, doi:10.1016/0017-9310(69)90011-8. If it opens (k below
    zero), a gap and its resistance grow in proportion to y. The limits of f are engineering
    judgement. It acts on every contact of a bearing's outer side except that to its inner side.
    """

    title = "Bearing seat tightening with temperature"
    explanation = (
        "The joint from bearing to housing conducts better, or worse, the warmer the bearing is."
    )
    parameters = {"gain": Parameter(0.25, "1/K", -0.7, 0.7, "judgement: ring growth against fit")}
    tried = {"gain": tuple(sign * size for sign in (-1.0, 1.0) for size in (0.02, 0.06, 0.2, 0.5))}
    temperature_dependent = True

    def prepare(self) -> None:
        """Find the seats."""
        machine = self.machine
        pairs = {(item.refs["outer"][0], item.refs["inner"][0]) for item in bearings(machine)}
        outer = {pair[0] for pair in pairs}
        seats: list[tuple[int, int]] = []
        columns = []
        for item in machine.of_kind("links", "contact"):
            first, second = item.refs["between"]
            for ring, other in ((first, second), (second, first)):
                if ring in outer and (ring, other) not in pairs:
                    seats.append((machine.node_index[ring], machine.node_index[other]))
                    columns.append(self.scale_of("conduction") * self.of(item, "conductance"))
                    break
        self._rings, self._bores = ([pair[i] for pair in seats] for i in (0, 1))
        size = len(machine.nodes)
        self._into = incidence(self._bores, size) - incidence(self._rings, size)
        self._seats, self._gain = self.table(columns), self.own("gain")[..., None]
        # A seat responds within a second. What it usually conducts in excess is therefore part of
        # the constant network, which takes steps of any length exactly.
        self._usual = self._pressure(np.array(USUAL_K)) ** 0.95 - 1.0
        self.constant_exchanges = [
            Exchange(ring, bore, self._usual[..., 0] * conductance)
            for ring, bore, conductance in zip(self._rings, self._bores, columns, strict=True)
        ]

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the rest of the exchange."""
        if not self._rings:
            return
        warmer = temperatures[..., self._rings] - temperatures[..., self._bores]
        excess = self._pressure(warmer) ** 0.95 - 1.0
        out += (self._seats * (excess - self._usual) * warmer) @ self._into

    def _pressure(self, warmer: FloatArray) -> FloatArray:
        """Return contact pressure, or inverse resistance, relative to that when cold [1]."""
        tighter = self._gain * warmer
        factor = (1.0 + np.maximum(tighter, 0.0)) / (1.0 - np.minimum(tighter, 0.0))
        return np.asarray(np.minimum(np.maximum(factor, 0.2), 5.0))
