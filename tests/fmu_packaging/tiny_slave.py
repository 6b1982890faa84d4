"""A small slave for tests: an integrator with hidden state, and ways to fail."""

from collections.abc import Sequence
from typing import Any

from fmu_packaging.slave import DriftSlave, FmuError
from fmu_packaging.variables import Variable


class TinySlave(DriftSlave):
    """total += gain * u * h, where gain comes from a parameter and the FMU's data file."""

    def declare(self) -> Sequence[Variable]:
        self._scale = float(self.resource("scale.txt"))
        return [
            Variable("u", "real", "input", "What is added up", unit="um/K", low=-10, high=10),
            Variable("count", "integer", "input", "A number to pass through", low=0, high=99),
            Variable("flag", "boolean", "input", "A flag to pass through"),
            Variable("word", "string", "input", "A text to pass through", start="none"),
            Variable("total", "real", "output", "The sum", unit="um", low=-1e9, high=1e9),
            Variable("count_out", "integer", "output", "The number", low=0, high=99),
            Variable("flag_out", "boolean", "output", "The flag", depends_at_start=("flag",)),
            Variable("word_out", "string", "output", "The text and the steps", depends_at_start=()),
            Variable("gain", "real", "parameter", "A factor", unit="1", low=0, high=5, start=1.0),
            Variable("fail_after", "real", "parameter", "Fails from then on", unit="s", start=1e9),
            Variable("mode", "string", "parameter", "What to do wrong at the start"),
        ]

    def begin(self) -> None:
        if self.parameters["mode"] == "refuse":
            raise FmuError("mode: 'refuse' is not allowed: 100% of tries fail")
        if self.parameters["mode"] == "crash":
            raise ZeroDivisionError("a mistake in the code")
        self._total, self._steps = 0.0, 0
        self._publish()

    def advance(self, time_s: float, step_s: float) -> None:
        if time_s >= float(self.parameters["fail_after"]):
            raise RuntimeError(f"broke at 100% of {time_s:g}")
        self._total += self._scale * float(self.parameters["gain"]) * self.inputs[0] * step_s
        self._steps += 1
        self._publish()

    def _publish(self) -> None:
        self.put("total", self._total)
        self.put("count_out", int(self.settable["integer"][self.refs["count"]]))
        self.put("flag_out", bool(self.settable["boolean"][self.refs["flag"]]))
        self.put("word_out", f"{self.settable['string'][self.refs['word']]} {self._steps}")

    def hidden(self) -> dict[str, Any]:
        return {"total": self._total, "steps": self._steps}

    def restore(self, state: dict[str, Any]) -> None:
        self._total, self._steps = state["total"], state["steps"]
