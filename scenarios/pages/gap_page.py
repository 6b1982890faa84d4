"""The gap finder's page and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gap_finder.find import Judged
from gap_finder.five_lines import five_lines
from gap_finder.forward_backward import Hypothesis, SearchResult, Step
from gap_finder.keys import driver_of, place_of
from gap_finder.kinds import kinds
from gap_finder.long_log import own_hours
from gap_finder.regimes import RunResiduals
from plant_model.effects import catalogue
from plant_model.machine import Machine
from scenarios.pages.channel_charts import channel_charts, measured_against_model
from scenarios.pages.charts import BEFORE, LINES, Chart, Line
from scenarios.pages.gap_map import RegimeMap, regime_map
from scenarios.pages.gap_signature import signature_charts
from scenarios.pages.report import write_page

PAGE = "report.html"
HELD_OUT = "The held-out run."


def write_gap_page(
    judged: Judged,
    table: dict[str, Any],
    facts: Sequence[tuple[str, str]],
    folder: Path,
) -> list[Path]:
    """Write the page and its figures into *folder* and return the files."""
    from scenarios.pages.figures import draw  # only here: it loads Matplotlib

    result, unseen = judged.result, judged.unseen
    charts = signature_charts(result) + [
        chart
        for before, after in zip(unseen.before, unseen.after, strict=True)
        for chart in _charts(before, after)
    ]
    names = {"calibration": "runs used", "holdout": "held-out run"}
    page = write_page(
        "gap.html",
        folder / PAGE,
        title=result.before.machine.title,
        lines=five_lines(table),
        **bars(table["channels"]),
        gap=[(names[key], row) for key, row in table["gap"].items()],
        channels=list(table["channels"].items()),
        rounds=[_round(step, result.search) for step in result.search.steps],
        look_at=table["look_at"],
        where=table["where"],
        remaining=table["remaining"],
        maps=_maps(judged),
        faults=table["data_faults"],
        parameters=result.after.calibration.parameters,
        known=result.before.machine.parameters,
        cosimulation=table.get("cosimulation"),
        charts=charts,
        facts=facts,
    )
    return [page, *(draw(chart, folder) for chart in charts)]


def bars(channels: Mapping[str, Mapping[str, float]]) -> dict[str, Any]:
    """Return the values of the template ``gap_bars.html``: gaps in units of each channel's noise.

    Parameters
    ----------
    channels : mapping of str to mapping
        As in ``gap.json``.
    """
    ratios = {
        name: {key: row[key] / row["noise"] for key in ("before", "after", "reference")}
        for name, row in channels.items()
    }
    same = all(row["before"] == row["after"] for row in ratios.values())
    most = max((value for row in ratios.values() for value in row.values()), default=1.0)
    return {"ratios": ratios, "most": most, "shown": ["before", *([] if same else ["after"])]}


def _maps(judged: Judged) -> list[tuple[str, RegimeMap]]:
    """Return the regime maps of the calibrated machine, without and with what was added."""
    used, unseen = judged.used, judged.unseen
    maps = [("calibrated as given", regime_map([*used.before, *unseen.before]))]
    if judged.result.keys:
        maps.append(("with what was added", regime_map([*used.after, *unseen.after])))
    return maps


def _round(step: Step, search: SearchResult) -> dict[str, Any]:
    begun = step.baseline.fit
    return {
        "what": ", ".join(_title(key, begun.machine) for key in step.baseline.keys) or "nothing",
        "share": search.explained(step.baseline),
        **_costs(step.baseline, step),
        "rows": [
            {
                "title": _title(hypothesis.keys[-1], hypothesis.fit.machine),
                "share": search.explained(hypothesis),
                **_costs(hypothesis, step),
            }
            for hypothesis in step.tried
        ],
    }


def _costs(hypothesis: Hypothesis, step: Step) -> dict[str, float]:
    return {
        "cost": hypothesis.fit.cost,
        "left_out": hypothesis.cost_left_out(step.units),
        "in_fit": hypothesis.cost_in_fit,
        "score": hypothesis.score(step.units),
    }


def _title(key: str, machine: Machine) -> str:
    name, _, channel = key.partition(":")
    if name in kinds():
        return f"{kinds()[name].title}: {' and '.join(place_of(key))}"
    driver = driver_of(machine, key)[1]
    if driver:
        return f"{catalogue()[name].title}, driven by {driver}"
    return catalogue()[name].title + (f" on {channel}" if channel else "")


def _charts(before: RunResiduals, after: RunResiduals) -> list[Chart]:
    """Return charts of one run against the model and, on a separate scale, of the residuals."""
    same = before is after
    before, after = _drawn(before), _drawn(after)
    time = before.observed.time_s
    models = [("calibrated as given", before), ("with what was added", after)]
    return [
        *measured_against_model(models[:1] if same else models, HELD_OUT),
        *channel_charts(
            before,
            lambda i: _lines(time, before.values[:, i], after.values[:, i], same),
            name="residual",
            title="Model minus measurement",
            note=HELD_OUT,
        ),
    ]


def _drawn(run: RunResiduals) -> RunResiduals:
    observed = own_hours(run.observed)
    return RunResiduals(observed, run.values[-len(observed.time_s) :])


def _lines(time: Any, before: Any, after: Any, same: bool) -> tuple[Line, ...]:
    first = Line("calibrated as given", time, before, BEFORE)
    return (first,) if same else (first, Line("with what was added", time, after, LINES[0], rank=2))
