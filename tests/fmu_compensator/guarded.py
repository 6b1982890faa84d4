"""Compensator files with a guard and a correction, made of those without."""

from __future__ import annotations

from typing import Any


def guarded(table: dict[str, Any], lags_s: tuple[float, ...] = (600.0,)) -> dict[str, Any]:
    """Return the table of two inputs in the newest format.

    Training saw the two inputs rise together, so the novelty is that of their difference, save a
    hundredth of that of their sum; and that of what is behind the lags.
    """
    targets = len(table["error_model"]["targets"])
    behind = [0.0] * (4 * len(lags_s))
    return table | {
        "format": 2,
        "guard": {
            "lags_s": list(lags_s),
            "reference": "start",
            "usual": [0.0, 0.0],
            "constant": [0.0] * targets,
            "direct": [[1.0, 0.5]] * targets,
            "rise_lags": [[[0.5, 0.25]] * targets for _ in lags_s],
            "start_lags": [[[0.1, 0.2]] * targets for _ in lags_s],
            "prior": 0.5,
            "seen": [[0.495**0.5 / 2**0.5, 0.495**0.5 / 2**0.5, *behind]],
            "known": 0.5,
            "leash": [4.0] * targets,
            "fade_shortest": [1.0, None, 0.5],
            "fade_longest": [1.0, None, 1.5],
        },
        "correction": {
            "memory_s": 3600.0,
            "spread": [2.0] * targets,
            "noise": [0.25] * targets,
        },
        "interval": table["interval"] and table["interval"] | {"per_novelty": 3.0},
    }
