"""Makes the table, the percentiles and the summary of a sweep from its outcomes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtri

from fmu_compensator.fit.installed import COVERAGE
from fmu_packaging.reference import DECIMALS
from measurement.resampling import WRONG
from scenarios.pages.charts import SHOWN
from scenarios.signals.base import FloatArray
from scenarios.sweep.plan import Plan

PERCENTILES = (round(50 - 50 * COVERAGE), 50, round(50 + 50 * COVERAGE))
"""Percentiles of a quantity over the cases: the median and the ends of an interval."""
FIGURES = ("before_max_um", "before_mean_um", "after_max_um", "after_mean_um")
GAIN = "improvement_percent"


def case_table(plan: Plan, outcomes: Mapping[int, dict[str, Any]]) -> pd.DataFrame:
    """Return the tidy table: one row per case and axis, in the order of the cases.

    Parameters
    ----------
    plan : Plan
    outcomes : mapping of int to dict
        Outcome of every case, from `scenarios.sweep.case.outcome_of`.

    Returns
    -------
    DataFrame
        ``case``, ``variant``, ``repeat``, ``seed``, a column for each thing that varies,
        ``axis``, the figures before and after compensation [um], ``improvement_percent``,
        ``valid_percent`` of the time, and ``problem``. A case that failed has one row without axis.
    """
    rows = []
    for job in plan.jobs:
        outcome = outcomes[job.number]
        head = {
            "case": job.number,
            "variant": job.variant,
            "repeat": job.repeat,
            "seed": job.case.settings.seed,
        }
        # The seed may itself vary, and then appears once.
        head |= {label: _cell(value) for label, value in job.values.items()}
        last = {"valid_percent": outcome["valid_percent"], "problem": outcome["problem"]}
        for axis, figures in (outcome["axes"] or {"": {}}).items():
            rows.append(head | {"axis": axis} | figures | last)
    columns = [*head, "axis", *FIGURES, GAIN, "valid_percent", "problem"]
    frame = pd.DataFrame(rows, columns=columns)
    numbers = [*FIGURES, GAIN, "valid_percent"]
    frame[numbers] = frame[numbers].astype("float64").round(DECIMALS)
    return frame


def _cell(value: Any) -> Any:
    """Return a value for a table cell; as JSON if it is not a scalar."""
    return json.dumps(value, default=str) if isinstance(value, dict | list) else value


def over_time(plan: Plan, outcomes: Mapping[int, dict[str, Any]]) -> pd.DataFrame:
    """Return the percentiles over the cases at times of the run.

    Returns
    -------
    DataFrame
        ``variant``, ``time_s``, and for each of drift and error and each axis the percentiles
        ``drift_X_p5_um`` ... [um].
    """
    parts = []
    for variant in plan.titles:
        here = [outcomes[job.number] for job in plan.jobs if job.variant == variant]
        here = [outcome for outcome in here if outcome["curves"]]
        if not here:
            continue
        moments: FloatArray = np.array(here[0]["time_s"], dtype=np.float64)
        columns: dict[str, Any] = {"variant": [variant] * len(moments), "time_s": moments}
        for name in here[0]["curves"]:
            curves = [
                np.interp(moments, outcome["time_s"], np.array(outcome["curves"][name], float))
                for outcome in here
            ]
            bands = np.nanpercentile(np.stack(curves), PERCENTILES, axis=0)
            stem = name.removesuffix("_um")
            columns |= {
                f"{stem}_p{percentile}_um": np.round(band, DECIMALS)
                for percentile, band in zip(PERCENTILES, bands, strict=True)
            }
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def summary(plan: Plan, frame: pd.DataFrame) -> dict[str, Any]:
    """Return the summary of a sweep, ready for JSON.

    Returns
    -------
    dict
        ``cases``, ``failed``, ``problems`` (the first few), ``vary`` (labels), and ``variants``:
        by variant and axis the percentiles over the cases of each figure, the ``worst`` case, and
        ``rank_correlation``: significant Spearman correlations of the mean remaining error with
        what varies.
    """
    bad = frame[frame["problem"] != ""]
    table: dict[str, Any] = {
        "cases": len(plan.jobs),
        "failed": len(bad),
        "problems": bad["problem"].unique()[:5].tolist(),
        "vary": [entry.label for entry in plan.variations],
        "percentiles": list(PERCENTILES),
        "variants": {},
    }
    good = frame[frame["problem"] == ""]
    for (variant, axis), rows in good.groupby(["variant", "axis"], sort=False):
        entry = table["variants"].setdefault(
            str(variant), {"title": plan.titles[str(variant)], "axes": {}}
        )
        entry["axes"][str(axis)] = _of_axis(plan, rows)
    return table


def _of_axis(plan: Plan, rows: pd.DataFrame) -> dict[str, Any]:
    labels = {entry.label: entry.is_drawn for entry in plan.variations}
    figures = {
        name: [round(float(value), 3) for value in np.percentile(values, PERCENTILES)]
        for name in (*FIGURES, GAIN)
        if len(values := rows[name].dropna())
    }
    worst = rows.iloc[int(rows["after_max_um"].argmax())]
    return {
        "percentiles": figures,
        "worst": {
            "case": int(worst["case"]),
            "after_max_um": round(float(worst["after_max_um"]), 3),
            "values": {label: _plain(worst[label]) for label in labels},
        },
        "rank_correlation": _correlations(rows, labels),
    }


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _correlations(rows: pd.DataFrame, labels: Mapping[str, bool]) -> dict[str, float]:
    """Return Spearman's rank correlation of the mean remaining error with each number that varies.

    Only significant ones: by chance alone, one sweep in a hundred reports any. Grid points share
    their draws, so a drawn number has as many independent cases as repeats.
    """
    left = rows["after_mean_um"]
    chance = float(-ndtri(WRONG / 2.0 / max(len(labels), 1)))
    by_label = {}
    for label, drawn in labels.items():
        column = rows[label]
        count = rows["repeat"].nunique() if drawn else len(rows)
        if count < 2 or left.nunique() < 2 or column.nunique() < 2:
            continue
        if pd.api.types.is_numeric_dtype(column):
            value = float(column.astype(float).corr(left, method="spearman"))
            if abs(value) >= chance / math.sqrt(count - 1):
                by_label[label] = round(value, 3)
    return dict(sorted(by_label.items(), key=lambda entry: -abs(entry[1])))


def as_text(table: Mapping[str, Any]) -> str:
    """Return a summary as fixed-width text.

    Parameters
    ----------
    table : mapping
        The content of ``summary.json``.
    """
    wide = max([len(name) for name in table["variants"]] + [7]) + 2
    lines = [
        " " * wide + "         before, largest [um]      after, largest [um]    mean better by [%]",
        " " * wide + "axis  " + "".join(f"{p:>7} %" for p in PERCENTILES) + "  "
        + "".join(f"{p:>7} %" for p in PERCENTILES) + "  "
        + "".join(f"{p:>6} %" for p in PERCENTILES),
    ]  # fmt: skip
    notes = []
    for variant, entry in table["variants"].items():
        for axis, row in entry["axes"].items():
            figures = row["percentiles"]
            cells = "".join(f"{v:>9.1f}" for v in figures["before_max_um"]) + "  "
            cells += "".join(f"{v:>9.1f}" for v in figures["after_max_um"]) + "  "
            cells += "".join(f"{v:>8.0f}" for v in figures.get(GAIN, ()))
            lines.append(f"{variant:<{wide}}{axis:<6}{cells}")
            strong = list(row["rank_correlation"].items())[:SHOWN]
            if strong:
                cells = ", ".join(f"{label} {value:+.2f}" for label, value in strong)
                notes.append(f"{variant:<{wide}}{axis:<6}{cells}")
    if notes:
        lines += ["", "What the mean error after goes with (rank correlation):", *notes]
    return "\n".join(line.rstrip() for line in lines)
