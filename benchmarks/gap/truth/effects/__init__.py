"""What can be hidden in the jig borer: all that the catalogue names, and what it does not."""

from __future__ import annotations

from functools import cache

from benchmarks.gap.hidden import Hidden, found_in


@cache
def everything() -> dict[str, type[Hidden]]:
    """Return all effects by name, found by walking this folder."""
    return found_in(__path__, __name__)
