"""The machine cut into cells: shaft, bearings, motor, housing, jackets, pedestal, column, bed.

Along the axis [mm] from the mounting face towards the nose; sectors around it, the first at X+ and
a quarter of them further at Y+.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from benchmarks.gap.cells import Array
from benchmarks.gap.numbers import Numbers
from benchmarks.gap.truth.cells import AIR, HALL, Network, spread

SHAFT = {"rear": (-140.0, 0.0, 5), "middle": (0.0, 200.0, 6), "front": (200.0, 400.0, 7)}
HOUSING = {"rear": (-160.0, 0.0, 5), "motor": (0.0, 180.0, 6), "front": (180.0, 320.0, 5)}
BEARINGS = {"rear": (-90.0, -60.0), "front": (285.0, 315.0)}
CARTRIDGE = 60.0
"""Half the length of the sleeve through which a bearing's heat enters the housing [mm]."""
MOTOR = (20.0, 160.0, 5)
BAR = (400.0, 550.0, 5)
NOSE_START = 340.0
PEDESTAL_CELLS, COLUMN_CELLS, BED_CELLS = 5, 6, 3
STEEL_CONDUCTIVITY = 45.0  # W/(m K), bearing steel
RING_SECTION = 1.6e-4  # m2
RING_RADIUS = 0.045  # m


@dataclass
class Layout:
    """The network with the places of its cells.

    Attributes
    ----------
    network : Network
    edges : dict of str to array
        Axial edges of the cells of ``shaft``, ``housing``, ``motor`` and ``bar`` [mm].
    angles : array
        Of the sectors' middles [rad].
    """

    network: Network
    edges: dict[str, Array] = field(default_factory=dict)
    angles: Array = field(default_factory=lambda: np.zeros(0))

    def middles(self, part: str) -> Array:
        """Return the middles of a part's axial cells [mm]."""
        return np.asarray((self.edges[part][1:] + self.edges[part][:-1]) / 2.0)

    def lengths(self, part: str) -> Array:
        """Return the lengths of a part's axial cells [mm]."""
        return np.diff(self.edges[part])

    def share(self, part: str, low: float, high: float) -> Array:
        """Return how [low, high] mm is spread over a part's axial cells."""
        return spread(self.edges[part][:-1], self.edges[part][1:], low, high)


def build(p: Numbers, resolution: float = 1.0) -> Layout:
    """Return the machine cut into cells; a *resolution* of 2 halves every cell."""
    layout = Layout(Network())
    sectors = 4 * max(1, round(2 * resolution))
    layout.angles = 2.0 * np.pi * np.arange(sectors) / sectors
    layout.edges["shaft"] = _edges(SHAFT, resolution)
    layout.edges["housing"] = _edges(HOUSING, resolution)
    layout.edges["motor"] = _edges({"motor": MOTOR}, resolution)
    layout.edges["bar"] = _edges({"bar": BAR}, resolution)
    _shaft(layout, p)
    _housing(layout, p)
    _bearings(layout, p)
    _motor(layout, p)
    _jackets(layout, p)
    _body(layout, p, resolution)
    return layout


def _edges(regions: dict[str, tuple[float, float, int]], resolution: float) -> Array:
    edges = []
    for low, high, count in regions.values():
        edges.append(np.linspace(low, high, max(1, round(count * resolution)) + 1))
    return np.unique(np.concatenate(edges))


def _axial(layout: Layout, part: str, ka: float) -> Array:
    """Return the conductances between neighbouring axial cells [W/K] from k A [W m/K]."""
    return np.asarray(ka / (np.diff(layout.middles(part)) * 1e-3))


def _shaft(layout: Layout, p: Numbers) -> None:
    net = layout.network
    capacity = sum(
        p[f"c_shaft_{name}"] * layout.share("shaft", low, high)
        for name, (low, high, _) in SHAFT.items()
    )
    shaft = net.add("shaft", capacity)
    net.join("shaft", shaft[1:], shaft[:-1], _axial(layout, "shaft", p["ka_shaft"]))
    nose = layout.share("shaft", NOSE_START, 400.0)
    net.boundary("film_nose", shaft, AIR, p["h_nose"] * p["a_nose"] * nose)
    lengths = layout.lengths("bar")
    bar = net.add("bar", p["c_bar"] * lengths / lengths.sum())
    net.join("bar", bar[1:], bar[:-1], _axial(layout, "bar", p["ka_bar"]))
    film = p["h_bar"] * p["a_bar"] * lengths / lengths.sum()
    net.boundary("film_bar", bar, AIR, film)
    net.join("joint_bar", shaft[-1], bar[0], p["j_bar"])


def _housing(layout: Layout, p: Numbers) -> None:
    net, sectors = layout.network, len(layout.angles)
    capacity = sum(
        p[f"c_housing_{name}"] * layout.share("housing", low, high)
        for name, (low, high, _) in HOUSING.items()
    )
    housing = net.add("housing", np.repeat(capacity[:, None] / sectors, sectors, axis=1))
    along = _axial(layout, "housing", p["ka_housing"]) / sectors
    # Rear and motor housing meet in a flange, which conducts badly.
    flange = np.isclose(layout.edges["housing"][1:-1], 0.0)
    along = np.where(flange, p["j_flange"] / sectors, along)
    net.join("housing", housing[1:], housing[:-1], along[:, None])
    around = p["kt_housing"] * layout.lengths("housing") * 1e-3 / (2.0 * np.pi / sectors)
    net.join("housing", housing, np.roll(housing, 1, axis=1), around[:, None])
    for name in ("rear", "front"):
        share = layout.share("housing", *HOUSING[name][:2])[:, None] / sectors
        film = p["h_housing"] * p[f"a_housing_{name}"] * share
        net.boundary("film_housing", housing, AIR, film)


def _bearings(layout: Layout, p: Numbers) -> None:
    net, sectors = layout.network, len(layout.angles)
    places = [(name, z) for name, both in BEARINGS.items() for z in both]
    inner = net.add("inner", np.full(len(places), p["c_inner"]))
    balls = net.add("balls", np.full(len(places), p["c_balls"]))
    outer = net.add("outer", np.full((len(places), sectors), p["c_outer"] / sectors))
    shaft, housing = net.parts["shaft"], net.parts["housing"]
    around = STEEL_CONDUCTIVITY * RING_SECTION / (RING_RADIUS * 2.0 * np.pi / sectors)
    net.join("rings", outer, np.roll(outer, 1, axis=1), around)
    for i, (name, z) in enumerate(places):
        seat = layout.share("shaft", z - 10.0, z + 10.0)
        net.join("joint_inner", inner[i], shaft, p["j_inner"] * seat)
        # Two contacts in series, so each conducts twice as well as both.
        race = 2.0 * p[f"j_race_{name}"]
        net.join("race", inner[i], balls[i], race)
        net.join("race", balls[i], outer[i], race / sectors)
        low, high, _ = HOUSING[name]
        sleeve = layout.share("housing", max(z - CARTRIDGE, low), min(z + CARTRIDGE, high))
        joint = p[f"j_outer_{name}"] * sleeve[:, None] / sectors
        net.join(f"joint_outer_{name}", outer[i], housing, joint)


def _motor(layout: Layout, p: Numbers) -> None:
    net, sectors = layout.network, len(layout.angles)
    share = layout.lengths("motor") / np.sum(layout.lengths("motor"))
    rotor = net.add("rotor", p["c_rotor"] * share)
    stator = net.add("stator", np.repeat(p["c_stator"] * share[:, None] / sectors, sectors, axis=1))
    edges = layout.edges["motor"]
    for k in range(len(share)):
        on_shaft = layout.share("shaft", edges[k], edges[k + 1])
        net.join("joint_rotor", rotor[k], net.parts["shaft"], p["j_rotor"] * share[k] * on_shaft)
        in_housing = layout.share("housing", edges[k], edges[k + 1])
        joint = p["j_stator"] * share[k] * in_housing[:, None] / sectors
        net.join("joint_stator", stator[k][None, :], net.parts["housing"], joint)
    # Gaps are per unit of film coefficient; the speed gives the film.
    film = p["gap_film"]
    net.join(
        "gap_rotor", rotor[:, None], stator, film * p["a_gap_rotor"] * share[:, None] / sectors
    )
    shaft, housing = net.parts["shaft"], net.parts["housing"]
    for name, low, high in (("front", 200.0, 320.0), ("rear", -140.0, 0.0)):
        starts, ends = layout.edges["shaft"][:-1], layout.edges["shaft"][1:]
        whole = layout.share("shaft", low, high)
        for k in np.flatnonzero(whole):
            over = layout.share("housing", max(starts[k], low), min(ends[k], high))
            area = film * p[f"a_gap_{name}"] * whole[k] * over[:, None] / sectors
            net.join(f"gap_{name}", shaft[k], housing, area)


def _jackets(layout: Layout, p: Numbers) -> None:
    """Helical jackets: the coolant goes along the axis and touches all sectors on its way.

    The wall film is better on the inlet side, by a first harmonic.
    """
    net, sectors = layout.network, len(layout.angles)
    housing = net.parts["housing"]
    middles, cos, sin = layout.middles("housing"), np.cos(layout.angles), np.sin(layout.angles)
    for name, (low, high, _) in HOUSING.items():
        rows = np.flatnonzero((middles > low) & (middles < high))
        # The front jacket is fed at the nose, the others at the mounting face's side.
        rows = rows[::-1] if name == "front" else rows
        length = layout.lengths("housing")[rows]
        cells = net.add(f"jacket_{name}", p[f"c_jacket_{name}"] * length / length.sum())
        litre = p["coolant"] / 60.0
        net.stream(f"flow_{name}", cells, p[f"flow_{name}"] * litre)
        x, y = (p.get(f"uneven_{name}_{axis}", 0.0) for axis in "xy")
        around = np.maximum(1.0 + x * cos + y * sin, 0.05) / sectors
        wall = p[f"ua_{name}"] * (length / length.sum())[:, None] * around
        net.join(f"wall_{name}", housing[rows], cells[:, None], wall)


def _body(layout: Layout, p: Numbers, resolution: float) -> None:
    """Pedestal from the spindle to the column guide, column from below to the top, bed."""
    net, sectors = layout.network, len(layout.angles)
    count = max(2, round(PEDESTAL_CELLS * resolution))
    pedestal = net.add("pedestal", np.full(count, p["c_pedestal"] / count))
    net.join("pedestal", pedestal[1:], pedestal[:-1], p["g_pedestal"] * (count - 1))
    net.boundary("film_pedestal", pedestal, AIR, p["h_pedestal"] * p["a_pedestal"] / count)
    seat = layout.share("housing", 0.0, 180.0)[:, None, None] / sectors
    entry = np.maximum(1.0 - np.arange(count) / (count / 2.0), 0.0)
    joint = p["j_pedestal"] * seat * entry / entry.sum()
    net.join("joint_pedestal", net.parts["housing"][:, :, None], pedestal, joint)
    count = max(3, round(COLUMN_CELLS * resolution))
    column = net.add("column", np.full(count, p["c_column"] / count))
    net.join("column", column[1:], column[:-1], p["g_column"] * (count - 1))
    net.boundary("film_column", column, HALL, p["h_column"] * p["a_column"] / count)
    height = (np.arange(count) + 0.5) / count
    carried = ((height > 0.4) & (height < 0.9)).astype(float)
    net.join("joint_column", pedestal[-1], column, p["j_column"] * carried / carried.sum())
    count = max(2, round(BED_CELLS * resolution))
    bed = net.add("bed", np.full(count, p["c_bed"] / count))
    net.join("bed", bed[1:], bed[:-1], 40.0 * (count - 1))
    net.boundary("film_bed", bed, HALL, p["h_bed"] * p["a_bed"] / count)
    net.join("joint_bed", column[0], bed[0], p["j_bed"])
