"""Tables with something else in one place, for readers that must refuse it or read it."""

import copy
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

JUNK = st.one_of(
    st.just(10**400),
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    st.lists(st.integers(), max_size=3),
    st.dictionaries(st.text(max_size=3), st.floats(), max_size=2),
)
"""What a field may hold by mistake."""


def places(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every field below a value."""
    inner = value if isinstance(value, dict) else dict(enumerate(value))
    for key, entry in inner.items():
        yield (*at, key)
        if isinstance(entry, dict | list):
            yield from places(entry, (*at, key))


def mangled(table: Any, path: tuple[Any, ...] | str, value: Any = ...) -> Any:
    """Return a copy with another value at a path, keys or text with points; without it by default.

    What stands below a table that is not there yet comes into a new one.
    """
    *steps, last = path.split(".") if isinstance(path, str) else path
    found = at = copy.deepcopy(table)
    for step in steps:
        at = at[int(step)] if isinstance(at, list) else at.setdefault(step, {})
    last = int(last) if isinstance(at, list) else last
    if value is ...:
        del at[last]
    else:
        at[last] = value
    return found
