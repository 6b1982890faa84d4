"""Surroundings of the spindle: jackets, carriers, enclosure, tool."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians

from plant_model.drawing.class_values import CLASS_VALUES, stated
from plant_model.drawing.coolants import Coolant, coolant
from plant_model.drawing.films import channel_film
from plant_model.drawing.form import CarrierForm, JacketForm, degrees
from plant_model.drawing.known import CLASS, Known, within
from plant_model.drawing.sheet import Sheet
from plant_model.drawing.spindle import still_film, to_air, turning_in_air

AIR_HEAT = 1200.0
"""Heat capacity of air [J/(m3 K)], given by 1.2 kg/m3 and 1005 J/(kg K)."""

SHEET_HEAT = 3.9e6 * 0.002
"""Heat capacity of two millimetres of sheet steel [J/(m2 K)]; half of it warms with the air inside.
Set on no data."""

RIB = 5.0
"""Wall between two turns of a jacket's channel [mm]: set on no data."""


def add_surroundings(sheet: Sheet) -> None:
    """Add jackets, carriers, enclosure and tool."""
    for jacket in sheet.form.jackets:
        _jacket(sheet, jacket)
    for carrier in sheet.form.carriers:
        _carrier(sheet, carrier)
    _enclosure(sheet)
    _tool(sheet)


def _channel(sheet: Sheet, jacket: JacketForm) -> tuple[float, float, float]:
    """Return wetted wall [m2], volume [m3] and mean diameter [mm] of a jacket's channel."""
    channel = jacket.channel
    stretch = sheet.drawing.stretch_at("housing", (jacket.start + jacket.end) / 2.0)
    coil = (stretch.outer + stretch.inner) / 2.0
    turns = channel.turns or (jacket.end - jacket.start) / (channel.width + RIB)
    length = pi * coil * turns * jacket.around
    wetted = (channel.width + 2.0 * channel.depth) * length * 1e-6
    return wetted, channel.width * channel.depth * length * 1e-9, coil


def _wall(fluid: Coolant, wetted: float, coil: float, jacket: JacketForm) -> Known:
    """Return the conductance between coolant and housing [W/K]."""
    if jacket.wall is not None:
        return jacket.wall.known("W/K", 0.5)
    channel = jacket.channel
    film = channel_film(fluid, jacket.flow.value, channel.width, channel.depth, coil)
    value = film * wetted
    said = (
        f"{film:.0f} W/(m2 K) (Gnielinski; {fluid.source}) on {wetted:.3f} m2 of channel;"
        " range by judgement"
    )
    return Known(value, 0.5 * value, 1.6 * value, "W/K", said, free=True)


def _jacket(sheet: Sheet, jacket: JacketForm) -> None:
    fluid = coolant(jacket.fluid)
    assert fluid is not None
    node = f"jacket_{jacket.name}"
    wetted, volume, coil = _channel(sheet, jacket)
    fed_by = f"jacket_{jacket.after}" if jacket.after else jacket.inlet
    heat = within(0.15, 1e3 * volume * fluid.heat_per_litre, "J/K", "coolant in the channel")
    sheet.node(node, heat)
    given = jacket.flow.known("l/min")
    said = "1 as the page says; data sheet of the cooling unit"
    known = Known(1.0, given.low / given.value, given.high / given.value, "1", said, given.free)
    flow = sheet.number(f"{node}_flow" if jacket.flow.is_known else "coolant_flow", known)
    sheet.link(
        "coolant_flow",
        node,
        fed_by,
        flow=sheet.tied(flow, jacket.flow.value, "l/min"),
        heat_capacity=within(0.03, fluid.heat_per_litre, "J/(l K)", fluid.source),
    )
    wall = _wall(fluid, wetted, coil, jacket)
    name = sheet.number(f"{node}_wall", wall)
    parts = sheet.mesh.under(jacket)
    for sector, share in parts:
        sheet.link("coolant_wall", sector.node, node, conductance=sheet.tied(name, share, "W/K"))
    if jacket.inlet_side is None:
        return
    angle = degrees(jacket.inlet_side)
    uneven = stated(jacket.unevenness, CLASS_VALUES["unevenness"], 0.5).clipped(0.0, 1.0)
    uneven = uneven.scaled(wall.value)
    said = f"times {wall.value:.0f} W/K of the wall: {uneven.source}"
    name = sheet.number(f"{node}_unevenness", replace(uneven, unit="W/K", source=said))
    for sector, share in parts:
        if sector.angle is None:
            continue
        factor = share * cos(radians(sector.angle - angle))
        if abs(factor) > 1e-12:
            sheet.link(
                "coolant_unevenness",
                sector.node,
                node,
                name=f"uneven_{sector.node}_{jacket.name}",
                difference=sheet.tied(name, factor, "W/K"),
            )


def _carrier(sheet: Sheet, carrier: CarrierForm) -> None:
    made_of = sheet.drawing.materials[carrier.material]
    mass = carrier.mass.known("kg", free=False).scaled(made_of.heat.value / made_of.density)
    heat = replace(mass, unit="J/K", source=f"mass; {made_of.heat.source}")
    air = carrier.air or "ambient"
    sheet.node(carrier.name, heat)
    if carrier.surface > 0.0:
        to_air(sheet, carrier.name, air, carrier.surface, still_film(sheet))
    if carrier.holds is not None:
        joint = stated(carrier.joint, CLASS_VALUES["headstock_joint"], 0.5)
        name = sheet.number(f"{carrier.name}_holds", joint)
        for sector, share in sheet.mesh.under(carrier.holds):
            conductance = sheet.tied(name, share, "W/K")
            sheet.link("contact", sector.node, carrier.name, conductance=conductance)
    if carrier.on is not None:
        given = carrier.joint if carrier.holds is None else None
        joint = stated(given, CLASS_VALUES["carrier_joint"], 0.5)
        sheet.link("contact", carrier.name, carrier.on, conductance=joint)
    if carrier.feed is not None:
        loss = stated(carrier.feed.loss, CLASS_VALUES["feed_loss"], 0.5)
        driver = carrier.feed.input
        sheet.source("feed_axis", carrier.name, node=carrier.name, driven_by=driver, loss=loss)


def _enclosure(sheet: Sheet) -> None:
    enclosure = sheet.form.enclosure
    if enclosure is None:
        return
    heat = enclosure.volume * AIR_HEAT + 0.5 * enclosure.wall * SHEET_HEAT
    capacity = within(0.4, heat, "J/K", CLASS + "air and half of 2 mm of sheet steel")
    sheet.node("enclosure_air", capacity)
    film = stated(enclosure.film, CLASS_VALUES["enclosure_film"], 0.4)
    name = sheet.number("enclosure_film", film)
    to_air(sheet, "enclosure_air", "ambient", enclosure.wall, name)


def _tool(sheet: Sheet) -> None:
    tool = sheet.form.tool
    if tool is None:
        return
    made_of = sheet.drawing.materials[tool.material]
    volume = pi / 4.0 * tool.diameter**2 * tool.length * 1e-9
    gauge = sheet.form.shaft.gauge_line
    sheet.node("tool", sheet.heat_of(made_of, volume))
    joint = stated(tool.joint, CLASS_VALUES["tool_joint"], 0.5)
    last = sheet.mesh.cell_of("shaft", gauge).name
    sheet.link("contact", last, "tool", conductance=joint)
    area = pi * tool.diameter * tool.length * 1e-6
    turning_in_air(sheet, "tool", (area, tool.diameter))
