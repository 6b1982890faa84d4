"""An even clock over unevenly sampled inputs, for models that count steps."""

from __future__ import annotations

MOST_TICKS = 5000
"""Most steps counted at once; after a longer pause a time-series model has forgotten everything
anyway: set on no data."""


def ticks(age_s: float, step_s: float) -> tuple[int, float]:
    """Return how many steps have passed, and the remaining time [s].

    Parameters
    ----------
    age_s : float
        Time since the last step began [s].
    step_s : float
        Length of a step [s]. Half a step early counts as on time, so that a jittering sampling
        interval still gives one step per sample.

    Returns
    -------
    count : int
    left_over_s : float
        [s]; negative if the last step came early.
    """
    count = int((age_s + 0.5 * step_s) // step_s)
    return min(count, MOST_TICKS), age_s - count * step_s
