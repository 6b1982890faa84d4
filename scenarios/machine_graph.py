"""The network of a machine as a picture: parts, and the paths of heat between them."""

from __future__ import annotations

from html import escape
from math import log10

import numpy as np

from plant_model.checks import Part, part_of
from plant_model.machine import Machine
from scenarios.machine_drawing import colour

WIDTH, HEIGHT, PAD = 1040.0, 600.0, 70.0
STROKES = {"wall": "#8b929c", "air": "#c3a15a", "coolant": "#2f6fb3"}
KINDS = {
    "convection": "air",
    "air_gap": "air",
    "coolant_flow": "coolant",
    "coolant_wall": "coolant",
}
ROUNDS = 400


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
    place = _placed(names, links)
    kinds = _kinds(machine)
    drawn = []
    strongest = max(links.values(), default=1.0)
    for (a, b), g in links.items():
        (x1, y1), (x2, y2) = place[a], place[b]
        width = 1.0 + 5.0 * max(0.0, 1.0 + log10(max(g, 1e-3) / strongest) / 3.0)
        stroke = STROKES[kinds.get((a, b)) or kinds.get((b, a)) or "wall"]
        drawn.append(
            f'<line x1="{x1:.0f}" y1="{y1:.0f}" x2="{x2:.0f}" y2="{y2:.0f}" stroke="{stroke}"'
            f' stroke-width="{width:.1f}" stroke-opacity="0.7"><title>{escape(a)} to {escape(b)}:'
            f" {g:.3g} W/K</title></line>"
        )
    low, high = min(part.warm for part in parts), max(part.warm for part in parts)
    for part in parts:
        x, y = place[part.name]
        ring = {"read": "#b3402f", "beside": "#222830", "unseen": "#aab1ba"}[part.seen]
        size = 6.0 + 2.2 * max(0.0, log10(max(part.capacity, 10.0)) - 1.0)
        title = f"{part.name}: {part.capacity:.3g} J/K, {part.warm:.1f} degC, {part.seen}"
        fill = colour(part.warm, low, high)
        drawn.append(
            f'<circle cx="{x:.0f}" cy="{y:.0f}" r="{size:.1f}" fill="{fill}"'
            f' stroke="{ring}" stroke-width="2"><title>{escape(title)}</title></circle>'
        )
        count = f" ({part.nodes})" if part.nodes > 1 else ""
        drawn.append(_label(x, y - size - 4.0, f"{part.name}{count}"))
    for name in names[len(parts) :]:
        x, y = place[name]
        drawn.append(
            f'<rect x="{x - 9:.0f}" y="{y - 9:.0f}" width="18" height="18" fill="#ffffff"'
            f' stroke="#2f6fb3" stroke-width="2"><title>{escape(name)}</title></rect>'
        )
        drawn.append(_label(x, y - 13.0, name))
    return (
        f'<svg viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" aria-label="Network of heat paths"'
        f' font-family="system-ui, sans-serif">{"".join(drawn)}</svg>'
    )


def _label(x: float, y: float, text: str) -> str:
    return (
        f'<text x="{x:.0f}" y="{y:.0f}" font-size="11" text-anchor="middle" fill="#222830"'
        f' stroke="#ffffff" stroke-width="3" paint-order="stroke">{escape(text)}</text>'
    )


def _used(name: str, links: dict[tuple[str, str], float]) -> bool:
    return any(name in pair for pair in links)


def _kinds(machine: Machine) -> dict[tuple[str, str], str]:
    found: dict[tuple[str, str], str] = {}
    for item in machine.items:
        if item.family == "links":
            a, b = (part_of(name) for name in item.refs["between"])
            found.setdefault((a, b), KINDS.get(item.kind, "wall"))
    return found


def _placed(
    names: list[str], links: dict[tuple[str, str], float]
) -> dict[str, tuple[float, float]]:
    """Return a place for each, near to what it is joined to.

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
    for _ in range(ROUNDS if len(names) > 1 else 0):
        gap = at[:, None, :] - at[None, :, :]
        far = np.maximum(np.sqrt((gap**2).sum(axis=2)), 1e-9)
        pull = weight * apart / far
        target = (weight[:, :, None] * at[None, :, :] + pull[:, :, None] * gap).sum(axis=1)
        at = target / np.maximum(weight.sum(axis=1), 1e-12)[:, None]
    at -= at.mean(axis=0)
    # The longest direction lies across the page.
    at = at @ np.linalg.svd(at, full_matrices=False)[2].T if len(names) > 2 else at
    span = np.maximum(np.ptp(at, axis=0), 1e-9)
    room = np.array([WIDTH - 2.0 * PAD, HEIGHT - 2.0 * PAD])
    at = (at - at.min(axis=0)) / span * room + PAD
    return {name: (float(x), float(y)) for name, (x, y) in zip(names, at, strict=True)}
