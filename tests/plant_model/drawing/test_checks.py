"""What the sheet of checks says of sound machines, and of machines with a slip in them."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from plant_model.checks import MachineFacts, check_sheet
from plant_model.drawing.fits import odd_fits, odd_of_page
from plant_model.drawing.layout import Drawing
from plant_model.machine import Machine
from plant_model.machine_file import read_machine, shipped_machines
from tests.plant_model.conftest import in_series, with_effects
from tests.plant_model.drawing.pages import changed, machine_of, shipped_page, small_page

FEED = {"unit": "mm_min", "column": "feed_mm_min", "low": 0.0, "high": 9000.0, "default": 0.0}

SPOTS = [
    {"name": "T1", "part": "housing", "at": 150, "side": "X+"},
    {"name": "T2", "part": "head"},
    {"name": "T3", "part": "housing", "at": 150, "side": 0},
    {"name": "T4", "part": "housing", "at": 150, "side": 360},
    {"name": "T5", "part": "head"},
    {"name": "T6", "part": "housing", "at": 150, "side": "X-"},
]


def said_of(page: dict[str, Any]) -> list[str]:
    """Return everything that looks wrong in a page."""
    return [*odd_fits(Drawing(page, "page.toml")), *check_sheet(machine_of(page)).wrong]


@cache
def said_of_the_sound_one() -> list[str]:
    return said_of(small_page())


@cache
def as_shipped() -> MachineFacts:
    return check_sheet(read_machine("jig_borer_lumps"))


def test_a_machine_is_looked_at_after_four_hours_at_full_speed(jig_borer_lumps):
    sheet = check_sheet(jig_borer_lumps)
    assert sheet.shown.time_s[sheet.at] == 4 * 3600.0
    assert sheet.shown.inputs["speed"][sheet.at] == 20000.0


@pytest.mark.parametrize("name", shipped_machines())
def test_shipped_machines_look_right_and_their_heat_is_accounted_for(name):
    sheet = check_sheet(read_machine(name))
    assert sheet.wrong == ()
    made = sum(sheet.sources.values())
    assert made > 100.0
    assert sum(sheet.given_off.values()) + sheet.stored == pytest.approx(made, rel=2e-3)
    assert {part.seen for part in sheet.parts} <= {"read", "beside", "unseen"}
    assert sum(part.nodes for part in sheet.parts) == len(sheet.shown.machine.nodes)
    assert sheet.modes[0][0] == max(hours for hours, _ in sheet.modes)
    assert len(sheet.modes) == 4


def test_heat_of_no_source_counts_once(jig_borer_lumps):
    plain = check_sheet(jig_borer_lumps).sources
    sources = check_sheet(with_effects(jig_borer_lumps, "windage")).sources
    assert sources == pytest.approx(plain | {"other effects": 120.0})


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("viscosity_temperature", "front_bearing"),
        ("thermal_preload:shaft_housing", "rear_bearing"),
        ("natural_convection", "other effects"),
        ("tool_heating", "other effects"),
    ],
)
def test_heat_that_depends_on_temperature_is_accounted_for(key, name, jig_borer_lumps):
    sheet = check_sheet(with_effects(jig_borer_lumps, key))
    assert abs(sheet.sources[name] - as_shipped().sources.get(name, 0.0)) > 0.5
    made = sum(sheet.sources.values())
    assert sum(sheet.given_off.values()) + sheet.stored == pytest.approx(made, rel=2e-3)
    # What is exchanged is generated nowhere.
    made -= sheet.sources.get("other effects", 0.0)
    assert sum(part.heat for part in sheet.parts) == pytest.approx(made)
    assert not any("heat is generated" in line for line in sheet.wrong)


def test_coolant_from_jacket_to_jacket_is_accounted_for(jig_borer_lumps):
    sheet = check_sheet(in_series(jig_borer_lumps, "jacket_rear"))
    made = sum(sheet.sources.values())
    assert sum(sheet.given_off.values()) + sheet.stored == pytest.approx(made, rel=2e-3)
    assert sheet.links["jacket_motor", "jacket_rear"] == pytest.approx(308.3, rel=1e-3)


@pytest.mark.parametrize("name", ["jig_borer", "belt_spindle"])
def test_shipped_pages_fit(name):
    assert odd_fits(Drawing(shipped_page(name), name)) == []


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("carriers.0.mass", 5000, "head has 6.25e+03 kg for each m2 of surface, castings 20 to"),
        ("carriers.1.surface", 40, "column has 17.5 kg for each m2"),
        ("carriers.0.holds", None, "Nothing holds the housing"),
        ("carriers.0.grows", {}, "No carrier moves the nose"),
        ("carriers.0.joint", 2000, "The joint of head is 2000 W/K, far from its class"),
        ("bearings.0.designation", "7014", "The bore of the bearing front is 70 mm, but the shaft"),
        ("bearings.0.designation", "7212", "The outside diameter of the bearing front is 110 mm"),
        (
            "shaft.gauge_line",
            0.26,
            "The gauge line, at 0.26 mm, is not in front of the bearing fro",
        ),
        ("carriers.1.on", "head", "column and head stand on each other."),
        ("bearings.0.f0", 15, "f0 of front is 15, far from its class: 0.3 to 2."),
        ("bearings.0.preload", 9000, "The preload of front is 9000 N, far from its class"),
        ("bearings.0.f0", 15, "runs at"),
        ("inputs.speed.high", 60000.0, "or the highest speed is more than it ever runs"),
        ("jackets", [], "rotor reaches"),
        ("jackets", [], "Nothing uses the input coolant_inlet (column inlet_degC): a jacket says"),
        ("inputs.feed", FEED, "Nothing uses the input feed (column feed_mm_min): a carrier says"),
        ("jackets.0.inlet_side", None, "Nothing moves X: disp_x would stay at zero."),
        ("jackets.0.inlet_side", None, "one has an unevenness but no inlet_side: it cools all"),
        ("thermometers", SPOTS, "T1, T3 and T4 sit on one spot (housing at 150 mm, X+) and would"),
        ("thermometers", SPOTS, "T2 and T5 sit on one spot (head) and would read the same; a car"),
    ],
)
def test_a_slip_shows(key, value, sentence):
    page = changed(small_page(), key, value)
    if key == "jackets":
        page["motor"]["loss"] = 200
    assert any(sentence in line for line in said_of(page))
    assert not any(sentence in line for line in said_of_the_sound_one())


def test_a_shoulder_between_the_bearings_of_a_set_is_no_seat():
    page = changed(small_page(), "bearings.0.spacing", 60)
    ends = [(0, 140, 60), (140, 160, 80), (160, 260, 60)]
    page["shaft"]["stretches"] = [{"from": a, "to": b, "outer": d, "inner": 20} for a, b, d in ends]
    assert not any("The bore" in line for line in odd_fits(Drawing(page, "page.toml")))


def test_what_moves_or_is_used_otherwise_is_not_idle():
    still = changed(small_page(), "jackets.0.inlet_side", None)
    for key, value in (
        ("carriers.0.grows.x", -50),
        ("carriers.0.bends.0.yaw", 1),
        ("effects", {"column_bending:hall": {}}),
        ("rig.axes", {"disp_y": {"axis": "Y"}, "disp_z": {"axis": "Z"}}),
    ):
        assert not any("Nothing moves" in line for line in said_of(changed(still, key, value)))
    fed = changed(small_page(), "inputs.feed", FEED)
    fed = changed(fed, "carriers.1.feed", {"input": "feed"})
    torque = FEED | {"unit": "Nm", "column": "torque_Nm"}
    fed = changed(fed, "inputs.torque", torque)
    assert not any("Nothing uses" in line for line in said_of(fed))


def test_a_running_temperature_that_the_owner_gives_is_believed():
    usual = changed(small_page(), "bearings.0.f0", 15)
    told = r"its viscosity is the class's, for \d+ degC: give the running_temperature"
    assert any(re.search(told, line) for line in said_of(usual))
    own = changed(usual, "bearings.0.running_temperature", 40)
    assert not any("front runs at" in line and "viscosity" in line for line in said_of(own))


def test_lines_that_still_say_check_are_counted():
    drawing = Drawing(shipped_page("belt_spindle"), "page.toml")
    assert odd_of_page(drawing, "# CHECK: a\nb = 2  # CHECK the mass\n") == [
        "2 lines still say CHECK: those values are not from your drawing."
    ]
    assert "1 line still says CHECK" in odd_of_page(drawing, "#CHECK\n")[0]
    assert odd_of_page(drawing, "# Lines with CHECK\nCHECKED = 1\n") == []


def without_links(machine: Machine, *kept_out: str) -> Machine:
    def touches(refs: dict[str, tuple[str, ...]]) -> bool:
        return any(name in names for name in kept_out for names in refs.values())

    items = (i for i in machine.items if i.family != "links" or not touches(i.refs))
    return replace(machine, items=tuple(items))


def test_a_forgotten_link_in_lumps_shows(jig_borer_lumps):
    lost = check_sheet(without_links(jig_borer_lumps, "column")).wrong
    assert "column exchanges heat with nothing: a link is missing." in lost
    kept = without_links(jig_borer_lumps, "column").items
    (path,) = (item for item in jig_borer_lumps.items if item.name == "pedestal-column")
    island = without_links(
        replace(jig_borer_lumps, items=(*kept, path)), "ambient", "coolant_inlet"
    )
    assert any(
        line.startswith("Heat in column never reaches") for line in check_sheet(island).wrong
    )


def test_numbers_far_from_their_kind_show_once(jig_borer_lumps):
    films = [name for name in jig_borer_lumps.parameters if name.endswith("ambient.coefficient")]
    machine = jig_borer_lumps.with_values(dict.fromkeys(films, 0.009), beyond=True)
    lines = [line for line in check_sheet(machine).wrong if "coefficient of a convection" in line]
    assert len(lines) == 1
    assert "and more: " in lines[0]
    assert len(films) > 3
