"""One compensator on one question: fitted, installed, and driven through runs it never saw."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.trust.one_idea import TOOL_MM, one_idea
from benchmarks.trust.questions import NO_SLEW, Question, fitted
from fmu_compensator.driving import drive
from fmu_compensator.fit.promise import RunLeft, left_of
from fmu_compensator.runtime.compensator import OK
from measurement.errors import BadInput
from measurement.faults import GROSS, cleaned, find_faults

CHOICE = "fit's own choice"
PROTOTYPE = "one idea"
"""Rises, three lags and one scale a group, without anything around them."""
HALF_WIDTHS = 3.0
"""A sample further off than so many half widths is badly wrong [1]."""


def judge(question: Question, model: str) -> dict[str, Any]:
    """Return how a model does on a question, as JSON can carry it.

    Returns
    -------
    dict
        Beside what the question is:

        - ``axes``, by axis: RMSE without and with the compensator, pooled over the runs, each
          counting as one [um]; share of samples in the interval [1]; mean half width [um]; what
          `fit` promised, the worse of like and unlike runs [um], None where it did not.
        - ``worst``: the largest ratio of a run's RMSE to that without a compensator, over runs and
          axes [1].
        - ``outside``: the share of samples with status 2 [1].
        - ``badly_wrong``: the share of samples with status 0 that are off by more than three half
          widths [1].

    Raises
    ------
    BadInput
        If it cannot be fitted.
    """
    if model == PROTOTYPE:
        runs, promised, wrong = one_idea(question), {}, 0.0
    else:
        runs, promised, wrong = _installed(question, model)
    runs = [run for run in runs if run.axes]
    if not runs:
        raise BadInput(question.name, model, "the compensator started in no run")
    axes, ratios = {}, []
    for axis in runs[0].axes:
        here = [run.axes[axis] for run in runs if axis in run.axes]
        ratios += [one.left / one.none for one in here if one.none > 0.0]
        axes[axis] = {
            "none": _pooled([one.none for one in here]),
            "rmse": _pooled([one.left for one in here]),
            "coverage": float(np.mean([one.inside for one in here])),
            "half_width": float(np.mean([one.half_width for one in here])),
            "promised": promised.get(axis),
        }
    return {
        "data": question.data,
        "question": question.name,
        "model": model,
        "unlike": question.unlike,
        "axes": axes,
        "worst": max(ratios),
        "outside": float(np.mean([run.new for run in runs])),
        "badly_wrong": wrong,
    }


def _installed(question: Question, model: str) -> tuple[list[RunLeft], dict[str, float], float]:
    """Return what is left of the judged runs, what was promised, and the share badly wrong."""
    named = None if model == CHOICE else model
    # The tool is fixed here.
    installed = fitted(question, named, judge=named is None, limits=NO_SLEW)
    left = cleaned(question.judged, find_faults(question.judged), GROSS)
    pairs = zip(question.judged, left, strict=True)
    driven = [drive(installed, run, clean, question.rig, TOOL_MM) for run, clean in pairs]
    wrong = [
        (one.status == OK) & (np.abs(one.error) > HALF_WIDTHS * one.half_width).any(axis=1)
        for one in driven
    ]
    unseen = installed.provenance["figures"]["unseen"] or {}
    promised = {axis: row["model"] for axis, row in unseen.get("promised", {}).items()}
    runs = [left_of(one, run.name) for one, run in zip(driven, question.judged, strict=True)]
    return runs, promised, float(np.mean([np.mean(one) for one in wrong]))


def _pooled(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
