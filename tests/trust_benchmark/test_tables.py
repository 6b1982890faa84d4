"""The tables of docs/trust.md, from answers made up."""

from typing import Any

from benchmarks.trust.judge import CHOICE
from benchmarks.trust.tables import tables


def answer(question: str, model: str, rmse: float, *, unlike: bool) -> dict[str, Any]:
    axis = {"none": 10.0, "rmse": rmse, "coverage": 0.9, "half_width": 4.0, "promised": 3.0}
    return {
        "data": "lathe",
        "question": question,
        "model": model,
        "kind": "bayes",
        "unlike": unlike,
        "axes": {"Z": axis},
        "worst": 1.2,
        "outside": 0.25,
        "badly_wrong": 0.01,
    }


def test_like_and_unlike_splits_are_told_apart_and_the_worst_is_shown():
    found = [
        answer("every fifth run", CHOICE, 2.0, unlike=False),
        answer("cold", CHOICE, 4.0, unlike=True),
        answer("warm", CHOICE, 9.0, unlike=True),
    ]
    summary = next(line for line in tables(found).splitlines() if line.startswith("| **fit"))
    cells = [cell.strip() for cell in summary.strip("|").split("|")]
    assert cells[1:] == ["20 %", "90 %", "60 %", "90 %", "120 %", "90 %", "25 %", "1.0 %"]
    assert "one idea" not in tables(found)
    assert "1.5 times the promise, in every axis, in 2 of 3 splits." in tables(found)
