"""The forms of items that a machine file may hold: what each kind refers to, and its numbers."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class NumberSpec:
    """What a number of an item or an effect is: its unit and the range that makes sense at all."""

    unit: str
    low: float
    high: float
    default: float | None = None


@dataclass(frozen=True)
class ItemSpec:
    """The form of one kind of item.

    Attributes
    ----------
    refs : dict of str to str
        Roles and what may stand there: ``node``, ``input``, ``boundary`` or a choice such as
        ``node|boundary``; a trailing ``*`` allows a list.
    numbers : dict of str to NumberSpec
        Its parameters; one with a default may be left out.
    only_one : str
        What is said to a machine with more than one; empty if it may have many.
    """

    refs: dict[str, str]
    numbers: dict[str, NumberSpec] = field(default_factory=dict)
    only_one: str = ""
