"""Other methods on the same questions, each in a file of its own, and how they are asked.

A rival is a module with ``TITLE`` and ``answer(question)``, found by walking this folder. All of
them start from the same calibrated machine as the gap finder.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from benchmarks.gap.clock import clocked
from benchmarks.gap.rivals.question import Question, Told
from gap_finder.regimes import floor_of, gap_of

HELPERS = ("question",)


@cache
def rivals() -> dict[str, ModuleType]:
    """Return all rivals by name."""
    names = [entry.name for entry in pkgutil.iter_modules(__path__) if entry.name not in HELPERS]
    return {name: importlib.import_module(f"{__name__}.{name}") for name in sorted(names)}


def ask_rivals(
    folder: Path, without: Sequence[str] = (), names: Sequence[str] | None = None
) -> dict[str, dict[str, Any]]:
    """Return what the rivals say of a case, by name, in the form of the gap finder's answer.

    Parameters
    ----------
    folder : Path
        Of the case's runs.
    without : sequence of str
        Effects that they are not to know.
    names : sequence of str, optional
        Rivals to ask; by default all.
    """
    with clocked() as shared:
        question = Question(folder, without)
    found = {}
    for name in rivals() if names is None else names:
        with clocked() as spent:
            told: Told = rivals()[name].answer(question)
        seconds = {key: shared[key] + spent[key] for key in spent}
        found[name] = {
            "method": rivals()[name].TITLE,
            "seconds": seconds,
            "answer": _answer(question, told),
        }
    return found


def _answer(question: Question, told: Told) -> dict[str, Any]:
    after = question.left if told.left is None else told.left
    holdout = {
        "before": gap_of(question.machine, question.left),
        "after": gap_of(question.machine, after),
        "floor": floor_of(question.left),
    }
    effects = []
    for key in told.named:
        name, _, channel = key.partition(":")
        effects.append({"name": name, **({"channel": channel} if channel else {})})
    return {
        "verdict": "effect" if effects else "none_missing",
        "effects": effects,
        "one_of": [],
        "gap": {"holdout": holdout},
        "more": told.more,
    }
