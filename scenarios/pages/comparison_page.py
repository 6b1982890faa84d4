"""Presents a comparison of error models: ranking, curves of unseen runs, convergence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmu_compensator.fit.comparison import Comparison, Judged, Row
from measurement.faults import Fault, by_column, group_line
from measurement.units import UNITS
from scenarios.pages.charts import (
    BEFORE,
    LINES,
    SHOWN,
    Chart,
    Line,
    Panel,
    convergence_chart,
    with_gaps,
)
from scenarios.pages.report import short, write_page


@dataclass(frozen=True)
class TargetCell:
    """One target's figures in a line of the table; NaN if there are none.

    Attributes
    ----------
    unseen, median : float
        RMSE of all unseen runs, and the median over them [um, urad].
    eta : float
        Predictive ability on unseen runs [%].
    largest : float
        Largest error on unseen runs [um, urad].
    alone : float
        RMSE of unseen runs with the error model alone [um, urad].
    counts : float
        Weight of its prediction next to the Gaussian [%].
    """

    unseen: float
    median: float
    eta: float
    largest: float
    alone: float
    counts: float


@dataclass(frozen=True)
class TableRow:
    """One line of the ranking table."""

    rank: str
    row: Row
    cells: list[TargetCell]
    coverage: str


def table_of(comparison: Comparison) -> list[TableRow]:
    """Return the ranking as lines; models that use displacement have no rank."""
    lines, rank = [], 0
    for row in comparison.rows:
        unranked = row.name in ("no_model", "persistence") or row.uses_displacement
        rank += not unranked
        lines.append(
            TableRow("" if unranked else str(rank), row, _cells(comparison, row), _coverage(row))
        )
    return lines


def _cells(comparison: Comparison, row: Row) -> list[TargetCell]:
    unseen = comparison.figures(row.validate)
    each = [comparison.figures([run]) for run in row.validate]
    alone = comparison.figures(row.alone) if row.alone else {}
    counts = comparison.counted(row) if row.alone else {}
    return [
        TargetCell(
            unseen[name]["rmse"],
            float(np.median([figures[name]["rmse"] for figures in each])),
            100.0 * unseen[name]["eta"],
            unseen[name]["max_abs"],
            alone[name]["rmse"] if alone else np.nan,
            100.0 * counts.get(name, np.nan),
        )
        for name in comparison.targets
    ]


def _coverage(row: Row) -> str:
    return " ".join(f"{100.0 * share:.0f}" for share in row.coverage[1:])


def ranking_text(comparison: Comparison) -> str:
    """Return the ranking as lines of fixed-width text.

    Parameters
    ----------
    comparison : Comparison
    """
    head = f"{'':<44}" + "".join(
        f"{f'{name} [{unit}]':>38}"
        for name, unit in zip(comparison.targets, comparison.units, strict=True)
    )
    columns = f"{'unseen':>8}{'median':>8}{'eta%':>6}{'alone':>8}{'counts%':>8}"
    lines = [
        "ranked by the RMSE on unseen runs as a share of the drift, columns of one unit together",
        "RMSE on unseen runs (all samples), the median over the runs, and eta;",
        "the error model alone on unseen runs, and the share of it that counts beside the Gaussian",
        head,
        f"{'':<44}{columns * len(comparison.targets)}  90% interval holds [%]",
    ]
    rows = table_of(comparison)
    lines += [_line(line) for line in rows if not line.row.uses_displacement]
    shown = [_line(line) for line in rows if line.row.uses_displacement]
    if shown:
        lines += ["Given the displacement measured one sample before:", *shown]
    return "\n".join(lines)


def _line(line: TableRow) -> str:
    cells = "".join(
        f"{short(c.unseen):>8}{short(c.median):>8}{c.eta:>6.0f}"
        + ("" if np.isnan(c.alone) else f"{short(c.alone):>8}{c.counts:>8.0f}").rjust(16)
        for c in line.cells
    )
    coverage = f"  {line.coverage}" if line.coverage else ""
    return f"{line.rank:>2} {line.row.title:<41}{cells}{coverage}"


def best_rows(comparison: Comparison) -> list[Row]:
    """Return the best models that do not use displacements."""
    rows = [row for row in comparison.rows if not row.uses_displacement and row.chosen]
    return rows[:SHOWN]


def charts_of(comparison: Comparison) -> list[Chart]:
    """Return a chart for each unseen run, measured and by the best models, and convergences."""
    best = best_rows(comparison)
    charts = []
    for number, judged in enumerate(best[0].validate[:SHOWN] if best else ()):
        panels = tuple(
            Panel(f"{name} [{UNITS[unit].label}]", _lines(best, number, place, judged))
            for place, (name, unit) in enumerate(
                zip(comparison.targets, comparison.units, strict=True)
            )
        )
        note = "Gaps: rows in which a displacement was frozen or saturated are not judged."
        charts.append(Chart(f"unseen_{number + 1}", f"Unseen run {judged.run}", note, panels))
    curves = {
        row.title: row.report["curve"]
        for row in comparison.rows
        if not row.uses_displacement and row.report.get("curve")
    }
    return [*charts, *([convergence_chart(curves)] if curves else [])]


def _lines(best: Sequence[Row], number: int, place: int, judged: Judged) -> tuple[Line, ...]:
    time, measured = with_gaps(judged.time_s, judged.measured[:, place])
    lines = [Line("Measured", time, measured, BEFORE, rank=0)]
    for rank, row in enumerate(best):
        same = next(run for run in row.validate[number:] if run.run == judged.run)
        time, predicted = with_gaps(same.time_s, same.predicted[:, place])
        lines.append(Line(row.title, time, predicted, LINES[rank], rank=SHOWN - rank))
    return tuple(lines)


def write_figures(comparison: Comparison, folder: Path) -> list[Path]:
    """Write the figures as PNG files and return them.

    Parameters
    ----------
    comparison : Comparison
    folder : Path

    Returns
    -------
    list of Path
    """
    from scenarios.pages.figures import draw  # only here: it loads Matplotlib

    ranking = _draw_ranking(comparison, folder / "ranking.png")
    return [*(draw(chart, folder) for chart in charts_of(comparison)), ranking]


def _draw_ranking(comparison: Comparison, path: Path) -> Path:
    from matplotlib.figure import Figure

    from scenarios.pages.figures import saved

    lines = [line for line in table_of(comparison) if not line.row.uses_displacement][::-1]
    count = len(comparison.targets)
    figure = Figure(figsize=(4.0 + 2.6 * count, 1.2 + 0.32 * len(lines)), layout="constrained")
    axes = figure.subplots(1, count, sharey=True, squeeze=False)[0]
    for place, ax in enumerate(axes):
        values = [line.cells[place].unseen for line in lines]
        ax.barh([line.row.title for line in lines], values, color=LINES[place % len(LINES)])
        name, unit = comparison.targets[place], comparison.units[place]
        ax.set_title(f"{name}: RMSE on unseen runs [{UNITS[unit].label}]", fontsize=9)
        ax.spines[["top", "right"]].set_visible(False)
        # A model that diverges must not flatten all others: its bar is cut, its number is not.
        end = 1.5 * float(np.median(values)) + 1e-9
        ax.set_xlim(0.0, end)
        for number, value in enumerate(values):
            text = short(value) + (" (cut)" if value > end else "")
            ax.text(0.02 * end, number, text, va="center", fontsize=7, color="white")
    return saved(figure, path)


def write_comparison(comparison: Comparison, faults: Sequence[Fault], path: Path) -> Path:
    """Write the page, and return the path given.

    Parameters
    ----------
    comparison : Comparison
    faults : sequence of Fault
        Faults in the runs.
    path : Path
        Replaced if it exists.
    """
    lines = table_of(comparison)
    return write_page(
        "comparison.html",
        path,
        title="Error models compared",
        comparison=comparison,
        targets=list(zip(comparison.targets, comparison.units, strict=True)),
        free=[line for line in lines if not line.row.uses_displacement],
        fed=[line for line in lines if line.row.uses_displacement],
        faults=[group_line(group) for group in by_column(faults)],
        charts=charts_of(comparison),
        judged=len({run.run for run in comparison.rows[0].validate}),
    )
