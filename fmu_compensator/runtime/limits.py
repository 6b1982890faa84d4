"""The limits of an offset: how large it may get and how fast it may move."""

from __future__ import annotations

from dataclasses import dataclass

from fmu_compensator.runtime.fields import Fields
from fmu_packaging.variables import LONGEST_TOOL_MM, USUAL_TOOL_MM


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a compensator.

    Attributes
    ----------
    offset_um : float
        Largest offset, in either direction [um].
    slew_um_per_s : float
        Fastest change of an offset [um/s].
    hold_s : float
        How long the last good offset is held after a fault, before it is ramped to zero [s].
    recover_s : float
        How long the inputs must be good after a fault before they are used again [s].
    tool_length_mm : tuple of float
        Shortest and longest tool for which the geometry is valid [mm].
    share : float
        Share of the predicted drift that is compensated, 0 to 1 [1]; 1 minimises the squared error.
    """

    offset_um: float
    slew_um_per_s: float
    hold_s: float
    recover_s: float
    tool_length_mm: tuple[float, float]
    share: float = 1.0

    @classmethod
    def from_fields(cls, fields: Fields) -> Limits:
        """Return the limits of a file's table."""
        limits = cls(
            fields.number("offset_um", 0, 1e5),
            fields.number("slew_um_per_s", 1e-6, 1e4),
            fields.number("hold_s", 0, 1e6),
            fields.number("recover_s", 0, 1e6),
            cls._tool_length(fields),
            fields.number("share", 0.0, 1.0) if fields.has("share") else 1.0,
        )
        fields.done()
        return limits

    @staticmethod
    def _tool_length(fields: Fields) -> tuple[float, float]:
        low, high = fields.numbers("tool_length_mm", 2, LONGEST_TOOL_MM)
        if not low <= high:
            raise fields.refusal(
                "tool_length_mm", f"[{low:g}, {high:g}] is not allowed: must be [shortest, longest]"
            )
        return low, high

    def judged_tool(self, asked_mm: float | None = None) -> float:
        """Return the tool length at which runs are judged: the one requested, or the usual [mm]."""
        return self.nearest_tool(USUAL_TOOL_MM) if asked_mm is None else asked_mm

    def nearest_tool(self, tool_length_mm: float) -> float:
        """Return the nearest allowed tool length [mm]; the shortest for NaN."""
        low, high = self.tool_length_mm
        return min(tool_length_mm, high) if tool_length_mm > low else low

    def saturated(self, offset_um: float) -> float:
        """Return the nearest allowed offset [um]."""
        largest = self.offset_um
        if -largest <= offset_um <= largest:
            return offset_um
        return min(max(offset_um, -largest), largest)

    def slewed(self, offset_um: float, wanted_um: float, step_s: float) -> float:
        """Return the offset after moving for *step_s* towards *wanted_um* [um].

        This is the last guard: NaN moves nothing, and no offset leaves its limit.
        """
        reach = self.slew_um_per_s * step_s
        if abs(wanted_um - offset_um) <= reach:
            return self.saturated(wanted_um)
        if wanted_um > offset_um:
            return self.saturated(offset_um + reach)
        return self.saturated(offset_um - reach) if wanted_um < offset_um else offset_um
