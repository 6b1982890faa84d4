"""First-order lags of temperatures and speeds, and checks shared by models with a memory."""

from __future__ import annotations

from collections.abc import Sequence
from math import expm1, isfinite

from fmu_compensator.runtime.fields import LARGEST, Fields

STILL_RPM, SAME_SPEED_SHARE = 1.0, 0.01
"""Below the first speed the spindle is at a standstill [rpm]; speeds closer than the second are
equal [1]: given by `measurement.spectrum`, which is not part of an FMU."""


def share(elapsed_s: float, tau_s: float) -> float:
    r"""Return the fraction of the way to its input that a lag moves: 1 - exp(-elapsed / tau) [1].

    Parameters
    ----------
    elapsed_s : float
        Time since the last sample [s].
    tau_s : float
        Time constant of the lag, above 0 [s].
    """
    return -expm1(-elapsed_s / tau_s)


def behind(elapsed_s: float, tau_s: float) -> float:
    """Return which share of its last move an input is behind, as a lag sees it [1].

    If the input moved evenly since the last sample, a lag ends where it would if the input had been
    that much behind all the time: half a move for short steps.

    Parameters
    ----------
    elapsed_s, tau_s : float
        As of `share`.
    """
    moved = share(elapsed_s, tau_s)
    return tau_s / elapsed_s - (1.0 - moved) / moved if moved > 0.0 else 0.0


def known_speed(speed: float, last: float) -> float:
    """Return the absolute speed [rpm]; the last known one while it is unknown or absurd.

    Parameters
    ----------
    speed : float
        As given by the host, with either sign [rpm]; NaN: unknown.
    last : float
        Last known speed [rpm].
    """
    return abs(speed) if abs(speed) <= LARGEST else last


def taus(fields: Fields, key: str, count: int | None = None) -> list[float]:
    """Return a list of time constants [s].

    Parameters
    ----------
    fields : Fields
        The table that holds the list.
    key : str
        The list's name.
    count : int, optional
        Required length.

    Raises
    ------
    ModelFileError
        If one is not above 0.
    """
    if count is None:
        count = len(fields.items(key, "time constants"))
    values = fields.numbers(key, count)
    for index, value in enumerate(values):
        if not value > 0.0:
            raise fields.refusal(f"{key}.{index}", f"{value:g} is not allowed: above 0 s")
    return values


def checked_state(state: Sequence[float], length: int) -> list[float]:
    """Return the numbers of a state after checking them.

    Parameters
    ----------
    state : sequence of float
        As returned by a host.
    length : int
        Length of the model's own state.

    Raises
    ------
    ValueError
        If the length is wrong, or a number is not finite.
    """
    if len(state) != length:
        raise ValueError(f"a state of {len(state)} numbers was given, this model has {length}")
    if not all(
        isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
        for value in state
    ):
        raise ValueError("the state holds something that is not a finite number")
    return [float(value) for value in state]


def matrices_by_lag(
    fields: Fields, key: str, lags: int, targets: int, columns: int
) -> list[list[list[float]]]:
    """Return one matrix of weights per lag [um/K, urad/K].

    Parameters
    ----------
    fields : Fields
        The table that holds the list.
    key : str
        The list's name.
    lags, targets, columns : int
        Number of matrices, and rows and columns of each.
    """
    matrices = fields.items(key, "matrices", lags, lags)
    place = f"{fields.place}.{key}" if fields.place else key
    table = Fields({str(lag): matrix for lag, matrix in enumerate(matrices)}, fields.source, place)
    return [table.matrix(str(lag), targets, columns) for lag in range(lags)]
