"""One lathe: bars in fine stretches, where heat enters, where the tool is, what sensors see."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from benchmarks.gap.belt.grouped import BEARINGS, Grouped
from benchmarks.gap.belt.machine import BALLS_J_PER_K, POSE
from benchmarks.gap.cells import Array, Index
from benchmarks.gap.lathe.numbers import COUNTS, DIAMETERS, TABLES, Drawing
from benchmarks.gap.march import Now
from benchmarks.gap.numbers import Numbers

TOP_SPEED = 4000.0
RING_J_PER_K = (520.0, 260.0)
"""Heat capacity of the rings of each set, inner and outer together [J/K]."""

TRAVEL = (0.35, 0.8)
"""Where along the bed the carriage goes, and along the screw its nut [1]."""

FILMS = ("film_hall", "film_inside", "film_walls")
AXES = ("z", "x")


class Lathe(Grouped):
    """A lathe of the class; its parts and groups have the names of `belt.machine` where alike.

    Parameters
    ----------
    drawing : Drawing
    numbers : dict of str to float
    finer : float
        Stretches are so many times shorter.
    """

    still = FILMS[:2]
    counts, diameters = COUNTS, DIAMETERS
    top_speed = TOP_SPEED

    def __init__(self, drawing: Drawing, numbers: Numbers, finer: float = 1.0) -> None:
        super().__init__(numbers)
        self.drawing = drawing
        self._bars(finer)
        self._bearings()
        self._joints()
        self._axes()
        self._air()
        self.close()

    def _bars(self, finer: float) -> None:
        for name, part in self.drawing.parts.items():
            cells = part.cells if part.cells == 1 else max(2, round(part.cells * finer))
            heat = self.p[f"heat_{part.metal}"] * part.mass / cells
            numbers = self.net.add(name, np.full(cells, heat))
            if cells > 1:
                along = self.p[f"along_{name}"] * cells
                self.net.join(name, numbers[1:], numbers[:-1], along)

    def between(self, name: str, low: float, high: float) -> tuple[Index, Array]:
        """Return the cells of a bar in a span of it (0 to 1), and the share of each, sum 1."""
        numbers = self.net.parts[name]
        edges = np.linspace(0.0, 1.0, len(numbers) + 1)
        share = np.minimum(edges[1:], high) - np.maximum(edges[:-1], low)
        inside = np.flatnonzero(share > 1e-12)
        return numbers[inside], share[inside] / share[inside].sum()

    def _spread(self, group: str, one: str, span: tuple[float, float], other: object) -> None:
        """Join a span of a bar to unknowns, by the group's number."""
        cells, share = self.between(one, *span)
        self.net.join(group, cells, other, self.p[group] * share)

    def _bearings(self) -> None:
        """The front set is near the nose, where spindle and headstock begin."""
        net, p = self.net, self.p
        for i, (name, seat) in enumerate(zip(BEARINGS, ((0.12, 0.32), (0.75, 0.9)), strict=True)):
            inner = net.add(f"{name}_inner", 0.5 * RING_J_PER_K[i])
            balls = net.add(f"{name}_balls", BALLS_J_PER_K)
            outer = net.add(f"{name}_outer", 0.5 * RING_J_PER_K[i])
            net.join(f"race_{name}", inner, balls, 2.0 * COUNTS[i] * p["balls"])
            net.join(f"race_{name}", balls, outer, 2.0 * COUNTS[i] * p["balls"])
            cells, share = self.between("spindle", *seat)
            net.join("seat_shaft", inner, cells, COUNTS[i] * p["seat_shaft"] * share)
            sleeve = (0.0, 0.5) if name == "front" else (0.5, 1.0)
            cells, share = self.between("headstock", *sleeve)
            net.join(f"seat_{name}", outer, cells, COUNTS[i] * p["seat"] * share)

    def _joints(self) -> None:
        net, p = self.net, self.p
        head, share = self.between("headstock", 0.0, 1.0)
        bed, part = self.between("bed", 0.0, TRAVEL[0])
        net.join("foot", head[:, None], bed, p["foot"] * share[:, None] * part)
        bed, part = self.between("bed", *TRAVEL)
        carriage, share = self.between("carriage", 0.0, 1.0)
        net.join("z_guide", carriage[:, None], bed, p["z_guide"] * share[:, None] * part)
        slide, part = self.between("slide", 0.0, 1.0)
        net.join("x_guide", carriage[:, None], slide, p["x_guide"] * share[:, None] * part)
        self._spread("motor_foot", "bed", (0.0, TRAVEL[0]), net.parts["spindle_motor"])

    def _axes(self) -> None:
        """Nut on what it moves, screw through it, motor and bearings of the screw on the rest."""
        net, p = self.net, self.p
        for axis, moved, rest in (("z", "carriage", "bed"), ("x", "slide", "carriage")):
            nut, motor = net.parts[f"{axis}_nut"], net.parts[f"{axis}_motor"]
            self._spread(f"{axis}_nut_joint", moved, (0.0, 1.0), nut)
            cells, share = self.between(f"{axis}_screw", *TRAVEL)
            net.join(f"{axis}_ball", nut, cells, p[f"{axis}_ball"] * share)
            far = (TRAVEL[1], 1.0) if axis == "z" else (0.0, 1.0)
            self._spread(f"{axis}_motor_joint", rest, far, motor)
            ends, share = self.between(f"{axis}_screw", 0.0, 1.0)
            held, part = self.between(rest, *far)
            through = p[f"{axis}_screw_ends"] * share[:, None] * part
            net.join(f"{axis}_screw_ends", ends[:, None], held, through)

    def _air(self) -> None:
        net, p = self.net, self.p
        air = net.add("air", p["air_heat"])
        net.to_hall("film_walls", air, p["walls"])
        for name, part in self.drawing.parts.items():
            cells = net.parts[name]
            film = p[part.air] * part.surface / len(cells)
            if part.surface and part.air == "hall":
                net.to_hall("film_hall", cells, film)
            elif part.surface:
                net.join("film_inside", air, cells, film)
        cells, share = self.between("spindle", 0.0, 0.12)
        net.join("film_inside", air, cells, p["chuck"] * 0.09 * share)

    # Heat.

    def drive_entry(self, share: float) -> Array:
        """Return where the spindle motor's heat enters; it has no pulley that *share* is for."""
        entry = np.zeros(len(self.capacity))
        entry[self.parts["spindle_motor"]] = 1.0
        return entry

    def add_driven(self, speed: float, feed: float, out: Array) -> None:
        """Add what motors, nuts and screws lose [W] at a speed and a feed [r/min, mm/min]."""
        p, parts = self.p, self.parts
        out[parts["spindle_motor"]] += p["motor"] * speed * 1e-3
        for axis in AXES:
            out[parts[f"{axis}_nut"]] += p[f"{axis}_nut_loss"] * feed * 1e-3
            out[parts[f"{axis}_motor"]] += p[f"{axis}_motor_loss"] * feed * 1e-3
            cells = parts[f"{axis}_screw"]
            out[cells] += p[f"{axis}_screw_loss"] * feed * 1e-3 / len(cells)

    # Surfaces.

    @cached_property
    def faces(self) -> tuple[Index, Array]:
        """Surfaces in the hall: cells, and the area of each [m2]."""
        named = {n: part for n, part in self.drawing.parts.items() if part.air == "hall"}
        cells = [self.parts[name] for name in named]
        areas = [
            np.full(len(numbers), part.surface / len(numbers))
            for numbers, part in zip(cells, named.values(), strict=True)
        ]
        return np.concatenate(cells), np.concatenate(areas)

    def around(self, now: Now) -> float:
        """Return the hall's temperature [degC]."""
        return now.hall

    # Growth and sensors.

    @cached_property
    def pose_weights(self) -> Array:
        """Pose per kelvin of every unknown, shape (unknowns, 3) [um/K], order of `POSE`."""
        weights = np.zeros((len(self.capacity), len(POSE)))
        for one in self.drawing.members.values():
            cells, share = self.between(one.part, one.low, one.high)
            alpha = self.p[f"alpha_{self.drawing.parts[one.part].metal}"]
            weights[cells, POSE.index(one.axis)] += alpha * 1e-3 * (one.sign * one.length) * share
        return weights

    @cached_property
    def thermometers(self) -> dict[str, Array]:
        """Weight of every unknown in the reading of each thermometer but the hall's."""
        found = {}
        for name, (part, low, high, _) in TABLES["thermometers"].items():
            cells, share = self.between(part, low, high)
            found[name] = np.zeros(len(self.capacity))
            found[name][cells] = share
        return found

    def readings(self, temperatures: Array, pose: Array) -> dict[str, Array]:
        """Return what sensors would show without noise, by run-file column."""
        shown = {f"{n}_degC": temperatures @ w for n, w in self.thermometers.items()}
        return shown | {"disp_x_um": pose[:, 0], "disp_z_um": -pose[:, 2]}
