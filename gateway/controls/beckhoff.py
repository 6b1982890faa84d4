"""Beckhoff TwinCAT CNC (TF5200), and the ISG kernel that it is built on: CNC objects by ADS."""

from __future__ import annotations

from gateway.controls.base import Control, Write
from measurement.rig import AXES

PORT, GROUP = 551, 0x120300
"""The task GEO, and the index group of its axes' objects: given by TF5200's manual."""
ACTIVATED = 0x0041
"""Of ``TEMPC::activated``, below the axis number: given by TF5200's manual."""


class TwinCat(Control):
    """Offset, coefficient and position of each axis; the coefficient stays zero.

    The offset is written as ``TEMPC::offset_0``, P-AXIS-00273; its index offset differs between
    versions and is to be taken from the control's list of objects. A large step is spread over
    ``temp_comp_n_cycles``.
    """

    name = "twincat"
    title = "Beckhoff TwinCAT CNC"
    source = "TF5200 Axis Compensation: temperature compensation, CNC objects"
    step_um = 0.1
    most_um = 0.1 * (2**31 - 1)

    def start(self) -> list[Write]:
        """Switch the compensation on, without a slope."""
        made = []
        for number, axis in enumerate(AXES, 1):
            place = f"ads:{PORT} 0x{GROUP:X}"
            made += [Write(f"{place} TEMPC::coefficient[{axis}]", 0.0)]
            made += [Write(f"{place} TEMPC::offset_0[{axis}]", 0)]
            made += [
                Write(f"{place} 0x{number << 16 | ACTIVATED:X} TEMPC::activated[{axis}]", True)
            ]
        return made

    def write(self, axis: str, digits: int) -> list[Write]:
        """Give the offset in tenths of a micrometre."""
        return [Write(f"ads:{PORT} 0x{GROUP:X} TEMPC::offset_0[{axis}]", digits)]
