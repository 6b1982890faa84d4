"""Reads ``--vary NAME=VALUES``: values of a grid, or a distribution to draw from."""

from __future__ import annotations

import math
import re
import tomllib
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from measurement.errors import BadInput, shown
from plant_model.drive import MOST_STEPS

OPTION = "--vary"

_NUMBER = r"([-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?)"
_RANGE = re.compile(rf"^{_NUMBER}\.\.{_NUMBER}(?::(log|\d+))?$")
_NORMAL = re.compile(rf"^{_NUMBER}\+-{_NUMBER}$")
_FACTORS = re.compile(r"^x[-+.\d]")
FORMS = "a,b,c or low..high:COUNT for a grid, low..high, low..high:log or mean+-sd for draws"


@dataclass(frozen=True)
class Variation:
    """One thing that varies.

    Attributes
    ----------
    name : str
        The parameter, input or key of the scenario, as given.
    relative : bool
        Whether its values multiply the scenario's value (``NAME=x0.9,1.1``).
    values : tuple
        The values of a grid; empty for a distribution.
    kind : str
        ``uniform``, ``log`` or ``normal``; empty for a grid.
    first, second : float
        Ends of the range; for ``normal`` mean and standard deviation.
    """

    name: str
    relative: bool
    values: tuple[Any, ...] = ()
    kind: str = ""
    first: float = math.nan
    second: float = math.nan

    @property
    def label(self) -> str:
        """Its name in tables, which also says if its values are factors."""
        return f"{self.name}_factor" if self.relative else self.name

    @property
    def is_drawn(self) -> bool:
        """Whether a value is drawn for every repeat."""
        return bool(self.kind)

    def ends(self) -> tuple[Any, ...]:
        """Return the values that must be allowed."""
        if self.kind == "normal":
            return (self.first,)
        return (self.first, self.second) if self.kind else self.values

    def drawn(self, seed: int, repeat: int, low: float, high: float) -> float:
        """Return the value of a repeat: the same for the same seed, label and repeat.

        Parameters
        ----------
        seed, repeat : int
            The sweep's seed, and the repeat, from 0.
        low, high : float
            A normal distribution is truncated here.
        """
        generator = np.random.default_rng([seed, zlib.crc32(self.label.encode()), repeat])
        if self.kind == "uniform":
            return float(generator.uniform(self.first, self.second))
        if self.kind == "log":
            return float(np.exp(generator.uniform(math.log(self.first), math.log(self.second))))
        mean, deviation = self.first, self.second
        limits = ((limit - mean) / deviation for limit in (low, high))
        from scipy.stats import truncnorm  # only here: it takes a second to load

        # Freezing the distribution first takes four times as long as the draw.
        return float(truncnorm.rvs(*limits, mean, deviation, random_state=generator))


def variation(text: str) -> Variation:
    """Return the variation in ``NAME=VALUES``; an ``x`` before the values makes them factors.

    Raises
    ------
    BadInput
        If it does not have this form, has no value, or an invalid range.
    """
    name, mark, values = (part.strip() for part in text.partition("="))
    relative = bool(_FACTORS.match(values))
    values = values.removeprefix("x") if relative else values
    if not mark or not name:
        raise BadInput(OPTION, "", f"{text!r} is not of the form NAME=VALUES: {FORMS}")
    if not values.strip(", "):
        raise BadInput(OPTION, name, f"there is no value: {FORMS}")
    as_range, as_normal = _RANGE.match(values), _NORMAL.match(values)
    if as_range:
        return _from_range(name, relative, *as_range.groups())
    if as_normal:
        mean, deviation = map(float, as_normal.groups())
        if not 0.0 < deviation < math.inf:
            raise BadInput(OPTION, name, f"a standard deviation of {deviation:g} is not above 0")
        return Variation(name, relative, (), "normal", mean, deviation)
    return Variation(name, relative, _listed(name, values, relative))


def _from_range(name: str, relative: bool, low: str, high: str, how: str | None) -> Variation:
    first, second = float(low), float(high)
    if not (math.isfinite(first) and math.isfinite(second) and first < second):
        raise BadInput(OPTION, name, f"{low}..{high} is no range: the first must be the lower one")
    if how is None or how == "log":
        if how == "log" and first <= 0.0:
            raise BadInput(OPTION, name, f"{low}..{high}:log must lie above 0")
        return Variation(name, relative, (), how or "uniform", first, second)
    count = int(how)
    if not 2 <= count <= MOST_STEPS:
        raise BadInput(OPTION, name, f"{count} values are not allowed: 2 to {MOST_STEPS}")
    # Twelve digits, so that 0.1..0.3:3 contains 0.2.
    steps = (float(f"{value:.12g}") for value in np.linspace(first, second, count).tolist())
    return Variation(name, relative, tuple(steps))


def _listed(name: str, text: str, relative: bool) -> tuple[Any, ...]:
    """Return the values of a list: TOML, or else plain text such as file names."""
    try:
        values = tomllib.loads(f"values = [{text}]")["values"]
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        values = [part.strip() for part in text.split(",")]
    for i, value in enumerate(values):
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if value == "" or (number and not math.isfinite(value)) or (relative and not number):
            raise BadInput(OPTION, name, f"{shown(value)} is not allowed: {FORMS}")
        if value in values[:i]:
            raise BadInput(OPTION, name, f"{shown(value)} is there twice")
    return tuple(values)
