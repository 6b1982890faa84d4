"""The small page's machine written in lumps by hand, from the drawing and a pocket calculator.

Nothing here uses the expansion: sections, walls and shares are worked out once more, in numbers.
"""

from math import log, pi
from typing import Any

from plant_model.drawing.coolants import coolant
from plant_model.drawing.films import channel_film, still_air, turning
from plant_model.drawing.lubricant import viscosity

STEEL_HEAT, STEEL_K, ALPHA = 7850.0 * 470.0, 45.0, 11.5
IRON_HEAT, IRON_ALPHA = 500.0, 10.5
LAMINATION = 7400.0 * 450.0
CUTS_SHAFT = [0, 11, 29, 132, 150, 168, 260]
CUTS_HOUSING = [0, 11, 29, 132, 150, 168, 200]
SIDES = ["xp", "yp", "xm", "ym"]
SHAFT_AREA = pi / 4 * (0.060**2 - 0.020**2)
HOUSING_AREA = pi / 4 * (0.180**2 - 0.100**2)
EFFECTS = """conduction coolant_jacket uneven_cooling surface_convection stirred_film air_gap
    bearing_friction motor_loss thermal_expansion housing_bending"""
SEAT, MOTOR_SEAT = 5000.0, 2500.0
# A third of the wall in: 40 mm of 60 to 20, 80 mm of 100 to 180.
WALL_SHAFT = log(60 / (60 - 40 / 3))
WALL_HOUSING, WALL_STATOR = (log((100 + 80 / 3) / seat) for seat in (95, 100))


def number(value: float, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit, "low": value, "high": value, "source": "by hand"}


def _numbers(unit: str, **values: float) -> dict[str, Any]:
    return {key: number(value, unit) for key, value in values.items()}


def _within(a: float, b: float, start: float, end: float) -> float:
    return max(0.0, min(b, end) - max(a, start))


class Hand:
    """Collects the tables of the machine file."""

    def __init__(self) -> None:
        self.table: dict[str, Any] = {"nodes": [], "links": [], "sources": [], "structure": []}

    def node(self, name: str, capacity: float) -> None:
        node = {"name": name, "capacity": number(capacity, "J/K"), "start": "ambient"}
        self.table["nodes"].append(node)

    def path(self, kind: str, a: str, b: str, conductance: float) -> None:
        link = {"kind": kind, "between": [a, b], "conductance": number(conductance, "W/K")}
        self.table["links"].append(link)

    def film(self, node: str, area: float, coefficient: float) -> None:
        numbers = _numbers("m2", area=area) | _numbers("W/(m2 K)", coefficient=coefficient)
        self.table["links"].append({"kind": "convection", "between": [node, "ambient"], **numbers})

    def stirred(self, node: str, conductance: float) -> None:
        numbers = _numbers("W/K", conductance=conductance)
        link = {"kind": "stirred", "name": f"stirred_{node}", "between": [node, "ambient"]}
        self.table["links"].append(link | {"driven_by": "speed"} | numbers)

    def gap(self, a: str, b: str, area: float, radius: float, gap: float) -> None:
        numbers = _numbers("m2", area=area) | _numbers("mm", radius=radius, gap=gap)
        self.table["links"].append({"kind": "air_gap", "between": [a, b], **numbers})

    def part(self, **table: Any) -> None:
        self.table["structure"].append(table)


def lumps() -> dict[str, Any]:
    """Return the machine file."""
    hand = Hand()
    _spindle(hand)
    _bearings(hand)
    _motor(hand)
    _jacket(hand)
    _carriers(hand)
    _growth(hand)
    unit = {"degC": ("ambient", "hall_degC"), "rpm": ("speed", "speed_rpm")}
    inputs = {
        name: {"unit": key, "column": column, "low": -60.0, "high": 10000.0}
        for key, (name, column) in unit.items()
    }
    inputs["coolant_inlet"] = {**inputs["ambient"], "column": "inlet_degC"}
    return {
        "format": 1,
        "name": "by_hand",
        "title": "Small spindle by hand",
        "inputs": {name: inputs[name] for name in ("speed", "ambient", "coolant_inlet")},
        **hand.table,
        "sensors": [{"name": "T1", "of": "housing_4_xp"}, {"name": "T2", "of": "head"}],
        "rig": {
            "kind": "direct",
            "axes": {f"disp_{axis}": {"axis": axis.upper()} for axis in "xyz"},
        },
        "effects": {law: {} for law in EFFECTS.split()},
    }


def _spindle(hand: Hand) -> None:
    still, turned = still_air(180.0, 0.8), turning(60.0, 10000.0)
    for k in range(6):
        a, b = CUTS_SHAFT[k], CUTS_SHAFT[k + 1]
        hand.node(f"shaft_{k + 1}", STEEL_HEAT * SHAFT_AREA * (b - a) / 1000)
        if k:
            apart = (b - CUTS_SHAFT[k - 1]) / 2000
            hand.path("conduction", f"shaft_{k}", f"shaft_{k + 1}", STEEL_K * SHAFT_AREA / apart)
    hand.film("shaft_6", pi * 0.060 * 0.060, still)
    hand.stirred("shaft_6", pi * 0.060 * 0.060 * turned)
    for k in range(6):
        a, b = CUTS_HOUSING[k], CUTS_HOUSING[k + 1]
        for i, side in enumerate(SIDES):
            name = f"housing_{k + 1}_{side}"
            hand.node(name, STEEL_HEAT * HOUSING_AREA / 4 * (b - a) / 1000)
            beside = f"housing_{k + 1}_{SIDES[(i + 1) % 4]}"
            # A quarter of the mean circumference apart; 8 / pi^2 makes the first harmonic exact.
            around = 0.040 * (b - a) / 1000 / (pi * 0.140 / 4) * (pi**2 / 8)
            hand.path("conduction", name, beside, STEEL_K * around)
            if k:
                apart = (b - CUTS_HOUSING[k - 1]) / 2000
                along = STEEL_K * HOUSING_AREA / 4 / apart
                hand.path("conduction", f"housing_{k}_{side}", name, along)
            free = (b - a) - _within(a, b, 0, 60)
            if free:
                hand.film(name, pi * 0.180 * free / 1000 / 4, still)
    _gaps(hand)


def _gaps(hand: Hand) -> None:
    taken = [(11, 29), (132, 150), (150, 168), (50, 100)]
    for j in range(6):
        for k in range(6):
            a = max(CUTS_SHAFT[j], CUTS_HOUSING[k])
            b = min(CUTS_SHAFT[j + 1], CUTS_HOUSING[k + 1])
            free = b - a - sum(_within(a, b, *span) for span in taken)
            if b > a and free > 0:
                for side in SIDES:
                    area = pi * 0.075 * free / 1000 / 4  # of the cylinder in the middle of the gap
                    hand.gap(f"shaft_{j + 1}", f"housing_{k + 1}_{side}", area, 37.5, 15)


def _bearings(hand: Hand) -> None:
    # A 7012: 60 x 95 x 18 mm.
    mass = 0.68 * 7850 * pi / 4 * (0.095**2 - 0.060**2) * 0.018
    on_shaft = 1 / (1 / (SEAT * pi * 0.060 * 0.018) + WALL_SHAFT / (2 * pi * STEEL_K * 0.018))
    in_housing = 1 / (1 / (SEAT * pi * 0.095 * 0.018) + WALL_HOUSING / (2 * pi * STEEL_K * 0.018))
    for name, cells, preload in (("front", (4, 5), 300), ("rear", (2,), 200)):
        for ring in ("inner", "outer"):
            hand.node(f"{name}_{ring}", len(cells) * mass * 470 / 2)
        for cell in cells:
            hand.path("contact", f"{name}_inner", f"shaft_{cell}", on_shaft)
            for side in SIDES:
                hand.path("contact", f"{name}_outer", f"housing_{cell}_{side}", in_housing / 4)
        hand.path("contact", f"{name}_inner", f"{name}_outer", 12 * len(cells) * 77.5 / 70)
        rings = {ring: f"{name}_{ring}" for ring in ("inner", "outer")}
        hand.table["sources"].append(
            {"kind": "bearing", "name": name, "driven_by": "speed", **rings}
            | _numbers("1", count=len(cells), f0=0.7, f1=0.001)
            | _numbers("mm", mean_diameter=77.5)
            | _numbers("N", preload=preload)
            | _numbers("mm2/s", viscosity=viscosity(32, 45.0))
        )


def _motor(hand: Hand) -> None:
    for node, small, large in (("rotor", 0.060, 0.090), ("stator", 0.0914, 0.100)):
        hand.node(node, LAMINATION * pi / 4 * (large**2 - small**2) * 0.050)
    on_shaft = 1 / (1 / (MOTOR_SEAT * pi * 0.060 * 0.050) + WALL_SHAFT / (2 * pi * STEEL_K * 0.050))
    wall = WALL_STATOR / (2 * pi * STEEL_K * 0.050)
    in_housing = 1 / (1 / (MOTOR_SEAT * pi * 0.100 * 0.050) + wall)
    hand.path("contact", "rotor", "shaft_3", on_shaft)
    for side in SIDES:
        hand.path("contact", "stator", f"housing_3_{side}", in_housing / 4)
    hand.gap("rotor", "stator", pi * 0.0907 * 0.050, 45.35, 0.7)
    hand.table["sources"].append(
        {"kind": "motor", "name": "motor", "rotor": "rotor", "stator": "stator"}
        | {"driven_by": "speed", "loss": number(20, "W/(1000 r/min)")}
        | _numbers("1", rotor_share=0.3)
    )


def _jacket(hand: Hand) -> None:
    water = coolant("water")
    length = pi * 0.140 * 120 / 20
    wall = channel_film(water, 4, 15, 6, 140) * 0.027 * length
    hand.node("jacket_one", 0.015 * 0.006 * length * 1000 * water.heat_per_litre)
    carried = _numbers("l/min", flow=4) | _numbers("J/(l K)", heat_capacity=water.heat_per_litre)
    inlet = {"kind": "coolant_flow", "between": ["jacket_one", "coolant_inlet"]}
    hand.table["links"].append(inlet | carried)
    for k in range(6):
        share = _within(CUTS_HOUSING[k], CUTS_HOUSING[k + 1], 60, 180) / 120
        for side in SIDES if share else ():
            node = f"housing_{k + 1}_{side}"
            hand.path("coolant_wall", node, "jacket_one", wall * share / 4)
            if side[0] == "x":
                more = (0.4 if side == "xp" else -0.4) * wall * share / 4
                link = {"kind": "coolant_unevenness", "name": f"uneven_{node}"}
                link |= {"between": [node, "jacket_one"]} | _numbers("W/K", difference=more)
                hand.table["links"].append(link)


def _carriers(hand: Hand) -> None:
    still = still_air(180.0, 0.8)
    for name, mass, surface in (("head", 200, 0.8), ("column", 700, 2.5)):
        hand.node(name, mass * IRON_HEAT)
        hand.film(name, surface, still)
    for k in range(6):
        share = _within(CUTS_HOUSING[k], CUTS_HOUSING[k + 1], 0, 60) / 60
        for side in SIDES if share else ():
            hand.path("contact", f"housing_{k + 1}_{side}", "head", 40 * share / 4)
    hand.path("contact", "head", "column", 10)
    hand.node("tool", STEEL_HEAT * pi / 4 * 0.040**2 * 0.100)
    hand.path("contact", "shaft_6", "tool", 0.8)
    hand.film("tool", pi * 0.040 * 0.100, still)
    hand.stirred("tool", pi * 0.040 * 0.100 * turning(40.0, 10000.0))


def _growth(hand: Hand) -> None:
    steel, iron = (_numbers("1e-6/K", expansion=alpha) for alpha in (ALPHA, IRON_ALPHA))
    one = number(1, "1")
    hand.part(kind="located", name="front", **_numbers("mm", at=150, gauge_line=260))
    for k in range(6):
        ends = _numbers("mm", start=CUTS_SHAFT[k], end=CUTS_SHAFT[k + 1])
        hand.part(kind="shaft", name=f"s{k}", nodes=[f"shaft_{k + 1}"], **ends, **steel)
        ends = _numbers("mm", start=CUTS_HOUSING[k], end=CUTS_HOUSING[k + 1])
        ring = [f"housing_{k + 1}_{side}" for side in SIDES]
        hand.part(kind="housing", name=f"h{k}", nodes=ring, **ends, **steel)
        start, end = CUTS_HOUSING[k], min(150, CUTS_HOUSING[k + 1])
        if end > start:
            # As a part that bends by lengths from the pocket calculator, and not as a ring.
            sizes = _numbers("mm", width=140, length=end - start, lever=260 - (start + end) / 2)
            for tilt, warm, cold in (("yaw", 0, 2), ("pitch", 1, 3)):
                sides = {"towards": [ring[cold]], "away": [ring[warm]], tilt: one}
                hand.part(kind="bend", name=f"b{k}{tilt}", **sides, **sizes, **steel)
    hand.part(kind="tool", name="tool", nodes=["tool"], **steel)
    length = _numbers("mm", length=200)
    hand.part(kind="member", name="head", nodes=["head"], y=one, **length, **iron)
    sizes = _numbers("mm", width=300, length=200, lever=250)
    hand.part(kind="bend", name="b", towards=["head"], away=["column"], **sizes, **iron, pitch=one)
