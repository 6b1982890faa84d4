"""What the owners of the simulated machines have in common: how they guess."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

GUESSED = (0.08, 0.15)
"""How far off a guessed mass or surface is: standard deviation of the logarithm, and the most."""


def guesser(careless: np.random.Generator | None) -> Callable[[float], float]:
    """Return what an owner takes a value for: exact, or drawn by *careless* anew at every call."""

    def guess(value: float) -> float:
        if careless is None:
            return value
        deviation, most = GUESSED
        off = float(np.clip(deviation * careless.standard_normal(), -most, most))
        return float(f"{value * np.exp(off):.3g}")

    return guess


def told(module: str) -> dict[str, Any]:
    """Return what every owner writes alike, from ``owner.toml`` beside a module's file."""
    return tomllib.loads(Path(module).with_name("owner.toml").read_text(encoding="utf-8"))
