"""Convection from outer surfaces to the air at a constant film coefficient."""

from __future__ import annotations

from typing import ClassVar

from plant_model.effects.base import Effect, ItemSpec, NumberSpec, amplitude, exchange
from plant_model.parameters import Parameter


class SurfaceConvection(Effect):
    """Newton's law of cooling: Q = h A (T_ambient - T), with h constant.

    Still air at machine surfaces: h of 5 to 12 W/(m2 K), of which 2 to 6 are free convection (see
    ``natural_convection``) and 3 to 5 radiation, 4 eps sigma T^3 at room temperature and an
    emissivity of 0.6 to 0.9 (VDI Heat Atlas, 2nd ed., parts F2 and K).
    """

    name: ClassVar[str] = "surface_convection"
    title: ClassVar[str] = "Convection to the air outside"
    explanation: ClassVar[str] = "Outer surfaces lose heat to the air at a constant coefficient."
    parameters: ClassVar[dict[str, Parameter]] = {
        "scale": amplitude(1.0, 0.0, 4.0, "factor on all film coefficients, 1 as given")
    }
    amplitude: ClassVar[str] = "scale"
    handles: ClassVar[dict[tuple[str, str], ItemSpec]] = {
        ("links", "convection"): ItemSpec(
            refs={"between": "node,boundary"},
            numbers={
                "area": NumberSpec("m2", 0.0, 1e3),
                "coefficient": NumberSpec("W/(m2 K)", 0.0, 1e4),
            },
        )
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        scale = self.own("scale")
        self.constant_exchanges = [
            exchange(self, item, scale * self.of(item, "area") * self.of(item, "coefficient"))
            for item in self.items
        ]
