"""The names that a sweep may vary: keys of the scenario, inputs and parameters of the FMUs."""

from __future__ import annotations

import difflib
import fnmatch
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from measurement.errors import BadInput, shown
from scenarios.pages.charts import SHOWN
from scenarios.scenario import Settings
from scenarios.sweep.variation import OPTION, Variation
from scenarios.wiring import range_of

FIXED = ("format", "name", "title", "description", "variants", "replay", "duration_s")
"""Keys that are the same in every case; percentiles over time need one duration."""

SIGNALS, PARAMETERS = "signals.", "plant.parameters."


@dataclass(frozen=True)
class Target:
    """What a variation changes.

    Attributes
    ----------
    key : str
        The scenario's key, dotted.
    low, high : float
        The range that every plant of the sweep allows.
    usual : float or None
        The plant's default; None if the plant has no such variable.
    """

    key: str
    low: float = -math.inf
    high: float = math.inf
    usual: float | None = None


class Names:
    """The names that can vary.

    Parameters
    ----------
    plants, compensators : sequence of mapping of str to variable
        The variables of every FMU that takes part, as described by fmpy.
    """

    def __init__(
        self,
        plants: Iterable[Mapping[str, Any]],
        compensators: Iterable[Mapping[str, Any]] = (),
    ) -> None:
        plants, others = list(plants), list(compensators)
        self._parameters = _common(plants, "parameter")
        # Values that one FMU passes to the other are not signals.
        self._inputs = {
            name: same
            for fmus, other in ((others, plants), (plants, others))
            for name, same in _common(fmus, "input").items()
            if name not in _common(other, "output")
        }

    def target(self, name: str) -> Target:
        """Return the target of a name.

        Raises
        ------
        BadInput
            If the name is unknown, or cannot vary.
        """
        first = name.split(".")[0]
        if first in FIXED:
            raise BadInput(OPTION, name, f"{first} is the same in every case of a sweep")
        plain = name.replace("'", "")
        if plain.startswith(PARAMETERS):
            plain = plain.removeprefix(PARAMETERS)
            if plain not in self._parameters:
                raise self._unknown(name, plain)
        if plain in self._parameters:
            return _target(PARAMETERS, self._parameters[plain])
        if plain.removeprefix(SIGNALS) in self._inputs:
            return _target(SIGNALS, self._inputs[plain.removeprefix(SIGNALS)])
        inside = plain.startswith(SIGNALS) and plain.split(".")[1] in self._inputs
        if inside or (first in Settings.model_fields and first != SIGNALS[:-1]):
            return Target(name)
        raise self._unknown(name, plain)

    def expanded(self, variation: Variation) -> list[Variation]:
        """Return a variation for each parameter that matches a pattern such as ``links.*.gap``.

        Raises
        ------
        BadInput
            If none matches.
        """
        if not set("*?") & set(variation.name):
            return [variation]
        pattern = variation.name.replace("'", "").removeprefix(PARAMETERS)
        names = fnmatch.filter(self._parameters, pattern)
        if not names:
            raise self._unknown(variation.name, pattern.replace("*", ""))
        return [replace(variation, name=name) for name in names]

    def _unknown(self, name: str, wanted: str) -> BadInput:
        names = [*self._inputs, *self._parameters, *(set(Settings.model_fields) - {*FIXED})]
        wanted = wanted.removeprefix(SIGNALS)
        near = difflib.get_close_matches(wanted, names, SHOWN, 0.5)
        near += [entry for entry in names if wanted.lower() in entry.lower() and entry not in near]
        hint = f"did you mean {', '.join(near[:SHOWN])}?"
        if not near:
            hint = f"the inputs are {', '.join(self._inputs)}"
            some = list(self._parameters)[:SHOWN]
            hint += f"; parameters such as {', '.join(some)}" if some else ""
        return BadInput(OPTION, name, f"no input, parameter or key of the scenario; {hint}")


def check_range(variation: Variation, target: Target) -> None:
    """Check that all values of an absolute variation are in the target's range.

    Raises
    ------
    BadInput
        For the first value outside.
    """
    for value in variation.ends():
        if isinstance(value, int | float) and not target.low <= value <= target.high:
            allowed = f"the plant FMU takes {target.low:g} to {target.high:g}"
            raise BadInput(OPTION, variation.name, f"{shown(value)} is not allowed: {allowed}")


def _common(descriptions: list[Mapping[str, Any]], causality: str) -> dict[str, list[Any]]:
    """Return the numeric variables of a causality that all FMUs have, by name without quotes."""
    by_name: dict[str, list[Any]] = {}
    for variables in descriptions:
        for variable in variables.values():
            if variable.causality == causality and variable.type != "String":
                by_name.setdefault(variable.name.replace("'", ""), []).append(variable)
    return {name: same for name, same in by_name.items() if len(same) == len(descriptions)}


def _target(head: str, same: list[Any]) -> Target:
    lows, highs = zip(*map(range_of, same), strict=True)
    start = same[0].start
    usual = float(start) if start is not None and same[0].type != "Boolean" else None
    return Target(head + same[0].name, max(lows), min(highs), usual)
