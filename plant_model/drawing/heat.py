"""Heat sources of the spindle: bearing sets, motor or belt, with the joints around them."""

from __future__ import annotations

from dataclasses import replace
from math import log, pi
from typing import Any

from plant_model.drawing.class_values import CLASS_VALUES, f0_of, f1_of, stated
from plant_model.drawing.form import BearingForm, MotorForm, SleeveForm
from plant_model.drawing.known import CLASS, Known, exact, within
from plant_model.drawing.layout import Seat
from plant_model.drawing.lubricant import viscosity
from plant_model.drawing.materials import MATERIALS
from plant_model.drawing.sheet import Sheet
from plant_model.drawing.spindle import add_gap, beyond, turning_in_air

USUAL_DIAMETER = 70.0
"""Mean diameter of the bearings that class values are for [mm], given by their sources."""


def add_heat(sheet: Sheet) -> None:
    """Add bearings and motor."""
    for seat in sheet.drawing.seats:
        _bearing(sheet, seat)
    motor = sheet.form.motor
    if motor is not None:
        (_built_in if motor.drive == "built-in" else _belt)(sheet, motor)


class _Joint:
    """A joint in series with the wall behind it, and its range, relative to the usual joint."""

    def __init__(self, sheet: Sheet, name: str, usual: Known) -> None:
        self.sheet, self.name, self.usual = sheet, name, usual

    def conductance(self, area_m2: float, wall_k_per_w: float) -> float:
        """Return the conductance of joint and wall at the usual joint [W/K], and keep it."""
        ends = tuple(
            1.0 / (1.0 / (joint * area_m2) + wall_k_per_w)
            for joint in (self.usual.low, self.usual.value, self.usual.high)
        )
        low, value, high = ends
        said = (
            f"1 is {self.usual.value:g} W/(m2 K) in series with a third of the wall; range of"
            f" {self.usual.low:g} to {self.usual.high:g}: {self.usual.source}"
        )
        self.sheet.number(self.name, Known(1.0, low / value, high / value, "1", said, free=True))
        return value


def _seat_joint(sheet: Sheet, form: BearingForm) -> _Joint:
    """Return the joint of all seats, or of one bearing's seat if the page gives it."""
    name = f"{form.name}_seats" if form.seat else "bearing_seats"
    return _Joint(sheet, name, stated(form.seat, CLASS_VALUES["seat_joint"], 0.6))


def _bearing(sheet: Sheet, seat: Seat) -> None:
    form, bearing = seat.form, seat.bearing
    inner, outer = f"{form.name}_inner", f"{form.name}_outer"
    steel = MATERIALS["steel"]
    heat = bearing.mass * form.count * steel.heat.value / steel.density
    said = f"mass of {form.count} x {bearing.designation}"
    for node in (inner, outer):  # half of the rolling elements each
        sheet.node(node, within(0.15, heat / 2.0, "J/K", said))
    joint = _seat_joint(sheet, form)
    for start, end in seat.spans:
        _seat_on(sheet, "shaft", inner, (start, end), bearing.bore, joint)
        if form.sleeve is None:
            _seat_on(sheet, "housing", outer, (start, end), bearing.outside, joint)
    if form.sleeve is not None:
        _into_sleeve(sheet, seat, form.sleeve, joint)
    relative = form.count * bearing.mean_diameter / USUAL_DIAMETER
    if form.conductance is None:
        balls = sheet.number("balls", stated(None, CLASS_VALUES["balls"]))
        through: Known | dict[str, Any] = sheet.tied(balls, relative, "W/K")
    else:
        through = form.conductance.known("W/K").scaled(form.count)
    sheet.link("contact", inner, outer, conductance=through)
    _friction(sheet, seat)


def _into_sleeve(sheet: Sheet, seat: Seat, sleeve: SleeveForm, joint: _Joint) -> None:
    """Join the outer rings to the housing through their sleeve."""
    outer, outside = f"{seat.form.name}_outer", seat.bearing.outside
    span = (sleeve.start, sleeve.end)
    seated = sum(end - start for start, end in seat.spans)
    if sleeve.outer is None:
        # The rings' seats are spread along the sleeve.
        share = seated / (sleeve.end - sleeve.start)
        _seat_on(sheet, "housing", outer, span, outside, joint, share)
        return
    node = f"{seat.form.name}_sleeve"
    made_of = sheet.drawing.materials[sleeve.material]
    metres = (sleeve.end - sleeve.start) * 1e-3
    volume = pi / 4.0 * (sleeve.outer**2 - outside**2) * 1e-6 * metres
    sheet.node(node, sheet.heat_of(made_of, volume))
    area = pi * outside * seated * 1e-6
    # A third of its wall is in front of its mean temperature, the rest behind it.
    middle = outside + (sleeve.outer - outside) / 3.0
    around = 2.0 * pi * made_of.conductivity.value
    wall = log(middle / outside) / (around * seated * 1e-3)
    value = joint.conductance(area, wall)
    _add_up(sheet, outer, node, joint.name, value)
    behind = log(sleeve.outer / middle) / around
    _seat_on(sheet, "housing", node, span, sleeve.outer, joint, behind=behind)


def _seat_on(
    sheet: Sheet,
    part: str,
    node: str,
    span: tuple[float, float],
    diameter: float,
    joint: _Joint,
    seated: float = 1.0,
    behind: float = 0.0,
) -> None:
    """Join a ring to the cells of shaft or housing at its seat; several rings of a set add up.

    *seated* is the share of the span in contact; *behind* is the resistance of the ring's own wall
    over its length [m K/W].
    """
    mesh = sheet.mesh
    for cell, length in mesh.covered(part, *span):
        around, metres = 2.0 * pi * mesh.material(cell).conductivity.value, length * 1e-3
        wall = mesh.into_wall(cell, diameter) / (around * metres) + behind / metres
        value = joint.conductance(pi * diameter * 1e-3 * metres * seated, wall)
        for sector in mesh.sectors_of(cell):
            _add_up(sheet, node, sector.node, joint.name, value * sector.share)


def _add_up(sheet: Sheet, first: str, second: str, number: str, factor: float) -> None:
    """Add a tied contact, or increase it if the two are already joined."""
    for link in reversed(sheet.links):
        if link["kind"] == "contact" and link["between"] == [first, second]:
            link["conductance"]["factor"] += factor
            return
    sheet.link("contact", first, second, conductance=sheet.tied(number, factor, "W/K"))


def _friction(sheet: Sheet, seat: Seat) -> None:
    form, bearing = seat.form, seat.bearing
    warm = stated(form.running_temperature, CLASS_VALUES["running_temperature"])
    nu = [viscosity(form.grade, t, form.viscosity_index) for t in (warm.high, warm.value, warm.low)]
    oil = Known(
        nu[1],
        nu[0],
        nu[2],
        "mm2/s",
        f"ISO VG {form.grade:g} at {warm.value:g} degC, ASTM D341 (index by chemicals)",
    )
    usual = CLASS_VALUES["preload"].scaled((bearing.mean_diameter / USUAL_DIAMETER) ** 2)
    preload = stated(form.preload, usual, 0.4)
    f0 = stated(form.f0, f0_of(bearing.kind, form.lubrication), 0.5).clipped(0.1, 20.0)
    f1 = stated(form.f1, f1_of(bearing.kind), free=False).clipped(0.0, 0.01)
    sheet.source(
        "bearing",
        form.name,
        inner=f"{form.name}_inner",
        outer=f"{form.name}_outer",
        driven_by="speed",
        count=exact(form.count, "1"),
        mean_diameter=within(0.01, bearing.mean_diameter, "mm", bearing.designation),
        f0=f0,
        f1=f1,
        preload=preload,
        viscosity=oil.clipped(1.0, 1000.0),
        viscosity_at=exact(warm.value, "degC", warm.source),
        inner_share=CLASS_VALUES["inner_share"],
    )


def _loss(motor: MotorForm) -> Known:
    """Return the no-load loss of the motor or the belt."""
    if motor.loss is not None:
        return motor.loss.known("W/(1000 r/min)", 0.3)
    if motor.drive == "belt":
        return stated(None, CLASS_VALUES["belt_loss"])
    assert motor.power is not None
    assert motor.efficiency is not None
    assert motor.rated_speed is not None
    rated = motor.power * 1e3 * (1.0 / motor.efficiency - 1.0) / (motor.rated_speed / 1000.0)
    idle = CLASS_VALUES["idle_share"]
    said = f"{motor.power:g} kW at an efficiency of {motor.efficiency:g}; {idle.source}"
    return replace(idle.scaled(rated), unit="W/(1000 r/min)", source=said, free=True)


def _source(sheet: Sheet, motor: MotorForm, rotor: str, stator: str, usual: Known) -> None:
    share = stated(motor.rotor_share, usual, 0.3, free=False).clipped(0.0, 1.0)
    nodes, loss = {"rotor": rotor, "stator": stator}, _loss(motor)
    sheet.source("motor", "motor", **nodes, driven_by="speed", loss=loss, rotor_share=share)


def _built_in(sheet: Sheet, motor: MotorForm) -> None:
    assert motor.rotor_outer is not None
    middle = (motor.start + motor.end) / 2.0
    shaft = sheet.drawing.stretch_at("shaft", middle).outer
    bore = motor.rotor_outer + 2.0 * motor.gap
    outside = motor.stator_outer or sheet.drawing.stretch_at("housing", middle).inner
    iron = MATERIALS["lamination"]
    metres = (motor.end - motor.start) * 1e-3
    for node, small, large in (("rotor", shaft, motor.rotor_outer), ("stator", bore, outside)):
        volume = pi / 4.0 * (large**2 - small**2) * 1e-6 * metres
        sheet.node(node, sheet.heat_of(iron, volume))
    span = (motor.start, motor.end)
    joint = _Joint(sheet, "motor_seats", stated(motor.joint, CLASS_VALUES["motor_joint"], 0.5))
    _seat_on(sheet, "shaft", "rotor", span, shaft, joint)
    _seat_on(sheet, "housing", "stator", span, outside, joint)
    area = pi * motor.rotor_outer * 1e-3 * metres
    add_gap(sheet, ("rotor", "stator"), area, motor.rotor_outer / 2.0, motor.gap)
    _source(sheet, motor, "rotor", "stator", CLASS_VALUES["rotor_share"])


def _belt(sheet: Sheet, motor: MotorForm) -> None:
    middle = (motor.start + motor.end) / 2.0
    shaft = sheet.drawing.stretch_at("shaft", middle).outer
    pulley = motor.pulley_outer or 2.0 * shaft
    metres = (motor.end - motor.start) * 1e-3
    volume = pi / 4.0 * (pulley**2 - shaft**2) * 1e-6 * metres
    heat = within(0.3, volume * MATERIALS["steel"].heat.value, "J/K", "page, a solid pulley")
    sheet.node("pulley", heat)
    joint = _Joint(sheet, "pulley_seat", CLASS_VALUES["motor_joint"])
    _seat_on(sheet, "shaft", "pulley", (motor.start, motor.end), shaft, joint)
    spans = beyond(motor, sheet.drawing.span_of("housing"))
    if free := sum(end - start for start, end in spans):
        turning_in_air(sheet, "pulley", (pi * pulley * free * 1e-6, pulley))
    half = Known(0.5, 0.3, 0.7, "1", CLASS + "half of the belt's loss in its small pulley")
    _source(sheet, motor, "pulley", motor.into or "", half)
