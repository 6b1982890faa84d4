"""What effects are called in machine files, and what is called after them among the inputs."""

from __future__ import annotations


def effect_key(name: str, channel: str = "") -> str:
    """Return how a machine file names an effect: its name, and its channel or driver, if any.

    Parameters
    ----------
    name : str
    channel : str
        The sensor that it acts on, or its driver; empty for an effect that has neither.
    """
    return f"{name}:{channel}" if channel else name


def name_of(key: str) -> str:
    """Return the name in a key: of an effect, or of a kind of change.

    Parameters
    ----------
    key : str
        As `effect_key` gives it.
    """
    return key.partition(":")[0]


def leaps_of(key: str) -> str:
    """Return the name under which inputs hold what was seen of an effect's leaps.

    An array, shape (K,): +1 or -1 where elongation was seen to leap up or down at the end of a
    step, else 0. Such an input is there only where measured runs are compared with.

    Parameters
    ----------
    key : str
        As `effect_key` gives it.
    """
    return f"{key} leaps"


def switched_by(key: str) -> str:
    """Return the name under which inputs hold when a part was seen to switch an effect.

    An array, shape (K,): the share of the step after each in which it was on. Such an input is
    there only where measured runs are compared with: a model that is a little wrong of the part
    would switch at other instants.

    Parameters
    ----------
    key : str
        As `effect_key` gives it.
    """
    return f"{key} on"
