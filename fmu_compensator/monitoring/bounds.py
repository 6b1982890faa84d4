"""How large a figure of a further run may be, given those of runs like it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import t as student

from measurement.resampling import WRONG


def upper_bound(values: Sequence[float], risk: float = WRONG) -> float:
    r"""Return the largest figure that a further run like these should have.

    .. math:: \exp(m + t_{1 - r,\,n - 1}\, s \sqrt{1 + 1/n})

    with m and s the mean and the standard deviation of the logarithms: the one-sided prediction
    bound of a log-normal figure. It is never below the largest of the figures themselves. With
    fewer than two it is infinite: nothing is known of how they vary.
    """
    known = np.asarray([value for value in values if np.isfinite(value) and value > 0.0])
    if len(known) < 2:
        return float("inf")
    logs = np.log(known)
    count = len(logs)
    beyond = float(student.ppf(1.0 - risk, count - 1)) * float(logs.std(ddof=1))
    return max(float(np.exp(logs.mean() + beyond * np.sqrt(1.0 + 1.0 / count))), float(known.max()))
