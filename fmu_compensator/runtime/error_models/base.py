"""Base class of the error models at run time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any, ClassVar

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import checked_state


class Remembering:
    """An object whose memory a host can save and restore.

    Attributes
    ----------
    remembers : tuple of str
        Attributes that change from sample to sample: numbers, flags, lists of them, and other
        `Remembering` objects; all zeros is the initial state unless `reset` is overridden.
    """

    remembers: ClassVar[tuple[str, ...]] = ()

    def state(self) -> list[float]:
        """Return the memory as a flat list of numbers."""
        return [value for name in self.remembers for value in _numbers(getattr(self, name))]

    def restore(self, state: Sequence[float]) -> None:
        """Restore what `state` returned.

        Raises
        ------
        ValueError
            If it has another length, or contains something that is not a finite number.
        """
        values = iter(checked_state(state, len(self.state())))
        for name in self.remembers:
            setattr(self, name, _filled(getattr(self, name), values))


def _numbers(held: Any) -> list[float]:
    if isinstance(held, Remembering):
        return held.state()
    return [v for part in held for v in _numbers(part)] if isinstance(held, list) else [float(held)]


def _filled(held: Any, values: Iterator[float]) -> Any:
    if isinstance(held, Remembering):
        held.restore([next(values) for _ in held.state()])
        return held
    if isinstance(held, list):
        return [_filled(part, values) for part in held]
    return type(held)(next(values))


class ErrorModel(Remembering, ABC):
    """Predicts the drift of the measured quantities from checked temperatures.

    A model overrides `from_fields` and `predict`. One with a memory (a lag, past errors) names it
    in `remembers`.

    Attributes
    ----------
    uses_measured : bool
        Whether the model itself uses measured targets at run time; otherwise the Gaussian does.
    linear : bool
        Whether a prediction is a constant plus a weighted sum of this sample's inputs; then the C
        FMU provides derivatives.
    c_twin : str
        Source of its C twin, if that is not a file of the same name next to it; without either,
        ``--native`` refuses it.
    other_fits : tuple of str
        Further kinds that are fitted differently but run as this class.
    """

    uses_measured: bool = False
    linear: ClassVar[bool] = False
    c_twin: ClassVar[str] = ""
    other_fits: ClassVar[tuple[str, ...]] = ()

    @classmethod
    @abstractmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> ErrorModel:
        """Return the model that the file's numbers describe.

        Parameters
        ----------
        fields : Fields
            The table ``error_model``; ``kind`` and ``targets`` have already been read.
        inputs, targets : int
            Number of chosen temperatures and of predicted quantities.

        Raises
        ------
        ModelFileError
            For the first number that is missing, of the wrong type, or out of range.
        """

    @abstractmethod
    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets [um, urad].

        Parameters
        ----------
        inputs : sequence of float
            The chosen temperatures in the file's order and input form [degC or K].
        elapsed_s : float
            Time since the previous sample; 0 for the first [s].
        speed : float
            Spindle speed [rpm]; NaN if unknown.
        measured : sequence of float, optional
            The targets measured at the previous sample, if there is a displacement sensor
            [um, urad].
        """

    def reset(self) -> None:
        """Forget all earlier samples."""
        self.restore([0.0] * len(self.state()))
