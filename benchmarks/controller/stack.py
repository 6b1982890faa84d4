"""How deep the stack gets: from the call graph that GCC writes, with the frame of each function."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes \(([\w,]+)\)')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
INDIRECT = "__indirect_call"
POINTED_AT = re.compile(r"\.c:\w*(?:predict|make|reset)$")
"""What the program calls through a pointer: the functions of the error models."""


class Stack:
    """The frames of a program's functions, and who calls whom.

    Parameters
    ----------
    files : iterable of Path
        What ``-fcallgraph-info=su`` wrote.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        self.frames: dict[str, int] = {}
        self._calls: dict[str, set[str]] = {}
        for path in files:
            text = path.read_text("utf-8")
            for name, size, kind in NODE.findall(text):
                if kind not in ("static", "dynamic,bounded"):
                    raise ValueError(f"{name}: its frame is {kind}, of no known size")
                self.frames[name] = int(size)
            for caller, callee in EDGE.findall(text):
                self._calls.setdefault(caller, set()).add(callee)
        pointed_at = {name for name in self.frames if POINTED_AT.search(name)}
        for callees in self._calls.values():
            if INDIRECT in callees:
                callees |= pointed_at

    def deepest(self, name: str, above: tuple[str, ...] = ()) -> int:
        """Return how many bytes a call of a function takes at most.

        Functions of the C library count as nothing. A function that is on the way already is not
        entered again: an error model that holds others holds none of its own kind.
        """
        way = (*above, name)
        entered = [
            one for one in self._calls.get(name, ()) if one in self.frames and one not in way
        ]
        return self.frames[name] + max((self.deepest(one, way) for one in entered), default=0)
