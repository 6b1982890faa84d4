"""Natural exponential: the drift approaches the steady drift of each speed exponentially."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import STILL_RPM, known_speed, share, taus


class NaturalExponential(ErrorModel):
    r"""After every change of speed, the exponential restarts from the current drift.

    .. math::
        z(t) = z_0 + (z_{ss}(n) - z_0) (1 - e^{-t / \tau})

    The steady drift z_ss is linear between speeds seen in training, and zero at standstill.
    Temperatures are not used.

    Parameters
    ----------
    speeds_rpm : list of float
        Increasing, all above 0 [rpm].
    steady : list of list of float, targets x speeds
        z_ss [um, urad].
    tau_s, tau_stopped_s : list of float, one per target
        Time constants while turning and at standstill [s].
    """

    remembers = ("_speed", "_drift")

    def __init__(
        self,
        speeds_rpm: list[float],
        steady: list[list[float]],
        tau_s: list[float],
        tau_stopped_s: list[float],
    ) -> None:
        self._knots = [0.0, *speeds_rpm]
        self._steady = [[0.0, *row] for row in steady]
        self._taus = list(zip(tau_s, tau_stopped_s, strict=True))
        self._speed = 0.0  # at the previous sample [rpm]
        self._drift = [0.0] * len(steady)

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> NaturalExponential:
        """Return the model that the file's numbers describe."""
        count = len(fields.items("speeds_rpm", "speeds", 1))
        speeds = fields.numbers("speeds_rpm", count)
        for index, (low, high) in enumerate(zip([0.0, *speeds], speeds, strict=False)):
            if high - low < 1e-6:
                problem = f"{high:g} is not allowed: above 0 and growing"
                raise fields.refusal(f"speeds_rpm.{index}", problem)
        times = [taus(fields, key, targets) for key in ("tau_s", "tau_stopped_s")]
        return cls(speeds, fields.matrix("steady", targets, count), *times)

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets; the previous sample's speed held until this one."""
        place, part = self._place(self._speed)
        for target, (row, (tau, stopped)) in enumerate(zip(self._steady, self._taus, strict=True)):
            goal = row[place] + part * (row[place + 1] - row[place])
            step = share(elapsed_s, tau if self._speed >= STILL_RPM else stopped)
            self._drift[target] += step * (goal - self._drift[target])
        self._speed = known_speed(speed, self._speed)
        return list(self._drift)

    def _place(self, speed: float) -> tuple[int, float]:
        """Return the knot below a speed and the fraction to the next; clipped at the last knot."""
        knots = self._knots
        if speed >= knots[-1]:
            return len(knots) - 2, 1.0
        place = next(index for index in range(len(knots) - 1) if speed < knots[index + 1])
        return place, (speed - knots[place]) / (knots[place + 1] - knots[place])
