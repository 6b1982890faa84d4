"""Draws a spindle's section to scale as SVG: cells coloured by temperature, bearings, motor,
jackets, sensors.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, radians

from plant_model.drawing.cells import Cell
from plant_model.drawing.form import degrees
from plant_model.drawing.layout import Drawing, Seat
from plant_model.drawing.mesh import Mesh
from plant_model.machine import Machine
from scenarios.pages.svg import INK, label, mixed, part, picture

DRAWING_WIDTH, BORDER, TOP = 1040.0, 50.0, 34.0
"""Width of the picture, and margins beside and above the spindle [px]: set on no data."""
SOFT, BLUE, RED = "#7a828d", "#2f6fb3", "#b3402f"
SIDES = ((1.0, 90.0), (-1.0, 270.0))
"""Sign and direction [deg] above and below the axis: given by the section."""
HATCH = (
    '<defs><pattern id="hatch" width="6" height="6" patternUnits="userSpaceOnUse"'
    ' patternTransform="rotate(45)"><rect width="6" height="6" fill="#eef0f3"/>'
    f'<line x1="0" y1="0" x2="0" y2="6" stroke="{SOFT}" stroke-width="2"/></pattern></defs>'
)


def colour(value: float, low: float, high: float) -> str:
    """Return the fill colour of a temperature between the coldest and the warmest."""
    share = min(1.0, max(0.0, (value - low) / max(high - low, 1e-9)))
    return mixed(share, "#dee6ee", "#e26830")


@dataclass
class Canvas:
    """Draws in mm along the axis and radially; the nose is on the right.

    Attributes
    ----------
    first, last : float
        Ends of the picture along the axis [mm].
    reach : float
        Largest distance from the axis [mm].
    warm : dict of str to float
        Temperature of every node [degC].
    """

    first: float
    last: float
    reach: float
    warm: dict[str, float]

    def __post_init__(self) -> None:
        """Compute the scales."""
        self.low, self.high = min(self.warm.values()), max(self.warm.values())
        self.scale = (DRAWING_WIDTH - 2.0 * BORDER) / (self.last - self.first)
        self.middle = TOP + self.reach * self.scale + 6.0
        self.height = 2.0 * self.middle + 26.0
        self.parts: list[str] = []

    def x(self, at: float) -> float:
        """Return the horizontal position of a place along the axis [px]."""
        return BORDER + (at - self.first) * self.scale

    def y(self, radius: float) -> float:
        """Return the vertical position of a distance from the axis [px]."""
        return self.middle - radius * self.scale

    def rect(
        self, along: tuple[float, float], radii: tuple[float, float], fill: str, title: str
    ) -> None:
        """Draw a ring's section: *radii* may both be negative, for the lower half."""
        size = {
            "width": (along[1] - along[0]) * self.scale,
            "height": abs(radii[1] - radii[0]) * self.scale,
        }
        place = {"x": self.x(along[0]), "y": self.y(max(radii))}
        self.parts.append(part("rect", "", title, **place, **size, fill=fill, stroke=INK))

    def node(self, along: tuple[float, float], radii: tuple[float, float], node: str) -> None:
        """Draw the section of a node's ring, coloured by its temperature."""
        warm = self.warm[node]
        self.rect(along, radii, colour(warm, self.low, self.high), f"{node}: {warm:.1f} degC")

    def both(
        self, along: tuple[float, float], radii: tuple[float, float], fill: str, title: str
    ) -> None:
        """Draw a ring's section above and below the axis."""
        for sign, _ in SIDES:
            self.rect(along, (sign * radii[0], sign * radii[1]), fill, title)

    def dot(self, at: float, radius: float, fill: str, size: float, title: str) -> None:
        """Draw a dot of *size* pixels."""
        place = {"cx": self.x(at), "cy": self.y(radius)}
        self.parts.append(part("circle", "", title, **place, r=size, fill=fill, stroke=INK))

    def text(self, x: float, y: float, text: str, **looks: object) -> None:
        """Write text at a point in pixels."""
        self.parts.append(label(x, y, text, **looks))

    def line(self, x1: float, y1: float, x2: float, y2: float, stroke: str, dash: str = "") -> None:
        """Draw a line between points in pixels."""
        ends = {"x1": x1, "y1": y1, "x2": x2, "y2": y2}
        self.parts.append(part("line", **ends, stroke=stroke, stroke_dasharray=dash))


def section_of_page(drawing: Drawing, warm: dict[str, float]) -> str:
    """Return the section of a page's spindle.

    Parameters
    ----------
    drawing : Drawing
    warm : dict of str to float
        Temperature of every node [degC].
    """
    mesh = Mesh(drawing)
    form = drawing.form
    first = min(drawing.span_of("shaft")[0], drawing.span_of("housing")[0])
    last = max(drawing.span_of("shaft")[1], drawing.span_of("housing")[1])
    tool = form.tool.length if form.tool else 0.0
    reach = max(stretch.outer for stretch in form.housing.stretches) / 2.0
    canvas = Canvas(first, last + tool, reach + 26.0, warm)
    for cell in (*mesh.housing, *mesh.shaft):
        inner, outer = _radii(mesh, cell)
        for sign, angle in SIDES:
            shown = max(mesh.sectors_of(cell), key=lambda s: s.towards(angle))
            canvas.node((cell.start, cell.end), (sign * inner, sign * outer), shown.node)
    _motor(canvas, drawing)
    for seat in drawing.seats:
        _bearing(canvas, seat)
    for jacket in form.jackets:
        stretch = drawing.stretch_at("housing", (jacket.start + jacket.end) / 2.0)
        outer = stretch.outer / 2.0
        wall = outer - stretch.inner / 2.0
        radii = (outer - 0.45 * wall, outer - 0.3 * wall)
        canvas.both((jacket.start, jacket.end), radii, BLUE, f"jacket {jacket.name}")
    _holds(canvas, drawing, reach)
    if form.tool is not None:
        radius = form.tool.diameter / 2.0
        along = (form.shaft.gauge_line, form.shaft.gauge_line + form.tool.length)
        canvas.node(along, (-radius, radius), "tool")
    _lines(canvas, drawing)
    _thermometers(canvas, mesh)
    return _with_key(canvas, "Section of the spindle to scale")


def _holds(canvas: Canvas, drawing: Drawing, reach: float) -> None:
    """Draw what holds the housing, above and below it as far as it extends."""
    for carrier in drawing.form.carriers:
        holds = carrier.holds
        if holds is None:
            continue
        span = (holds.start, holds.end)
        for sign, angle in SIDES:
            if holds.reaches(angle):
                radii = (sign * (reach + 4.0), sign * (reach + 14.0))
                canvas.rect(span, radii, "url(#hatch)", f"held by {carrier.name}")
        name = carrier.name if holds.side is None else f"{carrier.name} ({holds.side})"
        canvas.text(canvas.x(sum(span) / 2.0), canvas.y(reach + 17.0), name, font_size=12)


def _radii(mesh: Mesh, cell: Cell) -> tuple[float, float]:
    stretch = mesh.stretch(cell)
    return stretch.inner / 2.0, stretch.outer / 2.0


def _motor(canvas: Canvas, drawing: Drawing) -> None:
    motor = drawing.form.motor
    if motor is None:
        return
    middle = (motor.start + motor.end) / 2.0
    shaft = drawing.stretch_at("shaft", middle).outer / 2.0
    if motor.drive == "belt":
        rings = {"pulley": (shaft, (motor.pulley_outer or 4.0 * shaft) / 2.0)}
    else:
        assert motor.rotor_outer is not None
        rotor = motor.rotor_outer / 2.0
        stator = (motor.stator_outer or drawing.stretch_at("housing", middle).inner) / 2.0
        rings = {"rotor": (shaft, rotor), "stator": (rotor + motor.gap, stator)}
    for node, (inner, outer) in rings.items():
        for sign, _ in SIDES:
            canvas.node((motor.start, motor.end), (sign * inner, sign * outer), node)


def _bearing(canvas: Canvas, seat: Seat) -> None:
    name, bore, outside = seat.form.name, seat.bearing.bore, seat.bearing.outside
    inner, outer = (canvas.warm[f"{name}_{ring}"] for ring in ("inner", "outer"))
    title = f"{name}: {inner:.1f} degC inside, {outer:.1f} outside"
    for start, end in seat.spans:
        canvas.both((start, end), (bore / 2.0, outside / 2.0), "#ffffff", title)
        size = 0.28 * min(end - start, (outside - bore) / 2.0) * canvas.scale
        for sign, _ in SIDES:
            middle = sign * (bore + outside) / 4.0
            canvas.dot((start + end) / 2.0, middle, "#c8ced6", max(1.5, size), title)


def _lines(canvas: Canvas, drawing: Drawing) -> None:
    """Draw the axis, the mounting face, the gauge line and a scale."""
    bottom = 2.0 * canvas.middle - TOP
    canvas.line(
        BORDER - 20, canvas.middle, DRAWING_WIDTH - BORDER + 20, canvas.middle, SOFT, "12 3 2 3"
    )
    marks = ((0.0, "mounting face"), (drawing.form.shaft.gauge_line, "gauge line"))
    for at, what in marks:
        canvas.line(canvas.x(at), TOP - 8.0, canvas.x(at), bottom, SOFT, "4 3")
        canvas.text(canvas.x(at), TOP - 14.0, what, fill=SOFT)
    canvas.line(BORDER, bottom + 14.0, BORDER + 100.0 * canvas.scale, bottom + 14.0, INK)
    canvas.text(BORDER, bottom + 30.0, "100 mm", text_anchor="start")


def _thermometers(canvas: Canvas, mesh: Mesh) -> None:
    together: dict[tuple[float, float], list[str]] = {}
    for name, at, radius, where in _placed(mesh):
        canvas.dot(at, radius, RED, 4.0, f"{name}: {where}")
        together.setdefault((round(at), round(radius)), []).append(name)
    for (at, radius), names in together.items():
        x, y = canvas.x(at) + 6.0, canvas.y(radius) - 5.0
        canvas.text(x, y, ", ".join(names), fill=RED, font_size=12, text_anchor="start")


def _placed(mesh: Mesh) -> Iterator[tuple[str, float, float, str]]:
    """Yield name, place along the axis, distance from it and label of each thermometer shown."""
    drawing = mesh.drawing
    for entry in drawing.form.thermometers:
        name, _, ring = entry.part.partition(".")
        if entry.part in {"shaft", "housing"} and entry.at is not None:
            middle = sum(_radii(mesh, mesh.cell_of(entry.part, entry.at))) / 2.0
            side = 90.0 if entry.side is None else degrees(entry.side)
            up = 1.0 if side in {0.0, 180.0} else cos(radians(side - 90.0))
            yield (
                entry.name,
                entry.at,
                middle * up,
                f"{entry.part}, side {entry.side or 'all round'}",
            )
        elif name == "jacket":
            jacket = next(j for j in drawing.form.jackets if j.name == ring)
            at = (jacket.start + jacket.end) / 2.0
            radius = 0.46 * drawing.stretch_at("housing", at).outer
            yield entry.name, at, -radius, f"coolant of {ring}"
        elif ring == "outer":
            seat = next(s for s in drawing.seats if s.form.name == name)
            yield entry.name, seat.form.at, seat.bearing.outside / 2.0, f"outer ring of {name}"


def _with_key(canvas: Canvas, name: str) -> str:
    low, high = canvas.low, canvas.high
    x, y = DRAWING_WIDTH - BORDER - 160.0, canvas.height - 16.0
    for k in range(16):
        shade = colour(low + (high - low) * k / 15.0, low, high)
        canvas.parts.append(part("rect", x=x + 5 * k, y=y - 9, width=5, height=9, fill=shade))
    canvas.text(x - 6.0, y, f"{low:.0f}", text_anchor="end")
    canvas.text(x + 86.0, y, f"{high:.0f} degC at full speed", text_anchor="start")
    return picture(DRAWING_WIDTH, canvas.height, name, [HATCH, *canvas.parts])


def section_of_lumps(machine: Machine, warm: dict[str, float]) -> str:
    """Return shaft and housing of a lumped machine along the axis; it has no diameters.

    Empty if the machine has neither.
    """
    spans = [
        (
            item.kind,
            item.parameters["start"].value,
            item.parameters["end"].value,
            item.refs["nodes"],
        )
        for item in machine.of_kind("structure", "shaft", "housing")
    ]
    if not spans:
        return ""
    canvas = Canvas(min(s[1] for s in spans), max(s[2] for s in spans), 90.0, warm)
    for kind, start, end, nodes in spans:
        radii = (4.0, 30.0) if kind == "shaft" else (50.0, 80.0)
        for sign, node in ((1.0, nodes[0]), (-1.0, nodes[-1])):
            canvas.node((start, end), (sign * radii[0], sign * radii[1]), node)
        canvas.text(
            canvas.x((start + end) / 2.0),
            canvas.y(sum(radii) / 2.0) + 4.0,
            nodes[0] if len(nodes) == 1 else f"{nodes[0].rpartition('_')[0]} ({len(nodes)} sides)",
        )
    for item in machine.of_kind("structure", "located"):
        for key, what in (("at", "located"), ("gauge_line", "gauge line")):
            at = canvas.x(item.parameters[key].value)
            canvas.line(at, TOP - 8.0, at, 2.0 * canvas.middle - TOP, SOFT, "4 3")
            canvas.text(at, TOP - 14.0, what, fill=SOFT)
    return _with_key(canvas, "Shaft and housing along the axis")
