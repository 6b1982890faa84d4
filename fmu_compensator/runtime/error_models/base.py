"""What every error model can do at run time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any, ClassVar

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import checked_state


class Remembering:
    """What has a memory that JSON and a host can carry.

    Attributes
    ----------
    remembers : tuple of str
        Attributes that change from sample to sample: numbers, flags, lists of them, and what is
        `Remembering` itself; zeros are a fresh start unless `reset` says otherwise.
    """

    remembers: ClassVar[tuple[str, ...]] = ()

    def state(self) -> list[float]:
        """Return what is remembered, number by number."""
        return [value for name in self.remembers for value in _numbers(getattr(self, name))]

    def restore(self, state: Sequence[float]) -> None:
        """Take up the state that `state` returned.

        Raises
        ------
        ValueError
            If it has another length, or holds something that is not a finite number.
        """
        values = iter(checked_state(state, len(self.state())))
        for name in self.remembers:
            setattr(self, name, _filled(getattr(self, name), values))


def _numbers(held: Any) -> list[float]:
    if isinstance(held, Remembering):
        return held.state()
    return [v for one in held for v in _numbers(one)] if isinstance(held, list) else [float(held)]


def _filled(held: Any, values: Iterator[float]) -> Any:
    if isinstance(held, Remembering):
        held.restore([next(values) for _ in held.state()])
        return held
    if isinstance(held, list):
        return [_filled(one, values) for one in held]
    value = next(values)
    # What is whole now, as a sum of nothing is, need not have been.
    kept = type(held)(value)
    return kept if kept == value else value


class ErrorModel(Remembering, ABC):
    """From checked temperatures to the drift of the measured quantities.

    A model overrides `from_fields` and `predict`. One with a memory (a lag, past errors) names it
    in `remembers`.

    Attributes
    ----------
    uses_measured : bool
        Whether it takes measured targets in at run time, in a way of its own; else the Gaussian
        that stands on it does.
    linear : bool
        Whether a prediction is a constant and a weighted sum of this sample's inputs: then the FMU
        in C gives derivatives.
    c_twin : str
        Its twin in C, where that is no file of the same name beside; empty: then ``--native``
        refuses it.
    other_fits : tuple of str
        Kinds beside that of its file's name which are fitted in ways of their own and run as it.
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
            The table ``error_model``; ``kind`` and ``targets`` are read already.
        inputs, targets : int
            How many temperatures were chosen, and how many quantities are predicted.

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
            Time since the sample before this one [s]; 0 for the first.
        speed : float
            Spindle speed [rpm]; NaN when it is not known.
        measured : sequence of float, optional
            The targets as measured at the sample before this one, where a displacement sensor is
            at hand [um, urad].
        """

    def reset(self) -> None:
        """Forget everything remembered from earlier samples."""
        self.restore([0.0] * len(self.state()))
