"""An axis of LinuxCNC as it was found to treat external offsets, for tests without it."""

from dataclasses import dataclass

from gateway.linuxcnc.axes import COUNT_UM, Seen


@dataclass
class ControlAxis:
    """It takes increments while it is on, keeps its offset off, and absorbs it on again."""

    on: bool = True
    homed: bool = True
    programmed_mm: float = 0.0
    command_mm: float = 0.0
    request_um: float = 0.0
    counts: int = 0

    @property
    def motor_um(self) -> float:
        return 1e3 * self.command_mm + self.request_um

    @property
    def moved_um(self) -> float:
        """How far the axis is from where the program has it."""
        return self.motor_um - 1e3 * self.programmed_mm

    def seen(self) -> Seen:
        return Seen(self.on and self.homed, self.request_um, self.command_mm)

    def give(self, counts: int) -> None:
        if self.on and self.homed:
            self.request_um += (counts - self.counts) * COUNT_UM
        self.counts = counts

    def switch(self, on: bool) -> None:
        if on and not self.on:
            self.command_mm, self.request_um = self.motor_um / 1e3, 0.0
        self.on = on

    def go_to(self, programmed_mm: float) -> None:
        assert self.on
        self.programmed_mm = self.command_mm = programmed_mm
