"""How far the drift of the tool tip may be from the predicted one."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.guard import axis_numbers

NOT_KNOWN = -1.0
"""What stands for a half width that no file tells [um]."""


@dataclass(frozen=True, slots=True)
class Interval:
    r"""The drift lies within the prediction plus and minus half a width, in most samples.

    .. math:: w = s(L)\, (t_0 + t)^p \sqrt{1 + k h}\, \sqrt u

    t is the time since the first valid sample, at most ``longest_h``; s is linear in the tool
    length L between the shortest and the longest tool; h is the novelty of the inputs (`Guard`)
    and u the share of doubt that is left since a measurement (`Correction`).

    Attributes
    ----------
    coverage : float
        Share of the samples of an unseen run that lie within [1].
    power : float
        p: how the width grows with time [1].
    fresh_h : float
        t_0 [h].
    longest_h : float
        The longest run that the interval was learnt from [h].
    per_novelty : float
        k: how the error's variance grows with novelty [1].
    shortest_um, longest_um : tuple of float or None
        s at the shortest and the longest tool, for X, Y and Z [um per h^p]; None for an axis
        along which nothing was measured.
    """

    coverage: float
    power: float
    fresh_h: float
    longest_h: float
    per_novelty: float
    shortest_um: tuple[float | None, ...]
    longest_um: tuple[float | None, ...]

    @classmethod
    def from_fields(cls, fields: Fields, *, novelty: bool = True) -> Interval:
        """Return the interval of a file's table; *novelty*: whether its format knows it."""
        interval = cls(
            fields.number("coverage", 0.01, 0.9999),
            fields.number("power", 0.0, 2.0),
            fields.number("fresh_h", 1e-3, 100.0),
            fields.number("longest_h", 0.0, 1e5),
            fields.number("per_novelty", 0.0, 1e4) if novelty else 0.0,
            axis_numbers(fields, "shortest_tool_um"),
            axis_numbers(fields, "longest_tool_um"),
        )
        fields.done()
        return interval

    def growth(self, since_start_s: float, novelty: float) -> float:
        """Return the width over its scale, before any measurement [h^p].

        Parameters
        ----------
        since_start_s : float
            Time since the first valid sample [s].
        novelty : float
            Of the inputs [1].
        """
        grown = (self.fresh_h + min(since_start_s / 3600.0, self.longest_h)) ** self.power
        return float(grown * sqrt(1.0 + self.per_novelty * novelty))

    def half_width(self, growth: float, tool_share: float) -> tuple[float, float, float]:
        """Return half the width for X, Y and Z [um]; `NOT_KNOWN` for an axis without one.

        Parameters
        ----------
        growth : float
            See `growth`, times the root of the doubt that is left.
        tool_share : float
            Where the tool is from the shortest (0) to the longest (1).
        """
        x, y, z = (
            NOT_KNOWN if a is None or b is None else (a + tool_share * (b - a)) * growth
            for a, b in zip(self.shortest_um, self.longest_um, strict=True)
        )
        return x, y, z
