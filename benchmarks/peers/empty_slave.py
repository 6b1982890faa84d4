"""A slave with the variables of another FMU and an empty step: what packaging and master cost."""

from __future__ import annotations

import json
from collections.abc import Sequence

from fmu_packaging.slave import DriftSlave
from fmu_packaging.variables import ZERO, Variable

VARIABLES_FILE = "variables.json"


class EmptySlave(DriftSlave):
    """Its outputs stay at zero."""

    def declare(self) -> Sequence[Variable]:
        return [Variable(**entry) for entry in json.loads(self.resource(VARIABLES_FILE))]

    def begin(self) -> None:
        for variable in self.variables:
            if variable.is_output:
                self.put(variable.name, ZERO[variable.kind])

    def advance(self, time_s: float, step_s: float) -> None:
        pass
