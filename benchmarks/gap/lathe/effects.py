"""Laws of the lathe's effects, beside those common to all simulators or with the belt's."""

from __future__ import annotations

from benchmarks.gap import laws
from benchmarks.gap.drive import Array, Drive, lagged
from benchmarks.gap.hidden import Hidden, X
from benchmarks.gap.lathe.machine import Lathe
from benchmarks.gap.march import Now


class ColumnBending(Hidden, unit="urad/K"):
    """The bed warps late with its warmth above the hall, which tilts the headstock; urad per K."""

    def move(self, machine: Lathe, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Carry the spindle along, one way or the other."""
        bed = temperatures[:, machine.parts["bed"]].mean(axis=1)
        late = lagged(drive.time_s, bed - drive.at(), 3600.0 * self.more["tau_h"])
        tilt = self.more["sign"] * self.size * (late - late[0])
        pose[:, X] += tilt * self.more["lever_mm"] * 1e-3


class ChipHeap(laws.PartSource):
    """Hot chips pile up on the bed and are carried off, by a program of its own; watts."""

    def watts(self, now: Now) -> float:
        """Return the heat, more and more until they are carried off."""
        heap = (now.time / 3600.0 / self.more["period_h"]) % 1.0
        return 2.0 * self.size * heap
