"""Tables of the Gaussian for compensator files written by hand."""

from collections.abc import Sequence
from typing import Any


def apart(spread: Sequence[float]) -> list[list[float]]:
    """Return the root of the covariance of noise that is not correlated."""
    return [
        [one if row == column else 0.0 for column in range(len(spread))]
        for row, one in enumerate(spread)
    ]


def knows_nothing(targets: int, inputs: int = 2) -> dict[str, Any]:
    """Return the table of a Gaussian that adds nothing, finds nothing new and does not walk."""
    return {
        "reference": "start",
        "constant": [0.0] * targets,
        "settled_h": 0.0,
        "lags_s": [],
        "weights": [[0.0] * inputs] * targets,
        "scale": [0.0],
        "seen": [],
        "walk_per_h": 0.0,
        "noise": apart([1.0] * targets),
        "rows": 100.0,
        "deviations": 2.0,
        "coverage": 0.9,
    }


def learnt(table: dict[str, Any], lags_s: tuple[float, ...] = (600.0,)) -> dict[str, Any]:
    """Return a file's table of two inputs with a Gaussian that learnt something.

    Training saw the two inputs rise together, so the novelty is that of their difference, save a
    hundredth of that of their sum; and that of what is behind the lags.
    """
    targets = len(table["error_model"]["targets"])
    behind = [0.0] * (2 * len(lags_s))
    return table | {
        "gaussian": knows_nothing(targets)
        | {
            "lags_s": list(lags_s),
            "weights": [[1.0, 0.5, *([0.25, 0.125] * len(lags_s))]] * targets,
            "scale": [0.5] * (1 + len(lags_s)),
            "seen": [[0.495**0.5 / 2**0.5, 0.495**0.5 / 2**0.5, *behind]],
            "walk_per_h": 0.25,
            "noise": apart([1.0, 4.0, 3.0, 2.0, 0.5][:targets]),
        }
    }
