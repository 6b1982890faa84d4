"""Draws the nose in a day, with and without compensation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from benchmarks.linuxcnc.nose import AXES, Nose

TITLES = {"gateway": "Gateway beside the control", "component": "Compensator inside the control"}
COLOURS = dict(zip(AXES, ("#0072B2", "#009E73", "#D55E00"), strict=True))


def draw_days(noses: Mapping[str, Nose], target: Path) -> None:
    """Draw the nose of each day.

    Parameters
    ----------
    noses : mapping of str to Nose
        By kind.
    target : Path
        The file; its ending gives the format.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.1 * len(noses) + 0.4), layout="constrained")
    all_axes = figure.subplots(len(noses), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (kind, nose) in zip(all_axes, noses.items(), strict=True):
        table = nose.table
        hours = table.time_s / 3600.0
        for axis in AXES:
            drift = table[f"drift_{axis.upper()}"]
            axes.plot(hours, drift, color=COLOURS[axis], alpha=0.35, lw=1.2)
            label = f"{axis.upper()}, compensated"
            held = table[f"error_{axis}"].where(table.held)
            axes.plot(hours, held, ".", ms=2.0, color=COLOURS[axis], label=label)
        # After an abort an axis may stand anywhere, which must not set the scale.
        axes.set_ylim(axes.get_ylim())
        for axis in AXES:
            gone = table[f"error_{axis}"].where(~table.held)
            axes.plot(hours, gone, "x", ms=2.0, color="0.6", zorder=0)
        for number, event in enumerate(nose.events, 1):
            later = hours[table.event >= number]
            if "rpm" not in str(event["name"]) and len(later):
                axes.axvline(float(later.iloc[0]), color="0.85", lw=0.8, zorder=0)
        axes.set_title(TITLES.get(kind, kind), loc="left", fontsize=10)
        axes.set_ylabel("nose [um]")
        axes.grid(axis="y", alpha=0.3)
    all_axes[0].legend(ncols=3, fontsize=8, markerscale=4, loc="upper left")
    all_axes[-1].set_xlabel("machine time [h]; lines: drift without compensation; grey: faults")
    figure.savefig(target, dpi=130)
