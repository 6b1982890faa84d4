"""The null distribution: residuals as they would be if nothing were missing.

Drawn from what may be wrong anyway: every parameter within its range, thermometers' places and
errors, the parts' levers, starting temperatures, and a slow misfit of the size of the tolerance
that any lumped model leaves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter1d

from gap_finder.design import RunDesign
from gap_finder.observations import BIN_S, INDEPENDENT_S, Observations
from gap_finder.screen import Answers, ResidualSets, Screen
from plant_model.parameters import FloatArray

DRAWS = 200
"""Data sets drawn to see what chance does."""


def draw_null(
    designs: Sequence[RunDesign],
    observed: Sequence[Observations],
    count: int,
    seed: int,
    misfit: float = 1.0,
) -> list[FloatArray]:
    """Return residuals of *count* data sets, an array (count, N) for each run.

    Parameters
    ----------
    designs : sequence of RunDesign
    observed : sequence of Observations
    count, seed : int
    misfit : float
        Size of the slow misfit in tolerances.
    """
    generator = np.random.default_rng(seed)
    shared = generator.standard_normal((count, designs[0].shared.shape[1]))
    found = []
    for design, one in zip(designs, observed, strict=True):
        own = generator.standard_normal((count, design.nuisance.shape[1]))
        slow = generator.standard_normal((count, len(one.time_s), len(one.channels)))
        slow = gaussian_filter1d(slow, INDEPENDENT_S / BIN_S / 2.0, axis=1)
        slow /= np.std(slow, axis=1, keepdims=True)
        rough = (
            misfit * slow * one.tolerance * one.weights * design.weight.reshape(one.weights.shape)
        )
        found.append(shared @ design.shared.T + own @ design.nuisance.T + rough.reshape(count, -1))
    return found


def null_residuals(
    screen: Screen,
    designs: Sequence[RunDesign],
    observed: Sequence[Observations],
    tried: Sequence[Answers],
    cost: float,
    seed: int,
) -> list[FloatArray]:
    """Return residuals of data sets with nothing missing that cost as much as the data does.

    It is the slow misfit that is given the size for that.
    """
    sizes = (0.05, 1.0)
    costs = []
    for size in sizes:
        drawn = ResidualSets.of(designs, tried, draw_null(designs, observed, 8, seed, size))
        costs.append(float(np.median(screen.scores(drawn).cost)))
    slope = (costs[1] - costs[0]) / (sizes[1] ** 2 - sizes[0] ** 2)
    misfit = float(np.sqrt(np.clip((cost - costs[0]) / max(slope, 1e-9), 0.05**2, 9.0)))
    return draw_null(designs, observed, DRAWS, seed + 1, misfit)
