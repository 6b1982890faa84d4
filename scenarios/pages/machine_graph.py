"""Draws the thermal network of a machine: parts, and the heat paths between them."""

from __future__ import annotations

from math import log10

import numpy as np

from plant_model.checks import Part, part_of
from plant_model.machine import Machine
from scenarios.pages.machine_drawing import BORDER, DRAWING_WIDTH, colour
from scenarios.pages.svg import INK, label, part, picture

STROKES = {"wall": "#8b929c", "air": "#c3a15a", "coolant": "#2f6fb3"}
KINDS = {
    "convection": "air",
    "air_gap": "air",
    "coolant_flow": "coolant",
    "coolant_wall": "coolant",
}


def network_svg(
    machine: Machine, parts: tuple[Part, ...], links: dict[tuple[str, str], float]
) -> str:
    """Return the network as SVG.

    Parameters
    ----------
    machine : Machine
    parts : tuple of Part
    links : dict
        Conductance of each pair [W/K].
    """
    outside = list(machine.boundary_index)
    names = [part.name for part in parts] + [name for name in outside if _used(name, links)]
    place, height = _placed(names, links)
    kinds = _kinds(machine)
    drawn = []
    strongest = max(links.values(), default=1.0)
    for (a, b), g in links.items():
        (x1, y1), (x2, y2) = place[a], place[b]
        width = 1.0 + 5.0 * max(0.0, 1.0 + log10(max(g, 1e-3) / strongest) / 3.0)
        stroke = STROKES[kinds.get((a, b)) or kinds.get((b, a)) or "wall"]
        looks: dict[str, object] = {"stroke": stroke, "stroke_width": width}
        looks["stroke_opacity"] = 0.7
        ends = {"x1": x1, "y1": y1, "x2": x2, "y2": y2}
        drawn.append(part("line", "", f"{a} to {b}: {g:.3g} W/K", **ends, **looks))
    low, high = min(lump.warm for lump in parts), max(lump.warm for lump in parts)
    for lump in parts:
        x, y = place[lump.name]
        ring = {"read": "#b3402f", "beside": INK, "unseen": "#aab1ba"}[lump.seen]
        size = 6.0 + 2.2 * max(0.0, log10(max(lump.capacity, 10.0)) - 1.0)
        title = f"{lump.name}: {lump.capacity:.3g} J/K, {lump.warm:.1f} degC, {lump.seen}"
        looks = {"fill": colour(lump.warm, low, high), "stroke": ring, "stroke_width": 2}
        drawn.append(part("circle", "", title, cx=x, cy=y, r=size, **looks))
        count = f" ({lump.nodes})" if lump.nodes > 1 else ""
        drawn.append(label(x, y - size - 4.0, f"{lump.name}{count}"))
    for name in names[len(parts) :]:
        x, y = place[name]
        looks = {"fill": "#ffffff", "stroke": STROKES["coolant"], "stroke_width": 2}
        square = {"x": x - 9, "y": y - 9, "width": 18, "height": 18}
        drawn.append(part("rect", "", name, **square, **looks))
        drawn.append(label(x, y - 13.0, name))
    return picture(DRAWING_WIDTH, height, "Network of heat paths", drawn)


def _used(name: str, links: dict[tuple[str, str], float]) -> bool:
    return any(name in pair for pair in links)


def _kinds(machine: Machine) -> dict[tuple[str, str], str]:
    kinds: dict[tuple[str, str], str] = {}
    for item in machine.items:
        if item.family == "links":
            a, b = (part_of(name) for name in item.refs["between"])
            kinds.setdefault((a, b), KINDS.get(item.kind, "wall"))
    return kinds


def _placed(
    names: list[str], links: dict[tuple[str, str], float]
) -> tuple[dict[str, tuple[float, float]], float]:
    """Return a position for each part, near its neighbours, and the total height [px].

    Stress majorisation (Gansner, Koren and North, 2005) of the number of joints between two.
    """
    from scipy.sparse.csgraph import shortest_path

    index = {name: i for i, name in enumerate(names)}
    joined = np.zeros((len(names), len(names)))
    for a, b in links:
        joined[index[a], index[b]] = joined[index[b], index[a]] = 1.0
    apart = shortest_path(joined, unweighted=True)
    apart[~np.isfinite(apart)] = apart[np.isfinite(apart)].max(initial=1.0) + 1.0
    np.fill_diagonal(apart, 1.0)
    weight = apart**-2.0
    np.fill_diagonal(weight, 0.0)
    at = np.random.default_rng(0).normal(size=(len(names), 2)) * apart.max()
    before = np.full_like(at, np.inf)
    while len(names) > 1 and not np.allclose(at, before):
        gap, before = at[:, None, :] - at[None, :, :], at
        far = np.maximum(np.sqrt((gap**2).sum(axis=2)), 1e-9)
        pull = weight * apart / far
        target = (weight[:, :, None] * at[None, :, :] + pull[:, :, None] * gap).sum(axis=1)
        at = target / np.maximum(weight.sum(axis=1), 1e-12)[:, None]
    at -= at.mean(axis=0)
    # The longest direction goes across the page.
    at = at @ np.linalg.svd(at, full_matrices=False)[2].T if len(names) > 2 else at
    across = max(float(np.ptp(at[:, 0])), 1e-9)
    at = (at - at.min(axis=0)) / across * (DRAWING_WIDTH - 2.0 * BORDER) + BORDER
    height = float(at[:, 1].max()) + BORDER
    return {name: (float(x), float(y)) for name, (x, y) in zip(names, at, strict=True)}, height
