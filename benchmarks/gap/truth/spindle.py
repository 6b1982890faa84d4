"""One machine: its cells, its heat, where heat and temperature move the nose, what sensors see."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from benchmarks.gap.cells import Array, Index
from benchmarks.gap.march import Now
from benchmarks.gap.numbers import Class, Numbers, tables
from benchmarks.gap.truth.laws import gap_film, viscous_torque, watts
from benchmarks.gap.truth.layout import Layout, build

POSE = ("x", "y", "elongation", "yaw", "pitch", "bar")
GAUGE_LINE = 400.0  # mm from the mounting face
NEAR, SPACING = 30.0, 100.0  # mm
GAPS = {"gap_rotor": (0.050, 0.7e-3), "gap_front": (0.036, 1e-3), "gap_rear": (0.033, 1e-3)}
"""Radius and width of each gap [m]."""
FILMS = ("film_nose", "film_bar", "film_housing", "film_pedestal", "film_column", "film_bed")
TOP_SPEED = 20e3
CLASS = Class(**tables(__file__))


class Spindle:
    """A machine of the jig borer's class.

    Parameters
    ----------
    numbers : dict
        Of `CLASS`.
    resolution : float
        1 for about 280 cells; 2 halves all of them.
    """

    top_speed = TOP_SPEED

    def __init__(self, numbers: Numbers, resolution: float = 1.0) -> None:
        self.p = numbers
        self.layout: Layout = build(numbers, resolution)
        network = self.layout.network
        self.parts = network.parts
        self.capacity = network.capacity
        self.matrices = {group: network.matrices(group) for group in network.groups}
        self.surfaces = {group: network.surfaces(group) for group in FILMS}
        self._constant = [group for group in self.matrices if group not in GAPS]

    def conductances(self, speed: float, scales: dict[str, float]) -> tuple[Array, Array]:
        """Return heat per kelvin of cells and boundaries [W/K] at a speed, groups scaled."""
        inner, outer = (part.copy() for part in self._base)
        for group, (radius, gap) in GAPS.items():
            inner += (scales.get(group, 1.0) * gap_film(speed, radius, gap)) * self.matrices[group][
                0
            ]
        for group, scale in scales.items():
            if group not in GAPS and scale != 1.0:
                inner += (scale - 1.0) * self.matrices[group][0]
                outer += (scale - 1.0) * self.matrices[group][1]
        return inner, outer

    @cached_property
    def _base(self) -> tuple[Array, Array]:
        return (
            np.sum([self.matrices[group][0] for group in self._constant], axis=0),
            np.sum([self.matrices[group][1] for group in self._constant], axis=0),
        )

    # Heat.

    @cached_property
    def f0(self) -> Array:
        """Friction factor of every bearing, rear ones first [1]."""
        balance = self.p["pair_balance"]
        pair = np.array([balance, 2.0 - balance])
        return np.concatenate([self.p["f0_rear"] * pair, self.p["f0_front"] * pair])

    @cached_property
    def preload(self) -> Array:
        """Preload of every bearing [N]."""
        return np.repeat([self.p["preload_rear"], self.p["preload_front"]], 2)

    def friction(self, speed: float) -> tuple[Array, Array]:
        """Return viscous and load-dependent heat of every bearing [W]."""
        viscous = viscous_torque(self.f0, self.p["viscosity"], speed)
        load = self.p["f1"] * self.preload * 70.0
        return watts(speed, viscous), watts(speed, load)

    @cached_property
    def bearing_entry(self) -> Array:
        """Where each bearing's heat enters, shape (cells, bearings)."""
        parts, p = self.parts, self.p
        entry = np.zeros((len(self.capacity), len(parts["inner"])))
        columns = np.arange(entry.shape[1])
        entry[parts["inner"], columns] = p["inner_share"]
        entry[parts["balls"], columns] = p["ball_share"]
        rest = 1.0 - p["inner_share"] - p["ball_share"]
        for i in columns:
            entry[parts["outer"][i], i] = rest / parts["outer"].shape[1]
        return entry

    def drive_entry(self, rotor_share: float | None = None) -> Array:
        """Return where the motor's heat enters, shape (cells,), its sum 1."""
        share = self.p["rotor_share"] if rotor_share is None else rotor_share
        entry = np.zeros(len(self.capacity))
        for part, of_all in (("rotor", share), ("stator", 1.0 - share)):
            cells = self.parts[part]
            entry[cells] = of_all * self.capacity[cells] / self.capacity[cells].sum()
        return entry

    def rings(self, temperatures: Array, which: str) -> Array:
        """Return the mean of every bearing's inner rings, balls or outer rings [degC]."""
        values = temperatures[self.parts[which]]
        return np.asarray(values if values.ndim == 1 else values.mean(axis=1))

    # Surfaces.

    @cached_property
    def faces(self) -> tuple[Index, Array]:
        """All outer surfaces: cells, and the area of each [m2]."""
        areas = [
            g / self.p[f"h_{group.removeprefix('film_')}"]
            for group, parts in self.surfaces.items()
            for _, _, g in parts
        ]
        exposed = [cells for parts in self.surfaces.values() for cells, _, _ in parts]
        return np.concatenate(exposed), np.concatenate(areas)

    @cached_property
    def _boundary_of_faces(self) -> Index:
        faced = [one for parts in self.surfaces.values() for one in parts]
        return np.concatenate([np.full(len(cells), which) for cells, which, _ in faced])

    def around(self, now: Now) -> Array:
        """Return the air's temperature in front of all `faces` [degC]."""
        return np.asarray(now.look()[self._boundary_of_faces])

    def take_from_air(self, gained: Array, out: Array) -> None:
        """Leave the air as it is; it is a boundary."""

    # Growth.

    @cached_property
    def pose_weights(self) -> Array:
        """Pose per kelvin of every cell, shape (cells, 6) [um/K, urad/K], order of `POSE`."""
        weights = np.zeros((len(self.capacity), len(POSE)))
        self._axial_growth(weights)
        self._housing_bend(weights)
        self._headstock(weights)
        return weights

    def _axial_growth(self, weights: Array) -> None:
        p, layout = self.p, self.layout
        located, e = p["located"], POSE.index("elongation")
        steel = p["alpha_steel"] * 1e-3
        housing = located * layout.share("housing", 0.0, located)
        weights[self.parts["housing"], e] += steel * housing[:, None] / len(layout.angles)
        shaft = (GAUGE_LINE - located) * layout.share("shaft", located, GAUGE_LINE)
        weights[self.parts["shaft"], e] += steel * shaft
        weights[self.parts["bar"], POSE.index("bar")] += steel * layout.lengths("bar")

    def _housing_bend(self, weights: Array) -> None:
        """A beam whose sides grow unequally: curvature 2 alpha T1 / w, T1 the first harmonic."""
        p, layout = self.p, self.layout
        starts, ends = layout.edges["housing"][:-1], layout.edges["housing"][1:]
        length = np.where(ends > 0.0, ends - np.maximum(starts, 0.0), 0.0)
        arm = GAUGE_LINE - (ends + np.maximum(starts, 0.0)) / 2.0
        curvature = 2.0 * p["alpha_steel"] / p["width"]
        for tilt, shift, around in (
            ("yaw", "x", np.cos(layout.angles)),
            ("pitch", "y", np.sin(layout.angles)),
        ):
            # Growth on the X+ side turns the nose towards X-.
            per_cell = -curvature * length[:, None] * around * 2.0 / len(around)
            weights[self.parts["housing"], POSE.index(tilt)] += per_cell
            weights[self.parts["housing"], POSE.index(shift)] += per_cell * arm[:, None] * 1e-3

    def _headstock(self, weights: Array) -> None:
        p, pedestal, column = self.p, self.parts["pedestal"], self.parts["column"]
        iron = p["alpha_iron"] * 1e-3
        weights[pedestal, POSE.index("y")] += iron * p["pedestal_length"] / len(pedestal)
        near = pedestal[: max(1, len(pedestal) // 2)]
        weights[near, POSE.index("elongation")] += iron * p["headstock_height"] / len(near)
        upper = column[len(column) // 3 :]
        bend = p["alpha_iron"] * p["headstock_bend"]
        arm = p["headstock_lever"] * 1e-3
        for cells, sign in ((pedestal, 1.0), (upper, -1.0)):
            per_cell = sign * bend / len(cells)
            for tilt, shift, share in (("pitch", "y", 1.0), ("yaw", "x", p["headstock_yaw"])):
                weights[cells, POSE.index(tilt)] += share * per_cell
                weights[cells, POSE.index(shift)] += share * per_cell * arm

    # Sensors.

    @cached_property
    def thermometers(self) -> dict[str, Array]:
        """Weight of every cell in the reading of each thermometer but T5 and T9."""
        layout, parts = self.layout, self.parts
        sectors = len(layout.angles)
        found = {}

        def single(cells: Index | int, name: str) -> None:
            weights = np.zeros(len(self.capacity))
            weights[cells] = 1.0 / np.size(cells)
            found[name] = weights

        single(parts["outer"][:2, sectors // 8], "T1")
        pedestal = parts["pedestal"]
        single(pedestal[int(0.4 * len(pedestal))], "T2")
        for name, jacket in (("T3", "rear"), ("T4", "front"), ("T10", "motor")):
            single(parts[f"jacket_{jacket}"][-1], name)
        for name, z, sector in (
            ("T6", 245.0, sectors // 2),
            ("T7", 245.0, sectors // 4),
            ("T8", 95.0, sectors // 4),
            ("T11", 95.0, sectors // 2),
        ):
            weights = np.zeros(len(self.capacity))
            middles = layout.middles("housing")
            for row in range(len(middles)):
                one = np.zeros(len(middles))
                one[row] = 1.0
                weights[parts["housing"][row, sector]] = np.interp(z, middles, one)
            found[name] = weights
        return found

    def readings(self, temperatures: Array, pose: Array) -> dict[str, Array]:
        """Return what sensors would show without noise, by run-file column.

        Parameters
        ----------
        temperatures : array, shape (rows, cells)
        pose : array, shape (rows, 6)
        """
        shown = {f"{n}_degC": temperatures @ w for n, w in self.thermometers.items()}
        x, y, elongation, yaw, pitch, bar = pose.T
        for name, shift, tilt, z in (
            ("S1", x, yaw, NEAR),
            ("S2", y, pitch, NEAR),
            ("S3", x, yaw, NEAR + SPACING),
            ("S4", y, pitch, NEAR + SPACING),
        ):
            shown[f"{name}_um"] = shift + z * 1e3 * np.tan(tilt * 1e-6)
        shown["S5_um"] = -(elongation + bar)
        return shown
