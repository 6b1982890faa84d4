"""Dendrogram and heat map of the temperatures, and the drift against the chosen ones."""

from __future__ import annotations

from math import ceil, sqrt
from pathlib import Path

from matplotlib.figure import Figure
from scipy.cluster.hierarchy import dendrogram

from fmu_compensator.fit.survey import Survey
from scenarios.pages.figures import saved

MOST_NAMED = 10
"""Most runs in the legend: given by matplotlib, whose colours repeat after that many."""


def draw_points(survey: Survey, folder: Path) -> list[Path]:
    """Write ``dendrogram.png``, ``heat_map.png`` and ``loops.png`` and return the files.

    Parameters
    ----------
    survey : Survey
    folder : Path

    Returns
    -------
    list of Path
    """
    return [
        _dendrogram(survey, folder / "dendrogram.png"),
        _heat_map(survey, folder / "heat_map.png"),
        _loops(survey, folder / "loops.png"),
    ]


def _dendrogram(survey: Survey, path: Path) -> Path:
    figure = Figure(figsize=(max(6.0, 0.42 * len(survey.sensors)), 4.0), layout="constrained")
    ax = figure.subplots()
    dendrogram(
        survey.linkage,
        labels=survey.sensors,
        ax=ax,
        leaf_rotation=90,
        color_threshold=0.0,
        above_threshold_color="#1d5fa8",
    )
    ax.set_ylabel("distance between centroids [K]")
    ax.set_title("Hierarchical clustering of the rises (Euclidean, centroid)", fontsize=11)
    ax.spines[["top", "right"]].set_visible(False)
    return saved(figure, path)


def _heat_map(survey: Survey, path: Path) -> Path:
    count = len(survey.sensors)
    size = max(5.0, 0.42 * count)
    figure = Figure(figsize=(size + 1.2, size), layout="constrained")
    ax = figure.subplots()
    # Members of a group are adjacent, so that the groups appear as squares.
    order = [k for group in next(iter(survey.groupings.values())) for k in group]
    names = [survey.sensors[k] for k in order]
    degree = survey.degree[order][:, order]
    image = ax.imshow(degree, vmin=min(0.5, float(degree.min())), vmax=1.0, cmap="viridis")
    ax.set_xticks(range(count), names, rotation=90, fontsize=8)
    ax.set_yticks(range(count), names, fontsize=8)
    if count <= 14:
        for i in range(count):
            for j in range(count):
                colour = "black" if degree[i, j] > 0.8 else "white"
                text = f"{degree[i, j]:.2f}"
                ax.text(j, i, text, ha="center", va="center", fontsize=7, color=colour)
    figure.colorbar(image, ax=ax, label="grey comprehensive degree")
    ax.set_title("How alike the temperatures are", fontsize=11)
    return saved(figure, path)


def _loops(survey: Survey, path: Path) -> Path:
    places = range(len(survey.sensors))
    count = len(places)
    columns = ceil(sqrt(count))
    rows = -(-count // columns)
    figure = Figure(figsize=(3.4 * columns, 3.1 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel()
    for panel, place in zip(panels, places, strict=False):
        loop = survey.loops[place]
        for name, (rises, drift) in zip(survey.run_names, survey.traces, strict=True):
            panel.plot(rises[:, place], drift, linewidth=1.0, label=name)
            panel.plot(rises[-1, place], drift[-1], "o", markersize=3, color="black")
        later = "later" if loop.lag_min >= 0.0 else "earlier"
        least = "at least " if loop.is_limit else ""
        when = f"{least}{abs(loop.lag_min):.0f} min {later}"
        panel.set_title(
            f"{survey.sensors[place]}: drift {when}, {loop.rate:.3g} {survey.unit}/K", fontsize=9
        )
        panel.set_xlabel("rise [K]")
        panel.spines[["top", "right"]].set_visible(False)
    for panel in panels[count:]:
        panel.set_visible(False)
    for panel in panels[::columns]:
        panel.set_ylabel(f"{survey.target} [{survey.unit}]")
    if 1 < len(survey.run_names) <= MOST_NAMED:
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=columns, fontsize=8)
    title = "Drift against temperature: one line per run, the dot is its end"
    figure.suptitle(title if columns > 1 else title.replace(": ", ":\n"), fontsize=11)
    return saved(figure, path)
