"""An even clock over uneven samples, for models that count steps."""

from __future__ import annotations

MOST_TICKS = 5000
"""After a longer pause a series model has forgotten everything anyway: set on no data."""


def ticks(age_s: float, step_s: float) -> tuple[int, float]:
    """Return how many steps have passed, and the age that is left over [s].

    Parameters
    ----------
    age_s : float
        Time since the last step began [s].
    step_s : float
        Length of a step [s]. Half a step early counts as on time, so that a wavering sampling
        interval still gives one step a sample.

    Returns
    -------
    count : int
    left_over_s : float
        [s]; negative where the last step came early.
    """
    count = int((age_s + 0.5 * step_s) // step_s)
    return min(count, MOST_TICKS), age_s - count * step_s
