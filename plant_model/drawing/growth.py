"""Parts that grow and bend: the cells from mounting face to gauge line, the carriers, the tool."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin

from plant_model.drawing.cells import Cell
from plant_model.drawing.form import Quantity
from plant_model.drawing.known import Known, exact, within
from plant_model.drawing.mesh import Sector
from plant_model.drawing.sheet import Sheet

UNEVEN = 0.25
"""Relative uncertainty of a carrier's growth, because it is one lump [1]: set on no data."""

MOVES = {"x": "x", "y": "y", "z": "elongation"}
"""Name in a machine file of the motion by a length along an axis."""


def add_growth(sheet: Sheet) -> None:
    """Add the structure: positions, growth of shaft, housing, tool and carriers, and tilt."""
    located = sheet.drawing.located.form
    gauge_line = exact(sheet.form.shaft.gauge_line, "mm")
    sheet.member("located", located.name, at=exact(located.at, "mm"), gauge_line=gauge_line)
    for cell in (*sheet.mesh.housing, *sheet.mesh.shaft):
        _segment(sheet, cell)
    for cell in sheet.mesh.housing:
        _rings(sheet, cell)
    if sheet.form.tool is not None:
        growth = sheet.growth_of(sheet.drawing.materials[sheet.form.tool.material])
        sheet.member("tool", "tool", nodes=["tool"], expansion=growth)
    _carriers(sheet)


def _segment(sheet: Sheet, cell: Cell) -> None:
    sheet.member(
        cell.part,
        cell.name,
        nodes=[sector.node for sector in sheet.mesh.sectors_of(cell)],
        start=exact(cell.start, "mm"),
        end=exact(cell.end, "mm"),
        expansion=sheet.growth_of(sheet.mesh.material(cell)),
    )


def _rings(sheet: Sheet, cell: Cell) -> None:
    """Add the bending of a housing cell in sectors.

    A ring of n sectors at the temperatures T_k bends by 2 / (n r) sum T_k cos(phi_k), which is
    exact for a cosine around the axis. Each pair of opposite sectors becomes one item.
    """
    sectors = sheet.mesh.sectors_of(cell)
    stretch = sheet.mesh.stretch(cell)
    radius = (stretch.outer + stretch.inner) / 4.0
    half = len(sectors) // 2
    for warm, cold in zip(sectors[:half], sectors[half:], strict=False):
        sheet.member(
            "ring",
            f"ring_{warm.node}",
            towards=[cold.node],
            away=[warm.node],
            start=exact(cell.start, "mm"),
            end=exact(cell.end, "mm"),
            width=exact(len(sectors) * radius / 2.0, "mm"),
            expansion=sheet.growth_of(sheet.mesh.material(cell)),
            **_direction(warm),
        )


def _direction(warm: Sector) -> dict[str, Known]:
    assert warm.angle is not None
    parts = {"yaw": cos(radians(warm.angle)), "pitch": sin(radians(warm.angle))}
    return {key: exact(round(part, 15), "1") for key, part in parts.items() if abs(part) > 1e-12}


def _lever(length: Quantity) -> Known:
    """Return the length over which a carrier bends [mm], to be calibrated.

    A drawing gives the length between two faces. The part is one lump but does not have one
    temperature, so the length that counts is known to a quarter.
    """
    return length.known("mm", UNEVEN)


def _moving(axis: str, length: Quantity) -> dict[str, Known]:
    """Return how a carrier moves the nose along an axis: its length and its direction.

    If the range includes both signs, the length is the longest one, and calibration moves a share
    of it with either sign.
    """
    known = length.known("mm", UNEVEN)
    if known.low < 0.0 < known.high:
        longest = max(-known.low, known.high)
        share = replace(known.scaled(1.0 / longest), unit="1")
        return {"length": exact(longest, "mm"), MOVES[axis]: share}
    sign = 1.0 if known.value > 0.0 else -1.0
    if sign < 0.0:
        known = replace(known, value=-known.value, low=-known.high, high=-known.low)
    return {"length": known, MOVES[axis]: exact(sign, "1")}


def _carriers(sheet: Sheet) -> None:
    for carrier in sheet.form.carriers:
        growth = sheet.growth_of(sheet.drawing.materials[carrier.material])
        for axis, length in carrier.grows.lengths().items():
            moving, nodes = _moving(axis, length), [carrier.name]
            name = f"{carrier.name}_{axis}"
            sheet.member("member", name, nodes=nodes, expansion=growth, **moving)
        for j, bend in enumerate(carrier.bends):
            sheet.member(
                "bend",
                f"{carrier.name}_bend_{j + 1}",
                towards=[carrier.name],
                away=[bend.against],
                width=within(0.05, bend.width, "mm", "page"),
                length=_lever(bend.length),
                lever=within(0.05, bend.lever, "mm", "page"),
                expansion=growth,
                yaw=exact(bend.yaw, "1"),
                pitch=exact(bend.pitch, "1"),
            )
