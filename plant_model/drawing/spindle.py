"""Shaft and housing as nodes: capacities, paths along and around, air gaps, films outside."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi
from typing import Any

from plant_model.drawing.cells import Cell, overlap
from plant_model.drawing.class_values import CLASS_VALUES
from plant_model.drawing.films import blown, still_air, turning
from plant_model.drawing.form import FaceForm, MotorForm, PatchForm
from plant_model.drawing.known import BY_DATA_SHEET, CLASS, Known, within
from plant_model.drawing.layout import ENCLOSURE
from plant_model.drawing.materials import Material
from plant_model.drawing.mesh import Sector
from plant_model.drawing.sheet import Sheet

BLOWN = 5.0
"""Highest speed of air past the nose at rest, by sealing air and draughts [m/s]: set on
no data."""

LARGEST_GAP = 15.0
"""Largest gap; the law is for narrow gaps, and a wider one counts as this [mm]: set on no data."""


def add_spindle(sheet: Sheet) -> None:
    """Add shaft and housing with all links of their cells to each other and to the air."""
    _cells(sheet, sheet.mesh.shaft)
    _cells(sheet, sheet.mesh.housing)
    _gaps(sheet)
    _outside(sheet)


def _cells(sheet: Sheet, cells: list[Cell]) -> None:
    for cell in cells:
        sectors, material = sheet.mesh.sectors_of(cell), sheet.mesh.material(cell)
        volume = sheet.mesh.section(cell) * cell.length * 1e-3
        for sector in sectors:
            sheet.node(sector.node, sheet.heat_of(material, volume * sector.share))
        _around(sheet, cell, sectors, material)
    for pair in pairwise(cells):
        for before, after, share in _facing(*(sheet.mesh.sectors_of(cell) for cell in pair)):
            _along(sheet, pair, (before.node, after.node), share)


def _facing(first: list[Sector], second: list[Sector]) -> list[tuple[Sector, Sector, float]]:
    """Return the touching sectors of two cells, with their share of the circumference."""
    if len(first) == len(second):
        return [(a, b, a.share) for a, b in zip(first, second, strict=True)]
    return [(a, b, min(a.share, b.share)) for a in first for b in second]


def _along(sheet: Sheet, cells: tuple[Cell, Cell], nodes: tuple[str, str], share: float) -> None:
    """Join two cells along the axis, from middle to middle."""
    halves = [
        (sheet.mesh.material(cell), cell.length * 0.5e-3 / sheet.mesh.section(cell))
        for cell in cells
    ]
    (material, here), (other, there) = halves
    if material == other:
        path: Known | dict[str, Any] = sheet.path_in(material, share / (here + there))
    else:
        both = here / material.conductivity.value + there / other.conductivity.value
        path = within(0.2, share / both, "W/K", "k A / L of both sections")
    sheet.link("conduction", *nodes, conductance=path)


def _around(sheet: Sheet, cell: Cell, sectors: list[Sector], material: Material) -> None:
    """Join the sectors of a ring to their neighbours.

    With n sectors, differences underestimate the curvature of a cosine. The factor corrects this,
    so that a one-sided temperature evens out as fast as in a continuous ring.
    """
    if len(sectors) == 1:
        return
    stretch = sheet.mesh.stretch(cell)
    outer, inner = stretch.outer * 1e-3, stretch.inner * 1e-3
    wall = (outer - inner) / 2.0 * cell.length * 1e-3
    angle = 2.0 * pi / len(sectors)
    step = angle * (outer + inner) / 4.0 / (angle**2 / (2.0 - 2.0 * cos(angle)))
    for first, second in pairwise([*sectors, sectors[0]]):
        sheet.link(
            "conduction", first.node, second.node, conductance=sheet.path_in(material, wall / step)
        )


def _gaps(sheet: Sheet) -> None:
    """Join shaft and housing across the air between them, except at bearings and motor."""
    taken = [span for seat in sheet.drawing.seats for span in seat.spans]
    motor = sheet.form.motor
    if motor is not None and motor.drive == "built-in":
        taken.append((motor.start, motor.end))
    for shaft in sheet.mesh.shaft:
        for housing in sheet.mesh.housing:
            start, end = max(shaft.start, housing.start), min(shaft.end, housing.end)
            length = max(0.0, end - start) - sum(
                max(0.0, min(end, last) - max(start, first)) for first, last in taken
            )
            if length < 1e-6:
                continue
            outer = sheet.mesh.stretch(shaft).outer
            gap = min(LARGEST_GAP, (sheet.mesh.stretch(housing).inner - outer) / 2.0)
            for sector in sheet.mesh.sectors_of(housing):
                area = pi * outer * length * 1e-6 * sector.share
                add_gap(sheet, (shaft.name, sector.node), area, outer / 2.0, gap)


def add_gap(
    sheet: Sheet, nodes: tuple[str, str], area_m2: float, radius_mm: float, gap_mm: float
) -> None:
    """Add an exchange across an air gap.

    Parameters
    ----------
    sheet : Sheet
    nodes : pair of str
    area_m2, radius_mm : float
        Of its inner surface [m2], [mm].
    gap_mm : float
        Its width [mm]. The law counts with the middle of the gap.
    """
    usual = CLASS_VALUES["fit_gap"]
    gap = within(0.1, gap_mm, "mm", "page") if gap_mm > 0.05 else usual
    middle = radius_mm + gap.value / 2.0
    sheet.link(
        "air_gap",
        *nodes,
        area=within(0.05, area_m2 * middle / radius_mm, "m2", "page"),
        radius=within(0.05, middle, "mm", "page"),
        gap=gap,
    )


def still_film(sheet: Sheet) -> str:
    """Return the name of the number for the film of all outer surfaces in still air."""
    diameter = max(stretch.outer for stretch in sheet.form.housing.stretches)
    low, usual, high = (
        still_air(diameter, getattr(CLASS_VALUES["emissivity"], key))
        for key in ("low", "value", "high")
    )
    said = f"free convection (ht) and radiation of a {diameter:g} mm cylinder, 5 K above still air"
    known = Known(usual, 0.75 * low, 1.4 * high, "W/(m2 K)", CLASS + said, free=True)
    return sheet.number("still_film", known)


def turning_in_air(sheet: Sheet, node: str, surface: tuple[float, float]) -> None:
    """Add the film of a rotating part: that at rest, and the increase by speed.

    At rest it is that of still air, or more if sealing air or a draught blows on the nose.

    Parameters
    ----------
    sheet : Sheet
    node : str
    surface : pair of float
        Area [m2] and diameter [mm].
    """
    area, diameter = surface
    air = sheet.form.housing.air or "ambient"
    nose = sheet.form.shaft.stretches[-1].outer
    still = sheet.numbers[still_film(sheet)]
    said = f"still air; up to what air of {BLOWN:g} m/s adds to it on {nose:g} mm (ht)"
    most = still["high"] + blown(nose, BLOWN)
    at_rest = Known(still["value"], still["low"], most, "W/(m2 K)", CLASS + said, free=True)
    to_air(sheet, node, air, area, sheet.number("nose_film_at_rest", at_rest))
    film = turning(nose, sheet.drawing.highest_speed)
    said = f"Becker's law for a turning cylinder of {nose:g} mm at full speed"
    known = Known(film, 0.25 * film, 2.0 * film, "W/(m2 K)", CLASS + said, free=True)
    name = sheet.number("turning_film", known)
    factor = area * turning(diameter, sheet.drawing.highest_speed) / film
    sheet.link(
        "stirred",
        node,
        "enclosure_air" if air == ENCLOSURE else air,
        name=f"stirred_{node}",
        driven_by="speed",
        conductance=sheet.tied(name, factor, "W/K"),
    )


def to_air(sheet: Sheet, node: str, air: str, area_m2: float, film: str, prefix: str = "") -> None:
    """Add a surface in the air of the hall, which is an input, or of the enclosure, a node.

    The link is named after what it joins, or after *prefix* and the node.
    """
    called = {"name": f"{prefix}_{node}"} if prefix else {}
    if air == ENCLOSURE:
        conductance = sheet.tied(film, area_m2, "W/K")
        sheet.link("contact", node, "enclosure_air", conductance=conductance, **called)
        return
    sheet.link(
        "convection",
        node,
        air,
        area=within(BY_DATA_SHEET / 3.0, area_m2, "m2", "page"),
        coefficient=sheet.tied(film, 1.0, "W/(m2 K)"),
        **called,
    )


def _shaded(cell: Cell, sector: Sector, patch: PatchForm) -> float:
    """Return how much of a sector a patch covers: length times share of the circumference [mm]."""
    return overlap(cell, patch.start, patch.end) * sector.under(patch)


def _face_film(sheet: Sheet, face: FaceForm, k: int, still: str) -> str:
    """Return the film of a face: its own, or that of still air."""
    if face.film is None:
        return still
    return sheet.number(f"face_{k + 1}_film", face.film.known("W/(m2 K)", 0.5))


def _outside(sheet: Sheet) -> None:
    """Add the films of the housing's outside and of the shaft outside the housing."""
    air = sheet.form.housing.air or "ambient"
    still = still_film(sheet)
    held = [c.holds for c in sheet.form.carriers if c.holds is not None]
    faces = sheet.form.housing.faces
    for cell in sheet.mesh.housing:
        for sector in sheet.mesh.sectors_of(cell):
            around = pi * sheet.mesh.stretch(cell).outer * 1e-6
            free = cell.length * sector.share - sum(_shaded(cell, sector, h) for h in held)
            if around * free < 1e-9:
                continue
            rest = free
            for k, face in enumerate(faces):
                # The carrier is assumed to cover a face as much as the rest of the housing.
                part = free * _shaded(cell, sector, face) / (cell.length * sector.share)
                rest -= part
                if part > 1e-6:
                    film = _face_film(sheet, face, k, still)
                    other = face.air or air
                    to_air(sheet, sector.node, other, around * part, film, f"face_{k + 1}")
            if rest > 1e-6:
                to_air(sheet, sector.node, air, around * rest, still)
    low, high = sheet.drawing.span_of("housing")
    motor = sheet.form.motor
    pulley = [] if motor is None or motor.drive != "belt" else beyond(motor, (low, high))
    for cell in sheet.mesh.shaft:
        outer = sheet.mesh.stretch(cell).outer
        covered = sum(overlap(cell, *span) for span in [(low, high), *pulley])
        length = cell.length - covered
        if length > 1e-6:
            turning_in_air(sheet, cell.name, (pi * outer * length * 1e-6, outer))


def beyond(motor: MotorForm, housing: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the spans of a pulley outside the housing [mm]."""
    spans = [(motor.start, min(motor.end, housing[0])), (max(motor.start, housing[1]), motor.end)]
    return [span for span in spans if span[1] - span[0] > 1e-6]
