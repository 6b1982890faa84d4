"""The counter of the house, on files whose counts are known."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.house import code_lines, constants, walked
from measurement.errors import shown

PYTHON = '''"""Says what it is.

In two paragraphs.
"""

# Why.
DEEP, HIGH = 2.0, -3.0
"""What they were set on."""
NAME = "ten"
ON = True
LONG = 24 * 3600


def twice(x: float) -> float:
    """Return it twice."""
    return 2.0 * x  # exact
'''
C = """/* Says what it is,
   in two lines. */
#include <math.h>

// Why.
double twice(double x)
{
    return 2.0 * x; /* exact */
}
"""


@pytest.mark.parametrize(("name", "text", "lines"), [("a.py", PYTHON, 6), ("a.c", C, 5)])
def test_blanks_comments_and_docstrings_are_no_code(
    tmp_path: Path, name: str, text: str, lines: int
) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert code_lines(tmp_path / name) == lines


def test_numbers_of_a_module_are_counted_by_name(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(PYTHON, encoding="utf-8")
    assert constants(tmp_path / "a.py") == 2


def test_a_walk_counts_the_functions_of_this_project_that_run() -> None:
    assert walked(lambda: shown("text")) == (1, 1)
