"""Siemens SINUMERIK 840D sl: temperature compensation by setting data."""

from __future__ import annotations

from gateway.controls.base import Control, Write
from measurement.rig import AXES


class Sinumerik(Control):
    """Offset, slope and reference of each axis; the model's slope over the position is zero.

    MD32750 bit 0 switches the position-independent part on. A large step is spread over cycles by
    MD32760, without an alarm.
    """

    name = "sinumerik"
    title = "Siemens SINUMERIK"
    source = "Function Manual Extended Functions, K3: temperature compensation"
    step_um = 0.01

    def start(self) -> list[Write]:
        """Switch on the part that is independent of the position, and no other."""
        made = []
        for axis in AXES:
            made += [Write(f"SD43910 $SA_TEMP_COMP_SLOPE[{axis}]", 0.0)]
            made += [Write(f"SD43920 $SA_TEMP_COMP_REF_POSITION[{axis}]", 0.0)]
            made += [Write(f"SD43900 $SA_TEMP_COMP_ABS_VALUE[{axis}]", 0.0)]
            made += [Write(f"MD32750 $MA_TEMP_COMP_TYPE[{axis}]", 1)]
        return made

    def write(self, axis: str, digits: int) -> list[Write]:
        """Give the offset in millimetres."""
        return [Write(f"SD43900 $SA_TEMP_COMP_ABS_VALUE[{axis}]", digits * self.step_um / 1e3)]
