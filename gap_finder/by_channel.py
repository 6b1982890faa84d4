"""Leave-one-run-out cost of each channel, and what candidates take away of it.

A mistake of the description at one part may show on one thermometer of two dozen. Of all that is
left it explains little then, whatever it is; of what is left of that channel it must explain most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap_finder.candidates import Candidate
from gap_finder.design import RunDesign
from gap_finder.screen import NormalMatrices, ResidualSets, Screen, answers_in_blocks
from plant_model.parameters import FloatArray


@dataclass(frozen=True)
class ChannelCosts:
    """Costs by channel, each run predicted from the others, for each data set.

    Attributes
    ----------
    left : array, shape (D, C)
        Without any candidate, all runs together, of the channels asked for.
    gain : array, shape (D, C, m)
        What each candidate takes away of it.
    """

    left: FloatArray
    gain: FloatArray

    @property
    def share(self) -> FloatArray:
        """The gain as a share of what is left, shape (D, C, m)."""
        return np.asarray(self.gain / np.maximum(self.left[:, :, None], 1e-12))


def by_channel(
    screen: Screen,
    designs: Sequence[RunDesign],
    tried: Sequence[Candidate],
    residuals: Sequence[FloatArray],
    data: ResidualSets,
    channels: int,
    some: Sequence[int],
) -> ChannelCosts:
    """Return the costs of data sets in *some* of all *channels*.

    *residuals* is an array (D, N) for each run.
    """
    count = len(residuals[0])
    left = np.zeros((count, len(some)))
    gain = np.zeros((count, len(some), len(tried)))
    for run, (design, residual) in enumerate(zip(designs, residuals, strict=True)):
        fold = screen.fold_without(run)
        _, scale, _, solved = fold.fit(data)
        shown = design.cleaned(residual.T - design.shared @ solved.T)
        shown = shown.reshape(-1, channels, count)
        left += np.sum(shown[:, some] ** 2, axis=0).T
        for part, columns in answers_in_blocks(tried, run, design):
            moved = design.cleaned(columns - design.shared @ fold.follow[:, part])
            moved = moved.reshape(-1, channels, moved.shape[1])
            for place, i in enumerate(some):
                across = shown[:, i].T @ moved[:, i]
                squares = np.sum(moved[:, i] ** 2, axis=0)
                gain[:, place, part] -= scale[:, part] * (2.0 * across + scale[:, part] * squares)
    return ChannelCosts(left, gain)


def unseen_by_channel(designs: Sequence[RunDesign], moved: FloatArray, channels: int) -> FloatArray:
    """Return what is left of each run and channel, predicted from the other runs, shape (R, C).

    *moved* is where calibration left its parameters, in the fitting scale.
    """
    residuals = [design.residual[None] for design in designs]
    screen = Screen(NormalMatrices.of(designs, ()))
    data = ResidualSets.of(designs, (), residuals, moved)
    left = []
    for run, (design, residual) in enumerate(zip(designs, residuals, strict=True)):
        _, _, _, solved = screen.fold_without(run).fit(data)
        shown = design.cleaned(residual.T - design.shared @ solved.T)
        left.append(np.sum(shown.reshape(-1, channels) ** 2, axis=0))
    return np.array(left)
