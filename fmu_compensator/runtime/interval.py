"""How far the drift of the tool tip may be from the predicted one."""

from __future__ import annotations

from dataclasses import dataclass

from fmu_compensator.runtime.fields import Fields

NOT_KNOWN = -1.0
"""What stands for a half width that no file tells [um]."""


@dataclass(frozen=True, slots=True)
class Interval:
    r"""The drift lies within the prediction plus and minus half a width, in most samples.

    .. math:: h = s(L) (t_0 + t)^p

    t is the time since the first valid sample, at most ``longest_h``; s is linear in the tool
    length L between the shortest and the longest tool.

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
    shortest_um, longest_um : tuple of float or None
        s at the shortest and the longest tool, for X, Y and Z [um per h^p]; None for an axis
        along which nothing was measured.
    tool_length_mm : tuple of float
        Shortest and longest tool [mm].
    """

    coverage: float
    power: float
    fresh_h: float
    longest_h: float
    shortest_um: tuple[float | None, ...]
    longest_um: tuple[float | None, ...]
    tool_length_mm: tuple[float, float]

    @classmethod
    def from_fields(cls, fields: Fields, tool_length_mm: tuple[float, float]) -> Interval:
        """Return the interval of a file's table."""
        interval = cls(
            fields.number("coverage", 0.01, 0.9999),
            fields.number("power", 0.0, 2.0),
            fields.number("fresh_h", 1e-3, 100.0),
            fields.number("longest_h", 0.0, 1e5),
            _scales(fields, "shortest_tool_um"),
            _scales(fields, "longest_tool_um"),
            tool_length_mm,
        )
        fields.done()
        return interval

    def half_width(self, since_start_s: float, tool_length_mm: float) -> tuple[float, float, float]:
        """Return half the width for X, Y and Z [um]; `NOT_KNOWN` for an axis without one.

        Parameters
        ----------
        since_start_s : float
            Time since the first valid sample [s].
        tool_length_mm : float
            Taken to the nearer end where it is outside the range; anything counts as the shortest
            tool where the range is one length, or where it is not a number.
        """
        low, high = self.tool_length_mm
        share = (tool_length_mm - low) / (high - low) if low < high else 0.0
        share = min(share, 1.0) if share > 0.0 else 0.0
        grown = (self.fresh_h + min(since_start_s / 3600.0, self.longest_h)) ** self.power
        x, y, z = (
            NOT_KNOWN if a is None or b is None else (a + share * (b - a)) * grown
            for a, b in zip(self.shortest_um, self.longest_um, strict=True)
        )
        return x, y, z


def _scales(fields: Fields, key: str) -> tuple[float | None, ...]:
    values = fields.items(key, 3, 3, "numbers or nulls, for X, Y and Z")
    place = f"{fields.place}.{key}" if fields.place else key
    table = Fields({str(n): value for n, value in enumerate(values)}, fields.source, place)
    return tuple(table.number_or_none(str(n), 0.0, 1e5) for n in range(3))
