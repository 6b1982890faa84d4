"""A compensator that is stepped, and small files for it."""

from collections.abc import Callable
from typing import Any

from fmu_compensator.runtime.compensator import Output, RunningCompensator
from fmu_compensator.runtime.modelfile import Model
from tests.fmu_compensator.gaussians import learnt

AsModel = Callable[[dict[str, Any]], Model]
ROOM = [20.0, 20.0, 20.0, 20.0]


class Bench:
    """Steps a compensator in 1 s steps."""

    def __init__(self, model: Model) -> None:
        self.compensator = RunningCompensator(model)
        self.time = 0.0

    def step(
        self,
        temperatures: list[float] | None = None,
        tool: float = 100.0,
        count: int = 1,
        measured: list[float] | None = None,
    ) -> Output:
        for _ in range(count):
            output = self.compensator.step(
                self.time, 1.0, temperatures or self.readings(), 1000.0, tool, measured
            )
            self.time += 1.0
        return output

    def readings(self) -> list[float]:
        """Return readings near room temperature that never stand still."""
        wiggle = 0.01 * (self.time % 2)
        return [20.0 + wiggle, 21.0, 22.0, 20.0 - wiggle]


def warm(rise_1: float, rise_4: float) -> list[float]:
    return [20.0 + rise_1, 20.0, 20.0, 20.0 + rise_4]


def quick(table: dict[str, Any]) -> dict[str, Any]:
    """Return the table with a slew that never limits."""
    table["limits"]["slew_um_per_s"] = 1000.0
    return table


def leaping(table: dict[str, Any]) -> dict[str, Any]:
    """Return the table with a slew that never limits, where no jump is too much."""
    for sensor in table["sensors"]:
        sensor["noise"] = 50.0
    return quick(table)


def free(table: dict[str, Any]) -> dict[str, Any]:
    """Return the same with a Gaussian that learnt without lags."""
    return learnt(leaping(table), lags_s=())
