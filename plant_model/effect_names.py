"""Names of effects in machine files, and of the inputs that are named after effects."""

from __future__ import annotations


def effect_key(name: str, channel: str = "") -> str:
    """Return an effect's key in a machine file: its name, and its channel or driver, if any.

    Parameters
    ----------
    name : str
    channel : str
        The sensor that it acts on, or its driver; empty for an effect that has neither.
    """
    return f"{name}:{channel}" if channel else name


def name_of(key: str) -> str:
    """Return the name in a key: that of an effect, or of a kind of change.

    Parameters
    ----------
    key : str
        As `effect_key` gives it.
    """
    return key.partition(":")[0]


def leaps_of(key: str) -> str:
    """Return the name of the input that holds an effect's measured leaps.

    The input is an array, shape (K,): +1 or -1 if the measured elongation leaps up or down at the
    end of a step, else 0. It exists only in a comparison with measured runs.

    Parameters
    ----------
    key : str
        As `effect_key` gives it.
    """
    return f"{key} leaps"


def switched_by(key: str) -> str:
    """Return the name of the input that holds when an effect was switched, as measured on a part.

    The input is an array, shape (K,): the share of the next step in which the effect was on. It
    exists only in a comparison with measured runs: a model with a slightly wrong temperature of
    the part would switch at other instants.

    Parameters
    ----------
    key : str
        As `effect_key` gives it.
    """
    return f"{key} on"
