"""Draws the FMUs' icons: ``python -m docs.draw_icons``."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon, Rectangle

STEEL, HOT, COLD, DARK = "#5b6b7b", "#d9480f", "#1971c2", "#1c2733"


def _canvas() -> tuple[Figure, Axes]:
    figure, axes = plt.subplots(figsize=(2.56, 2.56), dpi=100)
    figure.subplots_adjust(0, 0, 1, 1)
    axes.set(xlim=(0, 100), ylim=(0, 100))
    axes.axis("off")
    frame = FancyBboxPatch(
        (3, 3), 94, 94, "round,pad=0,rounding_size=12", fc="white", ec=DARK, lw=3
    )
    axes.add_patch(frame)
    return figure, axes


def _spindle(axes: Axes, top: float) -> None:
    """Draw a vertical spindle whose housing is warmer towards the nose."""
    shades = plt.get_cmap("coolwarm")(np.linspace(0.15, 0.95, 24))
    height = 44 / len(shades)
    for index, shade in enumerate(shades):
        low = top - (index + 1) * height
        axes.add_patch(Rectangle((34, low), 32, height + 0.3, fc=shade, ec="none"))
    axes.add_patch(Rectangle((34, top - 44), 32, 44, fc="none", ec=DARK, lw=2))
    nose = Polygon(
        [(38, top - 44), (62, top - 44), (56, top - 53), (44, top - 53)], fc=STEEL, ec=DARK
    )
    axes.add_patch(nose)
    axes.add_patch(Rectangle((47, top - 71), 6, 18, fc=STEEL, ec=DARK))


def _plant(path: Path) -> None:
    figure, axes = _canvas()
    _spindle(axes, 88)
    axes.plot([20, 80], [17, 17], color=DARK, lw=1.5, ls=(0, (4, 3)))
    axes.annotate("", (76, 9), (76, 32), arrowprops={"arrowstyle": "-|>", "color": HOT, "lw": 3})
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)


def _compensator(path: Path) -> None:
    figure, axes = _canvas()
    time = np.linspace(0, 1, 80)
    drift = 30 * (1 - np.exp(-4 * time))
    axes.plot([14, 14, 88], [88, 14, 14], color=DARK, lw=2)
    axes.plot(16 + 70 * time, 50 + drift, color=HOT, lw=4)
    axes.plot(16 + 70 * time, 50 - drift, color=COLD, lw=4)
    axes.plot(16 + 70 * time, 50 + 0.8 * np.sin(25 * time), color=DARK, lw=2.5)
    arrows = {"arrowstyle": "-|>", "color": STEEL, "lw": 2.5}
    axes.annotate("", (62, 54), (62, 75), arrowprops=arrows)
    axes.annotate("", (62, 46), (62, 25), arrowprops=arrows)
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)


def _signals(path: Path) -> None:
    figure, axes = _canvas()
    axes.plot([14, 14, 88], [88, 14, 14], color=DARK, lw=2)
    axes.step([16, 30, 46, 62, 86], [30, 52, 82, 40, 40], where="post", color=STEEL, lw=4)
    axes.plot([16, 86], [24, 30], color=COLD, lw=3)
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    here = Path(__file__).resolve().parents[1] / "fmu_packaging" / "assets"
    _plant(here / "plant.png")
    _compensator(here / "compensator.png")
    _signals(here / "signals.png")
