"""FANUC: external machine coordinate system shift by PMC words."""

from __future__ import annotations

from gateway.controls.base import Control, Write

ALARM = 9999
"""A change of so many detection units at once is an alarm: given by the control's manual."""


class Fanuc(Control):
    """A word an axis in detection units; what is written is applied at once, as a move.

    Parameters
    ----------
    signs : sequence of int
        See `Control`.
    unit_um : float
        The detection unit [um].
    """

    name = "fanuc"
    title = "FANUC"
    source = "Connection Manual (Function): external data input, machine zero point shift"

    def __init__(self, signs: tuple[int, int, int] = (1, 1, 1), unit_um: float = 1.0) -> None:
        self.step_um = unit_um
        self.most_um = 32_767 * unit_um
        self.most_at_once_um = (ALARM - 1) * unit_um
        super().__init__(signs)

    def write(self, axis: str, digits: int) -> list[Write]:
        """Give the offset in detection units, along the axis."""
        return [Write(f"shift[{axis}]", digits)]
