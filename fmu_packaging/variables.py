"""The declaration of one FMU variable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Value: TypeAlias = float | int | bool | str
Kind: TypeAlias = Literal["real", "integer", "boolean", "string"]
Causality: TypeAlias = Literal["input", "output", "parameter", "local"]
Variability: TypeAlias = Literal["continuous", "discrete", "fixed", "tunable"]

ZERO: dict[str, Value] = {"real": 0.0, "integer": 0, "boolean": False, "string": ""}
START_DEGC = 20.0
"""Start value of a temperature in both FMUs [degC]: the reference temperature, given by ISO 1."""
USUAL_TOOL_MM, LONGEST_TOOL_MM = 100.0, 2000.0
"""Usual length of a tool, with which FMUs start and runs are judged, and its limit [mm]: set on no
data."""


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    Attributes
    ----------
    name : str
        Its name in the structured convention, for example ``links.front.conductance``.
    kind : str
        ``real``, ``integer``, ``boolean`` or ``string``.
    causality : str
        ``input``, ``output``, ``parameter``, or ``local``: computed, like an output.
    description : str
        Description in one line.
    unit : str
        Unit of a real variable, for example ``degC`` or ``W/K``; ``1`` for a pure number; empty:
        not specified.
    display_unit : str or None
        The unit that a tool should display.
    start : float, int, bool or str
        Start value of an input or a parameter [unit].
    low, high : float or int or None
        Allowed range [unit].
    nominal : float or None
        A typical magnitude [unit].
    variability : str or None
        None: the usual one; a parameter is fixed, a real is continuous, the rest is discrete.
    depends_at_start : tuple of str or None
        For an output: the inputs and parameters that its initial value depends on; None: it may
        depend on all of them.
    depends : tuple of str
        For a computed variable during the simulation: the inputs and states that its value depends
        on at the same instant.
    derivative_of : str or None
        The continuous state that it is the derivative of.
    clock : str
        Its clock, if it is transmitted on a bus; empty: none.
    elements : int
        Number of elements of an array; 0: it is a scalar.
    """

    name: str
    kind: Kind
    causality: Causality
    description: str
    unit: str = "1"
    display_unit: str | None = None
    start: Value | None = None
    low: float | None = None
    high: float | None = None
    nominal: float | None = None
    variability: Variability | None = None
    depends_at_start: tuple[str, ...] | None = None
    depends: tuple[str, ...] = ()
    derivative_of: str | None = None
    clock: str = ""
    elements: int = 0

    def __post_init__(self) -> None:
        """Fill in what follows from the other fields."""
        if self.variability is None:
            usual: Variability = "continuous" if self.kind == "real" else "discrete"
            object.__setattr__(self, "variability", "fixed" if self.is_parameter else usual)
        if self.start is None and not self.is_computed:
            object.__setattr__(self, "start", ZERO[self.kind])

    @property
    def is_output(self) -> bool:
        """Whether the FMU computes it and exposes it."""
        return self.causality == "output"

    @property
    def is_computed(self) -> bool:
        """Whether the FMU computes it."""
        return self.causality in {"output", "local"}

    @property
    def is_parameter(self) -> bool:
        """Whether it is set before the start and then constant, unless it is tunable."""
        return self.causality == "parameter"

    def refusal(self, value: Value) -> str:
        """Return why *value* is not allowed, in one line; empty if it is allowed.

        NaN marks a missing input, so only parameters must be finite.

        Parameters
        ----------
        value : float, int, bool or str
            In the variable's unit.
        """
        if self.kind not in {"real", "integer"} or isinstance(value, str):
            return ""
        low = float("-inf") if self.low is None else self.low
        high = float("inf") if self.high is None else self.high
        if low <= value <= high:
            return ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.name}: {value:g} is not allowed: it must be {low:g} to {high:g}{unit}"
