"""Axial shift of the shaft at speed."""

from __future__ import annotations

from plant_model.anatomy import input_in
from plant_model.effects.base import POSE, Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class CentrifugalShift(Effect):
    """Elongation changes at once by k (n / n_high)^2; n_high is the highest speed.

    Centrifugal load grows with the square of speed. It moves the balls outwards, which lowers the
    outer contact angle and raises the inner one (Jorgensen and Shin, J. Manuf. Sci. Eng. 120 (1998)
    387-394; Abele, Altintas and Brecher, CIRP Annals 59 (2010) 781-802,
    doi:10.1016/j.cirp.2010.05.002), the rings grow, and the shaft shortens as it widens (Poisson).
    The nose moves forwards or backwards, depending on the arrangement of the bearings. The size,
    1 to 30 um at full speed, is engineering judgement.
    """

    title = "Axial shift with speed"
    explanation = (
        "Centrifugal load shifts the nose along its axis at the instant of a speed change."
    )
    parameters = {
        "shift": Parameter(10.0, "um", -30.0, 30.0, "judgement: 1 to 30 um at full speed")
    }

    def prepare(self) -> None:
        """Find the speed."""
        self._speed = input_in(self.machine, "rpm")

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the shift."""
        if self._speed is not None:
            relative = inputs[self._speed.name] / max(self._speed.high, -self._speed.low)
            out[..., POSE.index("elongation")] += self.own("shift") * relative**2
