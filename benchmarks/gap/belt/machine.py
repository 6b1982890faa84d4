"""One machine: its unknowns, where heat enters, where the nose is, what sensors see.

Shaft, housing and tool are finite elements, headstock and column bars that heat goes along, rings,
balls, pulley, nut and the air inside are lumps.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise

import numpy as np

from benchmarks.gap.belt.grouped import BEARINGS, Grouped
from benchmarks.gap.belt.laws import (
    gap_film,
    turning_film,
    turning_share,
)
from benchmarks.gap.belt.mesh import Solid, revolve
from benchmarks.gap.belt.numbers import FRONT_AT, REAR_AT, YAW, Drawing, Stretch
from benchmarks.gap.cells import Array, Index
from benchmarks.gap.march import Now
from benchmarks.gap.numbers import Numbers

POSE = ("x", "y", "elongation")
TOP_SPEED = 8000.0
HEADSTOCK_CELLS, COLUMN_CELLS, TOP_CELLS = 12, 14, 4
HELD = 0.55
"""Share of the headstock, from the spindle's side, that the clamp reaches."""

BALLS_J_PER_K = 90.0
INNER_MASS = 0.5
IRON_DENSITY, STEEL_DENSITY = 7200.0, 7850.0
FILLED = (0.66, 0.78)
"""Steel in the ring between bore and outside of a ball and of a roller bearing [1]."""

GAP_MM = 12.0
FILMS = ("film_housing", "film_headstock", "film_column", "film_turning", "film_walls")
STILL = FILMS[:3]


class Machine(Grouped):
    """A machine of the class.

    Parameters
    ----------
    drawing : Drawing
    numbers : dict of str to float
    finer : float
        Elements are so many times shorter.
    """

    still = STILL
    by_speed = ("gap", "film_turning")
    top_speed = TOP_SPEED

    def __init__(self, drawing: Drawing, numbers: Numbers, finer: float = 1.0) -> None:
        super().__init__(numbers)
        self.drawing = drawing
        self.counts = (len(drawing.front), len(drawing.rear))
        self.diameters = tuple(
            (bore + outside) / 2.0
            for bore, outside in zip(drawing.bores, drawing.outsides, strict=True)
        )
        cuts = [edge for spans in (drawing.front, drawing.rear) for span in spans for edge in span]
        cuts += [FRONT_AT, REAR_AT, *drawing.clamp, drawing.pulley.start, drawing.pulley.end, 0.0]
        self.shaft = revolve(drawing.shaft, cuts, finer)
        self.housing = revolve(drawing.housing, cuts, finer)
        end = drawing.gauge_line
        tool = Stretch(end, end + drawing.tool_length, drawing.tool_diameter, 0.0)
        self.tool = revolve((tool,), (), finer)
        self._solids()
        self._bearings()
        self._pulley()
        self._castings()
        self._air()
        self.close()

    # What it is made of.

    def _solids(self) -> None:
        net, p = self.net, self.p
        for name, solid, metal in (
            ("shaft", self.shaft, "steel"),
            ("housing", self.housing, "iron"),
            ("tool", self.tool, "steel"),
        ):
            numbers = net.add(name, p[f"heat_{metal}"] * solid.volume)
            net.solid("solid", numbers, p[f"k_{metal}"] * solid.conduction)
        shaft, share = self.shaft.face(self.drawing.gauge_line)
        tool, part = self.tool.face(self.drawing.gauge_line)
        pairs = p["taper"] * share[:, None] * part
        net.join("taper", net.parts["shaft"][shaft][:, None], net.parts["tool"][tool], pairs)
        self._gap_pairs()

    def _gap_pairs(self) -> None:
        """Join facing surfaces of shaft and housing, for a film of 1 W/(m2 K)."""
        net, low = self.net, self.drawing.housing[0].start
        seats = [span for spans in (self.drawing.front, self.drawing.rear) for span in spans]
        edges = sorted({low, self.drawing.housing[-1].end, *(e for span in seats for e in span)})
        for start, end in pairwise(edges):
            if any(a < (start + end) / 2.0 < b for a, b in seats):
                continue
            inner, area = self.shaft.surface("outer", start, end)
            outer, facing = self.housing.surface("inner", start, end)
            for node, part in zip(inner.tolist(), area.tolist(), strict=True):
                near = np.abs(self.housing.z[outer] - self.shaft.z[node])
                closest = np.flatnonzero(near < near.min() + 1e-6)
                share = facing[closest] / facing[closest].sum()
                pair = net.parts["housing"][outer[closest]]
                net.join("gap", net.parts["shaft"][node], pair, self.p["gap"] * part * share)

    def _bearings(self) -> None:
        net, p, d = self.net, self.p, self.drawing
        for i, (name, spans) in enumerate(zip(BEARINGS, (d.front, d.rear), strict=True)):
            bore, outside = d.bores[i], d.outsides[i]
            width = sum(end - start for start, end in spans)
            volume = FILLED[i] * np.pi / 4.0 * (outside**2 - bore**2) * width * 1e-9
            heat = volume * p["heat_steel"] - BALLS_J_PER_K
            inner = net.add(f"{name}_inner", INNER_MASS * heat)
            balls = net.add(f"{name}_balls", BALLS_J_PER_K)
            outer = net.add(f"{name}_outer", (1.0 - INNER_MASS) * heat)
            # Two contacts in series, so each conducts twice as well as both.
            through = 2.0 * p["balls"] * p[f"balls_{name}"]
            net.join(f"race_{name}", inner, balls, through)
            net.join(f"race_{name}", balls, outer, through)
            for start, end in spans:
                nodes, area = self.shaft.surface("outer", start, end)
                net.join("seat_shaft", inner, net.parts["shaft"][nodes], p["seat"] * area)
                nodes, area = self.housing.surface("inner", start, end)
                net.join(f"seat_{name}", outer, net.parts["housing"][nodes], p["seat"] * area)

    def _pulley(self) -> None:
        net, p, pulley = self.net, self.p, self.drawing.pulley
        section = np.pi / 4.0 * (pulley.outer**2 - pulley.inner**2) * 1e-6
        volume = section * (pulley.end - pulley.start) * 1e-3
        node = net.add("pulley", volume * p["heat_steel"])
        nodes, area = self.shaft.surface("outer", pulley.start, pulley.end)
        net.join("pulley_seat", node, net.parts["shaft"][nodes], p["pulley_seat"] * area)

    def _castings(self) -> None:
        """Headstock from the guide to the spindle, column from its foot to its top, nut."""
        net, p, d = self.net, self.p, self.drawing
        heat = p["heat_iron"] / IRON_DENSITY
        for name, cells, along in (
            ("headstock", HEADSTOCK_CELLS, "along_headstock"),
            ("column", COLUMN_CELLS, "along_column"),
            ("column_top", TOP_CELLS, "along_column"),
        ):
            numbers = net.add(name, np.full(cells, d.bodies[name].mass * heat / cells))
            net.join(name, numbers[1:], numbers[:-1], p[along] * cells)
        nut = net.add("z_nut", d.bodies["z_nut"].mass * p["heat_steel"] / STEEL_DENSITY)
        head, top, column = (net.parts[name] for name in ("headstock", "column_top", "column"))
        near = head[round((1.0 - HELD) * len(head)) :]
        nodes, area = self.housing.surface("outer", *d.clamp)
        clamp = p["clamp"] * (area / area.sum())[:, None] / len(near)
        net.join("clamp", net.parts["housing"][nodes][:, None], near, clamp)
        net.join("guide", head[0], top, p["guide"] / len(top))
        net.join("bolts", top[0], column[-1], p["bolts"])
        net.join("nut_joint", nut, head[: len(head) // 2], p["nut_joint"] / (len(head) // 2))

    def _air(self) -> None:
        net, p, d = self.net, self.p, self.drawing
        air = net.add("air", p["air_heat"])
        net.to_hall("film_walls", air, p["walls"] * d.walls)
        low, high = d.housing[0].start, d.housing[-1].end
        for start, end in self._unclamped:
            nodes, area = self.housing.surface("outer", start, end)
            film = p["still"] * p["still_housing"] * area
            net.join("film_housing", air, net.parts["housing"][nodes], film)
        for start, end in ((d.shaft[0].start, low), (high, d.gauge_line)):
            self._turning(self.shaft, "shaft", start, end)
        self._turning(self.tool, "tool", d.gauge_line, d.gauge_line + d.tool_length)
        for name in ("headstock", "z_nut"):
            cells = net.parts[name]
            film = p["still"] * p["still_headstock"] * d.bodies[name].surface / len(cells)
            net.join("film_headstock", air, cells, film)
        for name in ("column_top", "column"):
            cells = net.parts[name]
            film = p["still"] * p["still_column"] * d.bodies[name].surface / len(cells)
            net.to_hall("film_column", cells, film)

    @property
    def _unclamped(self) -> tuple[tuple[float, float], ...]:
        d = self.drawing
        return (d.housing[0].start, d.clamp[0]), (d.clamp[1], d.housing[-1].end)

    def _turning(self, solid: Solid, part: str, start: float, end: float) -> None:
        """Add the film of what turns: at rest, and what full speed adds to it."""
        nodes, area = solid.surface("outer", start, end)
        air, surface = self.net.parts["air"], self.net.parts[part][nodes]
        rest = self.p["still"] * self.p["still_housing"] * area
        self.net.join("film_housing", air, surface, rest)
        film = [turning_film(2e-3 * float(solid.r[n]), TOP_SPEED) for n in nodes]
        added = self.p["turning"] * np.array(film) * area
        self.net.join("film_turning", air, surface, added)

    # Heat.

    def factors(self, speed: float) -> dict[str, float]:
        """Return the factors of the gap and of the films on what turns."""
        radius = self.drawing.bores[1] / 2.0 * 1e-3
        return {
            "gap": gap_film(speed, radius, GAP_MM * 1e-3),
            "film_turning": turning_share(speed / TOP_SPEED),
        }

    def add_driven(self, speed: float, feed: float, out: Array) -> None:
        """Add what the belt and the feed axis lose [W] at a speed and a feed [r/min, mm/min]."""
        out += (self.p["belt"] * speed * 1e-3) * self._belt
        out[self.parts["z_nut"]] += self.p["feed"] * feed * 1e-3

    @cached_property
    def _belt(self) -> Array:
        return self.drive_entry(self.p["pulley_share"])

    def drive_entry(self, pulley_share: float) -> Array:
        """Return where the drive's heat enters, shape (unknowns,): pulley and headstock."""
        entry = np.zeros(len(self.capacity))
        entry[self.parts["pulley"]] = pulley_share
        cells = self.parts["headstock"]
        entry[cells] = (1.0 - pulley_share) / len(cells)
        return entry

    # Surfaces.

    @cached_property
    def faces(self) -> tuple[Index, Array]:
        """Surfaces of housing and castings: unknowns, and the area of each [m2]."""
        numbers, areas, inside = zip(*self._exposed(), strict=True)
        self._inside = np.concatenate(
            [np.full(len(n), within) for n, within in zip(numbers, inside, strict=True)]
        )
        return np.concatenate(numbers), np.concatenate(areas)

    def _exposed(self) -> Iterator[tuple[Index, Array, bool]]:
        d, parts = self.drawing, self.parts
        for start, end in self._unclamped:
            nodes, area = self.housing.surface("outer", start, end)
            yield parts["housing"][nodes], area, True
        for name, body in d.bodies.items():
            cells = parts[name]
            area = np.full(len(cells), body.surface / len(cells))
            yield cells, area, name in ("headstock", "z_nut")

    def around(self, now: Now) -> Array:
        """Return the air's temperature in front of all `faces` [degC]."""
        return np.where(self._inside, float(now.temperature[self.parts["air"][0]]), now.hall)

    def take_from_air(self, gained: Array, out: Array) -> None:
        """Take what surfaces inside gain [W] from the air there."""
        out[self.parts["air"][0]] -= float(gained[self._inside].sum())

    # Growth and sensors.

    @cached_property
    def pose_weights(self) -> Array:
        """Pose per kelvin of every unknown, shape (unknowns, 3) [um/K], order of `POSE`."""
        p, d, parts = self.p, self.drawing, self.parts
        weights = np.zeros((len(self.capacity), len(POSE)))
        steel, iron = p["alpha_steel"] * 1e-3, p["alpha_iron"] * 1e-3
        x, y, e = range(3)
        weights[parts["housing"], e] += iron * self.housing.mean_over(0.0, FRONT_AT)
        weights[parts["shaft"], e] += steel * self.shaft.mean_over(FRONT_AT, d.gauge_line)
        head, top = parts["headstock"], parts["column_top"]
        weights[head, y] += iron * d.grows_y / len(head)
        weights[head, e] += iron * d.grows_z / len(head)
        # The headstock bends against the column behind it: 1e-6/K is also urad/K.
        angle = p["alpha_iron"] * d.bend_length / d.bend_width
        for cells, sign in ((head, 1.0), (top, -1.0)):
            for axis, share in ((y, 1.0), (x, YAW)):
                weights[cells, axis] += sign * share * angle * d.bend_lever * 1e-3 / len(cells)
        return weights

    @cached_property
    def thermometers(self) -> dict[str, Array]:
        """Weight of every unknown in the reading of each thermometer but the hall's."""
        d, parts = self.drawing, self.parts
        found: dict[str, Array] = {}

        def on(name: str, numbers: Index, weights: Array) -> None:
            found[name] = np.zeros(len(self.capacity))
            found[name][numbers] = weights

        for name, place, stretch in (
            ("front", FRONT_AT, d.housing[-1]),
            ("front_below", FRONT_AT, d.housing[-1]),
            ("rear", REAR_AT, d.housing[0]),
        ):
            middle = (stretch.inner + stretch.outer) / 4.0
            on(name, parts["housing"], self.housing.at(middle, place))
        for name, part in (
            ("headstock", "headstock"),
            ("column_top", "column_top"),
            ("column", "column"),
        ):
            cells = parts[part]
            two = cells[len(cells) // 2 - 1 : len(cells) // 2 + 1]
            on(name, two, np.full(2, 0.5))
        on("nut", parts["z_nut"], np.ones(1))
        on("inside", parts["air"], np.ones(1))
        return found

    def readings(self, temperatures: Array, pose: Array) -> dict[str, Array]:
        """Return what sensors would show without noise, by run-file column.

        Parameters
        ----------
        temperatures : array, shape (rows, unknowns)
        pose : array, shape (rows, 3)
        """
        shown = {f"{n}_degC": temperatures @ w for n, w in self.thermometers.items()}
        x, y, elongation = pose.T
        return shown | {"disp_x_um": x, "disp_y_um": y, "disp_z_um": -elongation}
