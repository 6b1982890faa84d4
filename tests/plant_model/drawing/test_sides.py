"""What holds, cools or touches the spindle on one side, and sleeves of their own."""

from typing import Any

import numpy as np
import pytest

from plant_model.drawing.form import PatchForm, degrees
from plant_model.drawing.mesh import NAMED, Sector
from plant_model.effects.housing_bending import HousingBending
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import Values
from plant_model.simulate import simulate
from plant_model.warm_up import warm_up
from tests.plant_model.drawing.pages import changed, machine_of, small_page, without_one_sidedness

HOLDS = "carriers.0.holds"
SIDED = {"from": 0, "to": 60, "side": "Y-", "width": 60}


def links_to(machine: Machine, other: str, kind: str = "contact") -> dict[str, float]:
    """Return the conductance from each housing cell to a part [W/K]."""
    return {
        first: item.parameters["conductance"].value
        for item in machine.of_kind("links", kind)
        for first, second in [item.refs["between"]]
        if second == other and first.startswith("housing")
    }


@pytest.mark.parametrize(
    ("count", "width", "side"),
    [(4, 90.0, "Y-"), (8, 200.0, 33.0), (12, 350.0, "Y-"), (16, 1.0, 33.0)],
)
def test_sectors_share_a_patch_as_its_directions_do(count, width, side):
    patch = PatchForm(**{"from": 0.0, "to": 1.0, "side": side, "width": width})
    sectors = [Sector("", 360.0 * k / count, 1.0 / count) for k in range(count)]
    # Direction by direction instead of arc by arc.
    around = np.arange(0.05, 360.0, 0.1)
    covered = np.abs((around - degrees(side) + 180.0) % 360.0 - 180.0) < width / 2.0
    for sector in sectors:
        inside = np.abs((around - sector.angle + 180.0) % 360.0 - 180.0) < 180.0 / count
        assert sector.under(patch) == pytest.approx((covered & inside).mean(), abs=1e-3)
    assert sum(sector.under(patch) for sector in sectors) == pytest.approx(width / 360.0)


def test_a_bracket_on_one_side_is_joined_to_that_side_alone():
    around, sided = (
        links_to(machine_of(page), "head")
        for page in (small_page(), changed(small_page(), HOLDS, SIDED))
    )
    assert {name.rpartition("_")[2] for name in around} == set(NAMED.values())
    assert {name.rpartition("_")[2] for name in sided} == {"ym"}
    assert sum(sided.values()) == pytest.approx(sum(around.values()))


def test_heat_that_leaves_on_one_side_tilts_the_nose():
    page = changed(small_page(), "jackets.0.inlet_side", None)
    tilts = []
    for side in (None, "Y-", "Y+"):
        held = {k: v for k, v in SIDED.items() if k != "side"} | ({"side": side} if side else {})
        # The carriers' own bending is another thing.
        machine = machine_of(changed(changed(page, HOLDS, held), "carriers.0.bends", []))
        tilts.append(simulate(machine, warm_up(machine)).pose[0, -1, 4])
    assert tilts[0] == pytest.approx(0.0, abs=1e-6)
    assert tilts[1] == pytest.approx(-tilts[2], rel=1e-6)
    assert abs(tilts[1]) > 1.0


def test_the_surface_under_a_bracket_is_not_in_the_air():
    def area(page: dict[str, Any]) -> float:
        return sum(
            item.parameters["area"].value
            for item in machine_of(page).of_kind("links", "convection")
            if item.refs["between"][0].startswith("housing")
        )

    whole = np.pi * 180.0 * 200.0 * 1e-6
    assert area(small_page()) == pytest.approx(whole * 140.0 / 200.0)
    sided = area(changed(small_page(), HOLDS, SIDED))
    assert sided == pytest.approx(whole * (1.0 - 60.0 / 200.0 * 60.0 / 360.0))
    faces = [{"from": 100, "to": 200, "side": "X+", "film": 60}]
    assert area(changed(small_page(), "housing.faces", faces)) == pytest.approx(area(small_page()))


def test_a_face_that_is_blown_on_is_cooler():
    faces = [{"from": 0, "to": 200, "side": "X+", "film": 200}]
    page = changed(small_page(), "jackets", [])
    machine = machine_of(changed(page, "housing.faces", faces))
    assert machine.parameters["numbers.face_1_film"].calibrate
    inputs = warm_up(machine)
    warm = simulate(machine, inputs).temperatures[0, -1]
    ends = {side: warm[machine.node_index[f"housing_2_{side}"]] for side in NAMED.values()}
    assert ends["xp"] < ends["yp"] < ends["xm"]
    assert ends["yp"] == pytest.approx(ends["ym"])


@pytest.mark.parametrize(("side", "share"), [("X+", 0.3), (None, 0.0)])
def test_only_a_jacket_with_an_inlet_side_cools_unevenly(side, share):
    page = changed(small_page(), "jackets.0.unevenness", None)
    machine = machine_of(changed(page, "jackets.0.inlet_side", side))
    wall = machine.parameters["numbers.jacket_one_wall"].value
    more = [
        item.parameters["difference"].value
        for item in machine.of_kind("links", "coolant_unevenness")
    ]
    # Of four sides one is cooled better and one worse, each a quarter of the wall.
    assert sum(map(abs, more)) == pytest.approx(share * wall / 2.0)


def test_no_side_cools_less_than_not_at_all():
    machine = machine_of(changed(small_page(), "jackets.0.unevenness", 0.9))
    assert machine.parameters["numbers.jacket_one_unevenness"].high == pytest.approx(
        machine.parameters["numbers.jacket_one_wall"].value
    )
    values = Values(machine.parameters, {"effects.uneven_cooling.scale": 1.5})
    network = Network(machine, values, effects_in_force(machine, values))
    inputs = {entry.name: np.array([0.0]) for entry in machine.inputs}
    paths = -network.conductances(inputs)[0][0]
    np.fill_diagonal(paths, 0.0)
    assert paths.min() == 0.0


def test_a_jacket_on_one_side_has_so_much_less_channel():
    page = without_one_sidedness()
    whole = machine_of(page)
    half = machine_of(changed(changed(page, "jackets.0.side", "X+"), "jackets.0.width", 180))
    wall = "numbers.jacket_one_wall"
    assert half.parameters[wall].value == pytest.approx(whole.parameters[wall].value / 2.0)
    shares = {
        first.rpartition("_")[2]
        for item in half.of_kind("links", "coolant_wall")
        for first, _ in [item.refs["between"]]
    }
    assert shares == {"xp", "yp", "ym"}


def test_a_sleeve_of_its_own_stands_between_bearing_and_housing():
    page = changed(small_page(), "bearings.0.designation", None)
    sleeve = {"from": 110, "to": 190, "outer": 100}
    page["bearings"][0] |= {"bore": 60, "outside": 85, "width": 18, "sleeve": sleeve}
    page["thermometers"].append({"name": "T3", "part": "front.sleeve"})
    machine = machine_of(page)
    heat = np.pi / 4.0 * (0.1**2 - 0.085**2) * 0.08
    steel = machine.parameters["numbers.steel_heat"].value
    assert machine.parameters["nodes.front_sleeve.capacity"].value == pytest.approx(heat * steel)
    assert not links_to(machine, "front_outer")
    joined = {
        pair for item in machine.of_kind("links", "contact") for pair in [item.refs["between"]]
    }
    assert ("front_outer", "front_sleeve") in joined
    assert {a for a, b in joined if b.startswith("housing")} == {
        "front_sleeve",
        "rear_outer",
        "stator",
    }


@pytest.mark.parametrize("face", [0.0, 170.0])
def test_the_nose_follows_the_housing_from_the_face_to_the_locating_bearing(face):
    """A ring that is a cosine warmer towards Y+ bends by that over its radius, away from Y+."""
    page = small_page()
    for part in (*page["shaft"]["stretches"], *page["housing"]["stretches"], page["jackets"][0]):
        part["from"], part["to"] = part["from"] - face, part["to"] - face
    page["motor"] |= {"from": 50 - face, "to": 100 - face}
    page["thermometers"][0]["at"] -= face
    page["carriers"][0] |= {"holds": {"from": -face, "to": 60 - face}, "bends": []}
    page["shaft"]["gauge_line"] -= face
    for bearing in page["bearings"]:
        bearing["at"] -= face
    machine = machine_of(page)
    rise = np.zeros((1, 1, len(machine.nodes)))
    for name, at in machine.node_index.items():
        if name.startswith("housing"):
            rise[..., at] = {"yp": 1.0, "ym": -1.0}.get(name.rpartition("_")[2], 0.0)
    out = np.zeros((1, 1, 6))
    HousingBending(machine, Values(machine.parameters)).displacement({}, rise, np.zeros(0), out)
    # Slope and deflection along the housing, clamped at 0, in steps from the face to the bearing.
    bearing, gauge = 150.0 - face, 260.0 - face
    along = np.linspace(0.0, bearing, 10001)
    slope = -11.5 / 70.0 * along
    moved = np.sum((slope[1:] + slope[:-1]) / 2.0 * np.diff(along)) * 1e-3
    assert out[0, 0, 4] == pytest.approx(slope[-1])
    assert out[0, 0, 1] == pytest.approx(moved + slope[-1] * (gauge - bearing) * 1e-3)


def test_rings_bend_up_to_the_bearing_that_locates_even_after_the_expansion():
    page = small_page()
    rear = changed(changed(page, "bearings.0.locates", False), "bearings.1.locates", True)
    at = next(b["at"] for b in page["bearings"] if b["name"] == "rear")
    there = {"structure.front.at": at}
    drawn, moved = machine_of(rear), machine_of(page).with_values(there, beyond=True)
    poses = [simulate(machine, warm_up(machine)).pose for machine in (drawn, moved)]
    assert np.abs(poses[0][0, -1, 3:5]).max() > 1.0
    np.testing.assert_allclose(poses[0], poses[1], rtol=1e-9, atol=1e-9)
