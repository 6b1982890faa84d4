"""A fault in the data, described in the same words by every command."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from measurement.runs import Run

STANDING = ("frozen", "saturated")
"""Kinds of a constant channel: the first reading of the span was true."""


@dataclass(frozen=True)
class Kind:
    """How faults of one kind are handled.

    Attributes
    ----------
    handling : str
        In words.
    use : {"none", "rises", "all"}
        Usable part of the channel in this span: none, because the readings are not what the machine
        did; its rises, because only the level is wrong; or all of it.
    """

    handling: str
    use: str = "all"


LEFT_OUT = Kind("this part of the channel is left out", "none")
WRONG_LEVEL = Kind("not used where absolute levels count; rises are not affected", "rises")


@dataclass(frozen=True)
class Fault:
    """A fault of one channel in one span of one run.

    Attributes
    ----------
    run : str
        The run's name.
    column : str
        The channel; ``time_s`` if the whole record is affected.
    kind : str
        One of `measurement.faults.kinds.HANDLING`.
    start_s, end_s : float
        Start and end of the span [s].
    text : str
        What is wrong, in words.
    place : int
        Index of the run among those checked, because names need not differ.
    """

    run: str
    column: str
    kind: str
    start_s: float
    end_s: float
    text: str
    place: int = 0

    @classmethod
    def between(
        cls, run: Run, column: str, kind: str, first: int, last: int, text: str, place: int = 0
    ) -> Fault:
        """Return a fault from one row of a run to another."""
        start_s, end_s = float(run.time_s[first]), float(run.time_s[last])
        return cls(run.name, column, kind, start_s, end_s, text, place)

    @property
    def handling(self) -> str:
        """How it is handled, in words."""
        from measurement.faults.kinds import HANDLING  # made from the checks, which need this file

        return HANDLING[self.kind]

    @property
    def is_gross(self) -> bool:
        """Whether the channel is unusable in this span."""
        from measurement.faults.kinds import GROSS

        return self.kind in GROSS

    def line(self) -> str:
        """Return run, column, span, what is wrong, and how it is handled."""
        return f"{self.run}, {self.column}, {self.when()}: {self.text}; {self.handling}"

    def when(self) -> str:
        """Return the span in minutes."""
        start, end = self.start_s / 60.0, self.end_s / 60.0
        # One reading, or a span whose ends are the same minute.
        return f"at {start:.0f} min" if end - start < 0.5 else f"{start:.0f} to {end:.0f} min"

    def to_dict(self) -> dict[str, Any]:
        """Return the fault as a plain dict, without the place."""
        table = asdict(self) | {"handling": self.handling}
        del table["place"]
        return table
