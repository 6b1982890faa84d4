"""The variables of another FMU as pythonfmu alone has them, and an empty step.

A script for pythonfmu's own builder: what lies beside it in ``variables.json`` is registered one by
one, and every value is an attribute.
"""

import json
from pathlib import Path

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String

KINDS = {"real": Real, "integer": Integer, "boolean": Boolean, "string": String}
ZERO = {"real": 0.0, "integer": 0, "boolean": False, "string": ""}


class PlainSlave(Fmi2Slave):
    """Its outputs stay at zero."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.value = {}
        for entry in json.loads((Path(self.resources) / "variables.json").read_text()):
            self._declare(entry["name"], entry["kind"], entry["causality"], entry["start"])

    def _declare(self, name, kind, causality, start):
        attribute = "".join(letter if letter.isalnum() else "_" for letter in name)
        setattr(self, attribute, ZERO[kind] if start is None else start)
        settings = {} if causality == "output" else {"start": getattr(self, attribute)}
        if causality == "parameter":
            settings["variability"] = Fmi2Variability.fixed
        self.register_variable(
            KINDS[kind](
                name,
                causality=Fmi2Causality[causality],
                getter=lambda: getattr(self, attribute),
                setter=lambda value: setattr(self, attribute, value),
                **settings,
            )
        )

    def do_step(self, current_time, step_size):
        return True
