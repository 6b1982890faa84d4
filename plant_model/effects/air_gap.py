"""Heat exchange across the gap between a rotating shaft and its housing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.exchange import Exchange, exchange
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray

AIR_CONDUCTIVITY, AIR_VISCOSITY = 0.026, 16e-6
"""Of air at 25 degC, given by the studies [W/(m K), m2/s]."""


def gap_nusselt(taylor: FloatArray) -> FloatArray:
    """Return the Nusselt number of an annular gap on its hydraulic diameter (twice the gap).

    Parameters
    ----------
    taylor : array
        Modified Taylor number omega^2 r_m s^3 / nu^2 [1].

    Notes
    -----
    2 below 1700 (pure conduction), 0.128 Ta^0.367 up to 1e4 and 0.409 Ta^0.241 above: Becker and
    Kaye, J. Heat Transfer 84 (1962) 97-105, doi:10.1115/1.3684335; compared with others in
    Howey, Childs and Holmes, IEEE Trans. Ind. Electron. 59 (2012) 1367-1375. Fitted up to
    Ta = 1e7. Their factor for the shape of the gap is near 1 in a narrow gap and is left out. The
    branches do not quite meet at 1700 (1.96 and 2), hence the maximum.
    """
    laminar = np.maximum(2.0, 0.128 * np.maximum(taylor, 1.0) ** 0.367)
    turbulent = 0.409 * np.maximum(taylor, 1.0) ** 0.241
    return np.where(taylor < 1e4, np.where(taylor < 1700.0, 2.0, laminar), turbulent)


class AirGap(Effect):
    """Shaft-to-housing exchange that grows with speed: G = Nu(Ta) k A / (2 s)."""

    title = "Exchange across the air gap"
    explanation = "Vortices in the gap carry more heat the faster the shaft turns."
    parameters = {
        "scale": amplitude(1.0, 0.0, 3.0, "factor on the correlation, range by judgement")
    }
    handles = {
        ("links", "air_gap"): ItemSpec(
            refs={"between": "node,node"},
            numbers={
                "area": NumberSpec("m2", 0.0, 10.0),
                "radius": NumberSpec("mm", 1.0, 1e3),
                "gap": NumberSpec("mm", 0.05, 20.0),
            },
            law="air between rotor and stator: Q = Nu k area / (2 gap) (Tb - Ta), Nu with speed",
        )
    }
    conductance_inputs = ("speed",)

    def prepare(self) -> None:
        """Compute what does not change with speed."""
        gap = self.table([self.of(item, "gap") * 1e-3 for item in self.items])
        radius = self.table([self.of(item, "radius") * 1e-3 for item in self.items])
        area = self.table([self.of(item, "area") for item in self.items])
        self._per_omega2 = radius * gap**3 / AIR_VISCOSITY**2
        self._still = self.own("scale")[..., None] * area * AIR_CONDUCTIVITY / (2.0 * gap)

    def conductance(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray
    ) -> Sequence[Exchange]:
        """Return the exchanges at each speed."""
        omega = inputs["speed"] * (2.0 * np.pi / 60.0)
        g = gap_nusselt(omega[:, None] ** 2 * self._per_omega2) * self._still
        return [exchange(self.machine, item, g[..., i]) for i, item in enumerate(self.items)]
