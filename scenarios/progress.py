"""Progress of long work whose steps are told in words."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm


@contextmanager
def spoken(quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """Show what is being done on one line of the terminal, with the time that has passed."""
    with tqdm(
        bar_format="{desc} [{elapsed}]", file=sys.stderr, disable=quiet or not sys.stderr.isatty()
    ) as line:

        def say(text: str) -> None:
            line.set_description_str(text)
            line.update()

        yield say
