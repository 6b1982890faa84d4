"""The page that ``calibrate`` writes next to the machine file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gap_finder.advice import Advice
from gap_finder.calibrate import Calibration
from gap_finder.comparison import GapComparison
from gap_finder.observations import Observations
from gap_finder.regimes import gap_of
from plant_model.machine import Machine
from scenarios.pages.channel_charts import measured_against_model
from scenarios.pages.charts import SHOWN
from scenarios.pages.report import page_text


def page_beside(machine_file: Path) -> Path:
    """Return the path of the page of a calibrated machine file.

    Parameters
    ----------
    machine_file : Path
        The file that calibration writes.
    """
    path = machine_file.with_suffix(".html")
    return path if path != machine_file else machine_file.with_suffix(".report.html")


def calibration_page(
    given: Machine,
    calibration: Calibration,
    observed: Sequence[Observations],
    advice: Sequence[Advice],
    left_out: Sequence[str],
    facts: Sequence[tuple[str, str]],
) -> str:
    """Return the page of a calibration.

    Parameters
    ----------
    given : Machine
        Before calibration.
    calibration : Calibration
    observed : sequence of Observations
        Observations of the calibration runs.
    advice : sequence of Advice
    left_out : sequence of str
        What was not used of the runs.
    facts : sequence of (str, str)
        Its provenance.
    """
    compared = GapComparison(given, calibration.machine, observed)
    gap = compared.gap()
    left = [gap_of([run]) for run in compared.after]
    drawn = sorted(np.argsort([-value for value in left], kind="stable")[:SHOWN].tolist())
    note = "A run that it was calibrated on."
    if len(drawn) < len(observed):
        note += f" The figure shows the {len(drawn)} of {len(observed)} with the largest error."
    charts = [
        chart
        for run in drawn
        for chart in measured_against_model(
            [("before", compared.before[run]), ("calibrated", compared.after[run])], note
        )
    ]
    return page_text(
        "calibration.html",
        kicker="Calibration",
        title=given.title,
        lines=summary_lines(calibration, gap, len(observed)),
        gap=gap,
        channels=list(compared.channels().items()),
        advice=advice,
        left_out=left_out,
        parameters=calibration.parameters,
        charts=charts,
        facts=facts,
    )


def summary_lines(calibration: Calibration, gap: dict[str, float], runs: int) -> list[str]:
    """Return the page's first lines: the residual, and how little that may mean."""
    determined = sum(entry.is_determined for entry in calibration.parameters)
    several = f"{runs} runs" if runs > 1 else "one run"
    lines = [
        f"On the {several} used for calibration the model error is {gap['after']:.2g} times the "
        f"sensor noise ({gap['before']:.2g} before; noise alone gives {gap['floor']:.2g}). "
        "This does not show how well the model predicts other runs.",
        f"The runs determine {determined} of {len(calibration.parameters)} free parameters.",
    ]
    far = [parameter for parameter in calibration.parameters if parameter.is_far]
    far.sort(key=lambda parameter: -abs(parameter.deviations))
    lines += [
        f"Check {parameter.name}: it ends {abs(parameter.deviations):.1f} deviations from its "
        f"previous value, {parameter.prior:.3g} -> {parameter.value:.3g} ({parameter.source})."
        for parameter in far[:SHOWN]
    ]
    return lines
