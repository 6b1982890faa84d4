"""The tables on how far to trust a compensator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import gmean

from benchmarks.results_page import as_table
from benchmarks.trust.judge import CHOICE, PROTOTYPE

MUCH = 1.5
"""So many times the promise may be left [1]."""
WORSE = 1.05
"""So many times what the reference leaves may be left [1]."""


def tables(found: Sequence[dict[str, Any]]) -> str:
    """Return a summary by model, then every question with fit's own choice beside the rest."""
    good = [one for one in found if "axes" in one]
    return "\n".join([*_summary(good), "", *_kept(good), *_beside(good), *_questions(good)])


def _beside(good: Sequence[dict[str, Any]]) -> list[str]:
    """Return how fit's own choice does beside the reference, row by row."""
    left = {
        (one["data"], one["question"], axis, one["model"]): figures["rmse"]
        for one in good
        for axis, figures in one["axes"].items()
    }
    ratios = [
        own / left[*place, PROTOTYPE]
        for (*place, model), own in left.items()
        if model == CHOICE and (*place, PROTOTYPE) in left
    ]
    if not ratios:
        return []
    worse = sum(ratio > WORSE for ratio in ratios)
    left_beside = f"Beside `{PROTOTYPE}` {100 * gmean(ratios):.0f} % is left"
    says = f"{left_beside} (geometric mean of {len(ratios)} rows)"
    return [f"{says}; {worse} of them leave more than {100 * (WORSE - 1):.0f} % more.", ""]


def _kept(good: Sequence[dict[str, Any]]) -> list[str]:
    """Return in how many splits no axis is left more than `MUCH` times what was promised."""
    ratios = [
        max(axis["rmse"] / axis["promised"] for axis in one["axes"].values())
        for one in good
        if one["model"] == CHOICE and all(axis.get("promised") for axis in one["axes"].values())
    ]
    if not ratios:
        return []
    kept = sum(ratio <= MUCH for ratio in ratios)
    says = f"What is left is at most {MUCH:g} times the promise, in every axis,"
    return [f"{says} in {kept} of {len(ratios)} splits.", ""]


def _ratio(one: dict[str, Any]) -> float:
    return float(gmean([axis["rmse"] / axis["none"] for axis in one["axes"].values()]))


def _summary(good: Sequence[dict[str, Any]]) -> list[str]:
    heads = ["Model", "like: error", "coverage", "unlike: error", "worst split", "worst run"]
    heads += ["coverage", "status 2", "badly wrong at status 0"]
    rows = []
    for model in dict.fromkeys(one["model"] for one in good):
        here = [one for one in good if one["model"] == model]
        cells = [f"`{model}`" if model != CHOICE else f"**{model}**"]
        for unlike in (False, True):
            kind = [one for one in here if one["unlike"] == unlike]
            if not kind:
                cells += ["-"] * (4 if unlike else 2)
                continue
            ratios = [_ratio(one) for one in kind]
            cells.append(f"{100 * gmean(ratios):.0f} %")
            if unlike:
                cells.append(f"{100 * max(ratios):.0f} %")
                cells.append(f"{100 * max(one['worst'] for one in kind):.0f} %")
            covered = [axis["coverage"] for one in kind for axis in one["axes"].values()]
            cells.append(f"{100 * np.mean(covered):.0f} %")
        cells.append(f"{100 * np.mean([one['outside'] for one in here]):.0f} %")
        cells.append(f"{100 * np.mean([one['badly_wrong'] for one in here]):.1f} %")
        rows.append(cells)
    return [as_table(heads, rows)]


def _questions(good: Sequence[dict[str, Any]]) -> list[str]:
    lines = []
    for data in dict.fromkeys(one["data"] for one in good):
        heads = ["Judged on", "", "axis", "none", "fit's own choice", "promised"]
        heads += ["coverage, half width", "status 2", "one idea"]
        width = len(heads) - all(one["model"] != PROTOTYPE for one in good)
        lines += [f"### {data.capitalize()}", ""]
        rows = []
        for question in dict.fromkeys(one["question"] for one in good if one["data"] == data):
            here = [one for one in good if (one["data"], one["question"]) == (data, question)]
            rows += [cells[:width] for cells in _rows(question, here)]
        lines += [as_table(heads[:width], rows), ""]
    return lines


def _rows(question: str, here: Sequence[dict[str, Any]]) -> list[list[str]]:
    own = next((one for one in here if one["model"] == CHOICE), None)
    rival = next((one for one in here if one["model"] == PROTOTYPE), None)
    first = own or here[0]
    rows = []
    for number, (axis, figures) in enumerate(first["axes"].items()):
        like = "unlike" if first["unlike"] else "like"
        cells = [question, like] if number == 0 else ["", ""]
        cells += [axis, f"{figures['none']:.1f}"]
        if own is None:
            cells += ["-", "-", "-", "-"]
        else:
            cells.append(f"{figures['rmse']:.2f}")
            promised = figures.get("promised")
            cells.append("-" if promised is None else f"{promised:.2f}")
            cells.append(f"{100 * figures['coverage']:.0f} %, {figures['half_width']:.1f}")
            cells.append(f"{100 * own['outside']:.0f} %" if number == 0 else "")
        cells.append("-" if rival is None else f"{rival['axes'][axis]['rmse']:.2f}")
        rows.append(cells)
    return rows
