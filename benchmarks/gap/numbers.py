"""The numbers of a class of machines, and those of one machine drawn around them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Numbers = dict[str, float]
"""By name."""


def tables(module: str) -> dict[str, Any]:
    """Return the content of ``numbers.toml`` beside a module's file."""
    return tomllib.loads(Path(module).with_name("numbers.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Class:
    """A class of machines.

    Attributes
    ----------
    numbers : mapping of str to (float, str)
        Value and kind of every number, in the order in which they are drawn.
    spread : mapping of str to (float, float)
        Standard deviation of the logarithm and the largest deviation allowed, by kind.
    """

    numbers: Mapping[str, tuple[float, str]]
    spread: Mapping[str, tuple[float, float]]

    def nominal(self) -> Numbers:
        """Return the middle of the class."""
        return {name: value for name, (value, _) in self.numbers.items()}

    def about(self, rng: np.random.Generator, value: float, kind: str) -> float:
        """Return a number of a kind, drawn about a value."""
        deviation, most = self.spread[kind]
        return value * float(np.exp(np.clip(deviation * rng.standard_normal(), -most, most)))

    def draw(self, rng: np.random.Generator, middle: Numbers | None = None) -> Numbers:
        """Return the numbers of a machine around the class's middle, or around another one."""
        around = (middle or self.nominal()).items()
        return {name: self.about(rng, value, self.numbers[name][1]) for name, value in around}
