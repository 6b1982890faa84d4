"""One compensator on one question: fitted, installed, and driven through runs it never saw."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.trust.one_idea import TOOL_MM, one_idea
from benchmarks.trust.questions import Question
from fmu_compensator.driving import drive
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.promise import RunLeft, left_of
from fmu_compensator.runtime.compensator import OK
from fmu_compensator.runtime.modelfile import parse_model
from measurement.errors import BadInput
from measurement.faults import GROSS, cleaned, find_faults

CHOICE = "fit's own choice"
PROTOTYPE = "one idea"
"""Ninety lines with rises, three lags and one scale a group, without anything around them."""
HALF_WIDTHS = 3.0
"""A sample further off than so many half widths is badly wrong [1]."""


@dataclass(frozen=True)
class Result:
    """What came out.

    Attributes
    ----------
    data, question, model, kind : str
        Of the question; the model asked for, and what it was.
    unlike : bool
        Of the question.
    axes : dict
        By axis: RMSE without and with the compensator, pooled over the runs, each counting as one,
        and the medians over the runs [um]; share of samples in the interval [1]; mean half width
        [um]; what `fit` promised, the worse of like and unlike runs [um], None where it did not.
    worst : float
        Largest ratio of a run's RMSE to that without a compensator, over runs and axes [1].
    outside : float
        Share of samples with status 2 [1].
    badly_wrong : float
        Share of samples with status 0 that are off by more than three half widths [1].
    """

    data: str
    question: str
    model: str
    kind: str
    unlike: bool
    axes: dict[str, dict[str, float | None]]
    worst: float
    outside: float
    badly_wrong: float

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON can carry it."""
        return asdict(self)


def judge(question: Question, model: str) -> Result:
    """Return how a model does on a question.

    Raises
    ------
    BadInput
        If it cannot be fitted.
    """
    if model == PROTOTYPE:
        runs, promised, wrong, kind = one_idea(question), {}, 0.0, model
    else:
        runs, promised, wrong, kind = _installed(question, model)
    runs = [run for run in runs if run.axes]
    if not runs:
        raise BadInput(question.name, model, "the compensator started in no run")
    axes: dict[str, dict[str, float | None]] = {}
    for axis in runs[0].axes:
        here = [run.axes[axis] for run in runs if axis in run.axes]
        axes[axis] = {
            "none": _pooled([one.none for one in here]),
            "rmse": _pooled([one.left for one in here]),
            "median_none": float(np.median([one.none for one in here])),
            "median": float(np.median([one.left for one in here])),
            "worst": max(one.left / one.none for one in here if one.none > 0.0),
            "coverage": float(np.mean([one.inside for one in here])),
            "half_width": float(np.mean([one.half_width for one in here])),
            "promised": promised.get(axis),
        }
    return Result(
        question.data,
        question.name,
        model,
        kind,
        question.unlike,
        axes,
        max(float(axis["worst"] or 0.0) for axis in axes.values()),
        float(np.mean([run.new for run in runs])),
        wrong,
    )


def _installed(
    question: Question, model: str
) -> tuple[list[RunLeft], dict[str, float], float, str]:
    """Return what is left of the judged runs, what was promised, and the share badly wrong."""
    named = None if model == CHOICE else model
    # The tool is fixed here; the slew limit of a control has no part in the model's error.
    table = fit_compensator(
        question.train,
        question.rig,
        named,
        limits={"slew_um_per_s": 1000.0},
        judge=named is None,
    )
    parsed = parse_model(compensator_text(table), model)
    left = cleaned(question.judged, find_faults(question.judged), GROSS)
    pairs = zip(question.judged, left, strict=True)
    driven = [drive(parsed, run, clean, question.rig, TOOL_MM) for run, clean in pairs]
    wrong = [
        (one.status == OK) & (np.abs(one.error) > HALF_WIDTHS * one.half_width).any(axis=1)
        for one in driven
    ]
    unseen = table["provenance"]["figures"]["unseen"] or {}
    promised = {axis: row["model"] for axis, row in unseen.get("promised", {}).items()}
    runs = [left_of(one, run.name) for one, run in zip(driven, question.judged, strict=True)]
    share = float(np.mean([np.mean(one) for one in wrong]))
    return runs, promised, share, str(table["error_model"]["kind"])


def _pooled(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
