"""Things that look wrong in a page, in the terms of the drawing; nothing here is refused."""

from __future__ import annotations

import re

from plant_model.drawing.class_values import CLASS_VALUES, f0_of
from plant_model.drawing.form import ANGLES, CarrierForm, Quantity, degrees
from plant_model.drawing.heat import USUAL_DIAMETER
from plant_model.drawing.known import Known
from plant_model.drawing.layout import Drawing, Seat

LOOSE = 0.02
"""A ring whose diameter differs from its seat's by more than this share does not fit [1]: set on
no data."""

LIGHT, HEAVY = 20.0, 1500.0
"""Plausible range of mass over surface of castings and plates [kg/m2]: set on no data."""

CHECK = re.compile(r"#\s*CHECK\b")
"""Start of a remark that a number is not yet from the machine's own drawing."""


def lines_to_check(text: str) -> int:
    """Return the number of lines of a page that still have ``# CHECK``.

    Parameters
    ----------
    text : str
        The text of the page's file.
    """
    return sum(CHECK.search(line) is not None for line in text.splitlines())


def odd_of_page(drawing: Drawing, text: str) -> list[str]:
    """Return a sentence for each thing in a page's file that looks wrong.

    Parameters
    ----------
    drawing : Drawing
    text : str
        The text of the page's file.
    """
    count = lines_to_check(text)
    lines = "line still says" if count == 1 else "lines still say"
    open_ones = [f"{count} {lines} CHECK: those values are not from your drawing."] if count else []
    return [*odd_fits(drawing), *open_ones]


def odd_fits(drawing: Drawing) -> list[str]:
    """Return a sentence for each thing in a page that looks wrong.

    Parameters
    ----------
    drawing : Drawing
    """
    lines = [text for seat in drawing.seats for text in _seat(drawing, seat)]
    for carrier in drawing.form.carriers:
        usual = CLASS_VALUES["headstock_joint" if carrier.holds else "carrier_joint"]
        lines += _far(f"The joint of {carrier.name}", carrier.joint, usual)
        lines += _carrier(drawing, carrier)
    lines += [
        f"The jacket {jacket.name} has an unevenness but no inlet_side: it cools all sides alike."
        for jacket in drawing.form.jackets
        if jacket.unevenness is not None and jacket.inlet_side is None
    ]
    gauge_line = drawing.form.shaft.gauge_line
    lines += [
        f"The gauge line, at {gauge_line:g} mm, is not in front of the bearing {bearing.name}, at"
        f" {bearing.at:g} mm."
        for bearing in drawing.form.bearings
        if bearing.at >= gauge_line
    ]
    on = {carrier.name: carrier.on for carrier in drawing.form.carriers}
    lines += [
        f"{name} and {below} stand on each other."
        for name, below in on.items()
        if below and on.get(below) == name and name < below
    ]
    held = any(carrier.holds is not None for carrier in drawing.form.carriers)
    if not held:
        lines.append("Nothing holds the housing: no carrier has holds = { from, to }.")
    if not any(c.grows.lengths() for c in drawing.form.carriers):
        lines.append("No carrier moves the nose: none has grows = { x, y, z }.")
    if drawing.form.tool is not None:
        lines += _far("The joint of the tool", drawing.form.tool.joint, CLASS_VALUES["tool_joint"])
    if drawing.form.rig.kind == "five_point" and drawing.form.tool is None:
        lines.append("The rig measures on a test bar, but the page has no [tool].")
    return [*lines, *_same_spots(drawing)]


def _same_spots(drawing: Drawing) -> list[str]:
    """Return a sentence for each place with several thermometers."""
    spots: dict[tuple[str, float | None, float | None], list[str]] = {}
    for entry in drawing.form.thermometers:
        side = None if entry.side is None else degrees(entry.side)
        spots.setdefault((entry.part, entry.at, side), []).append(entry.name)
    lines = []
    for (part, at, side), names in spots.items():
        if len(names) == 1:
            continue
        where = part if at is None else f"{part} at {at:g} mm"
        if side is not None:
            named = {angle: name for name, angle in ANGLES.items()}
            where += f", {named.get(side, f'{side:g} degrees')}"
        carrier = any(entry.name == part for entry in drawing.form.carriers)
        split = "; a carrier has one temperature, draw it in two" if carrier else ""
        lines.append(
            f"{', '.join(names[:-1])} and {names[-1]} sit on one spot ({where}) and would read"
            f" the same{split}."
        )
    return lines


def _carrier(drawing: Drawing, carrier: CarrierForm) -> list[str]:
    lines = []
    stood_on = {other.on for other in drawing.form.carriers} | {
        drawing.form.motor.into if drawing.form.motor else None
    }
    if carrier.holds is None and carrier.on is None and carrier.name not in stood_on:
        lines.append(f"{carrier.name} touches nothing: give what it holds or stands on.")
    if carrier.surface > 0.0:
        density = carrier.mass.value / carrier.surface
        if not LIGHT <= density <= HEAVY:
            lines.append(
                f"{carrier.name} has {density:.3g} kg for each m2 of surface, castings {LIGHT:g} to"
                f" {HEAVY:g}: its mass or its surface may be wrong by ten."
            )
    return lines


def _seat(drawing: Drawing, seat: Seat) -> list[str]:
    form, bearing = seat.form, seat.bearing
    lines = []
    sleeve = form.sleeve.outer if form.sleeve else None
    middles = [(start + end) / 2.0 for start, end in seat.spans]
    for part, size, ring, key in (
        ("shaft", bearing.bore, "bore", "outer"),
        ("housing", sleeve or bearing.outside, "sleeve" if sleeve else "outside diameter", "inner"),
    ):
        sizes = [getattr(drawing.stretch_at(part, at), key) for at in middles]
        there = max(sizes, key=lambda seated: abs(seated - size))
        loose = ring == "outside diameter" and there > size
        if abs(there - size) > LOOSE * size:
            lines.append(
                f"The {ring} of the bearing {form.name} is {size:g} mm, but the {part} is"
                f" {there:g} mm there."
                + (" In a sleeve? Say sleeve = { from, to, outer }." if loose else "")
            )
    scale = bearing.mean_diameter / USUAL_DIAMETER
    lines += _far(f"f0 of {form.name}", form.f0, f0_of(bearing.kind, form.lubrication))
    lines += _far(
        f"The preload of {form.name}", form.preload, CLASS_VALUES["preload"].scaled(scale**2)
    )
    return lines


def _far(what: str, given: Quantity | None, usual: Known) -> list[str]:
    if given is None or usual.low <= given.value <= usual.high:
        return []
    unit = "" if usual.unit == "1" else f" {usual.unit}"
    return [
        f"{what} is {given.value:g}{unit}, far from its class: {usual.low:.3g} to"
        f" {usual.high:.3g}{unit}."
    ]
