"""HEIDENHAIN TNC 360 and its like: PLC words with a follow-up of 1 um/s."""

from __future__ import annotations

from gateway.controls.base import Control, Write
from measurement.rig import AXES

WORDS: dict[str, str] = dict(zip(AXES, ("W576", "W578", "W580"), strict=True))


class Tnc(Control):
    """A word an axis in whole micrometres; the control follows it at 1 um/s, without a display.

    Half a micrometre is lost to the word's resolution, and a tool change to its pace.
    """

    name = "tnc"
    title = "HEIDENHAIN TNC"
    source = "TNC 360 Technical Manual 8/95, 1.6.5: temperature compensation"
    step_um = 1.0
    most_um = 32_767.0

    def write(self, axis: str, digits: int) -> list[Write]:
        """Give the offset in micrometres."""
        return [Write(WORDS[axis], digits)]
