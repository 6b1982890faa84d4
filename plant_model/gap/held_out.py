"""What runs never used say of an answer: it is given only if it does not make them worse."""

from __future__ import annotations

from collections.abc import Sequence

from plant_model.gap.find import Found
from plant_model.gap.observations import Observations
from plant_model.gap.report import Comparison


def confirmed(found: Found, unseen: Sequence[Observations]) -> tuple[Found, Comparison]:
    """Take back what makes runs never used worse, the effect added last first.

    Parameters
    ----------
    found : Found
    unseen : sequence of Observations
        Of runs that took no part in finding it.

    Returns
    -------
    found : Found
        With what is left, and in ``withdrawn`` what was taken back.
    comparison : Comparison
        On these runs, before and after what is left.
    """
    before = found.before.machine
    for count in range(len(found.after.added), 0, -1):
        fewer = found.with_only(count)
        comparison = Comparison(before, fewer.after.machine, unseen)
        gap = comparison.gap()
        if gap["after"] <= gap["before"]:
            return fewer, comparison
    return found.with_only(0), Comparison(before, before, unseen)
