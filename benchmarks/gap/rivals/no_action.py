"""No action: the calibrated machine stays as it is, and nothing is named."""

from __future__ import annotations

from benchmarks.gap.rivals.question import Question, Told

TITLE = "No action"


def answer(question: Question) -> Told:
    """Say nothing."""
    return Told()
