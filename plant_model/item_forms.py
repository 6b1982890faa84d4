"""Forms of the items of a machine file: what each kind refers to, and its numbers."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class NumberSpec:
    """A number of an item or an effect: its unit and the range of physically sensible values."""

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
        Roles and what each may refer to: ``node``, ``input``, ``boundary`` or a choice such as
        ``node|boundary``; a trailing ``*`` allows a list.
    numbers : dict of str to NumberSpec
        Its parameters; those with a default may be left out.
    law : str
        What it does, in a line of the documentation.
    only_one : str
        Error message for a machine with more than one; empty if it may have many.
    """

    refs: dict[str, str]
    numbers: dict[str, NumberSpec] = field(default_factory=dict)
    law: str = ""
    only_one: str = ""
