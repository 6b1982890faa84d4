"""What is wrong with a page is refused in one line: place, value, what is allowed."""

import pytest

from measurement.errors import counted_from_one
from plant_model.machine_forms import named_place
from tests.plant_model.drawing.pages import changed, machine_of, refusal, small_page

SIDED = {"from": 0, "to": 60, "side": "Y-", "width": 60}
JACKET = {"name": "one", "from": 0, "to": 60, "flow": 4}


def stretches(end: float, start: float) -> list[dict[str, float]]:
    """Return two stretches of the shaft, of which the first ends and the second starts there."""
    return [{"from": 0, "to": end, "outer": 60}, {"from": start, "to": 260, "outer": 60}]


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        # Stretches that overlap, leave a gap, are turned around or do not fit.
        ("shaft.stretches", stretches(120, 100), ".1.from: 100 mm overlaps the stretch before, wh"),
        ("shaft.stretches", stretches(100, 110), ".1.from: 110 mm leaves a gap to the stretch be"),
        ("shaft.stretches.0.inner", 60, ": 60 mm must be below outer 60"),
        ("shaft.stretches.0.outer", 105, ": 105 mm does not fit into the housing, which is 100"),
        # A sensor in the air, or on a side that no cell has.
        ("thermometers.0.at", 230, ": 230 mm is in the air: the housing is from 0 to 200 mm"),
        ("thermometers.0.part", "hosing", "did you mean housing?"),
        ("thermometers.0.side", None, ": is missing: X+, X-, Y+, Y- or degrees"),
        ("thermometers.0.side", 30, ": 30 degrees is not the middle of a sector (0, 90, 180, 270)"),
        ("thermometers.0.at", None, ": is missing: where on the housing [mm]"),
        # A bearing outside the shaft, of an unknown size, or in another's place.
        (
            "bearings.1.at",
            -30,
            ": at -30 mm it sits from -39 to -21 mm, which is outside the shaft",
        ),
        ("bearings.0.at", 220, ": at 220 mm it sits from 202 to 238 mm, which is outside the hous"),
        ("bearings.0.designation", "7099", ": '7099' is not known; known"),
        ("bearings.0.designation", None, ": is missing: or bore, outside"),
        ("bearings.1.at", 140, "bearings: rear and front overlap: one ends at 149 mm, the next"),
        ("bearings.0.sleeve", {"from": 140, "to": 190}, ": 140 to 190 mm does not hold the beari"),
        ("bearings.0.sleeve", {"from": 120, "to": 230}, ": 230 mm is outside the"),
        ("bearings.0.locates", False, "bearings: 0 of them locate the shaft: exactly one"),
        ("bearings.0.lubrication", "honey", ": 'honey' is not allowed"),
        ("bearings.0.grade", 1000, ": 1000 is not allowed: 10 to 320 mm2/s at 40"),
        # Units wrong by a thousand.
        ("shaft.stretches.0.outer", 0.06, ": 0.06 is not allowed: 5 to"),
        ("housing.stretches.0.to", 0.2, "stretches, item 1: from 0 to 0.2 mm: must be 1 mm"),
        ("housing.stretches.0.outer", 180000, "180000 is not allowed: 5 to 2000 mm can be"),
        ("carriers.0.mass", 200000, ": 200000 is not allowed: 0.05 to 50000 kg"),
        ("jackets.0.flow", 4000, ": 4000 is not allowed: 0.05 to 200 l/min can be"),
        ("motor.loss", 20000, ": 20000 is not allowed: 0 to 2000 W/(1000 r/min)"),
        # One side.
        ("carriers.0.holds", SIDED | {"width": 0}, ".width: 0 is not allowed: 1 to 360 degrees"),
        ("carriers.0.holds", SIDED | {"side": "Z"}, ".side"),
        ("housing.faces", [{"from": 0, "to": 900}], ".0.to: 900 mm is outside the housing, which"),
        # Twice the same surface.
        ("housing.faces", [{"from": 0, "to": 60}, SIDED], ".1: from 0 to 60 mm overlaps the one f"),
        ("housing.faces", [SIDED, SIDED | {"side": 329}], ".1: from 0 to 60 mm overlaps the one f"),
        ("jackets", [JACKET, JACKET | {"from": 9, "name": "b"}], ".b: from 9 to 60 mm ov"),
        ("carriers.1.holds", SIDED, ": from 0 to 60 mm overlaps the one from 0 to 60 mm: its"),
        (
            "housing.faces",
            [{"from": 0, "to": 9, "air": "x"}],
            ".0.air: 'x' is not one of ambient, ",
        ),
        (
            "bearings.0.sleeve",
            {"from": 110, "to": 190, "outer": 80},
            ".outer: 80 mm must be above ",
        ),
        ("kind", "drawin", ": 'drawin' is not allowed: input should be 'drawing'"),
        # Materials, coolants, names that do not exist.
        ("shaft.material", "unobtainium", ": 'unobtainium' is not one of steel, cast"),
        ("housing.stretches.0.material", "steal", "did you mean steel?"),
        ("jackets.0.fluid", "beer", ": 'beer' is not one of water, glycol N %"),
        ("jackets.0.inlet", "chiller", ": there is no input chiller"),
        ("jackets.0.after", "two", ": 'two' is not one of them: there are none"),
        ("carriers.0.on", "bed", ": 'bed' is not one of column"),
        ("carriers.0.air", "enclosure", ": 'enclosure' is not one of ambient, cool"),
        # The motor.
        ("motor.rotor_outer", 120, ": rotor_outer 120 mm must be below stator_out"),
        ("motor.rotor_outer", None, ": is missing: the rotor's diameter [mm]"),
        ("motor.loss", None, ": is missing: W/(1000 r/min), or power [kW], efficiency"),
        ("motor.efficiency", 92, ": 92 is not allowed: 0.3 to 0.995 (share, not"),
        ("motor.to", 300, ": 300 mm is outside the shaft, which is from 0 to 260 mm"),
        # The form.
        ("inputs.speed", None, "inputs: speed is missing: an input in rpm of this name"),
        ("inputs.speed.high", 0, "inputs.speed: 0 to 0 rpm is no range to turn in"),
        ("shaft.gauge_line", 300, ": 300 mm is outside the shaft"),
        ("shaft.lenght", 3, ": is not a known field"),
        ("shaft", None, ": is missing"),
        ("jackets.0.flow", "4 l/min", ": '4 l/min' is not allowed: a number, or a"),
        ("jackets.0.flow", {"value": 4, "low": 5}, "low 5, value 4, high 4 must ascend"),
        ("carriers.1.name", "head", ": the name head stands twice"),
        ("effects", {"radiaton": {}}, ".radiaton: 'radiaton' is not one of"),
    ],
)
def test_refusals(key, value, problem):
    """A problem that begins with a point or a colon goes on from the key, told by names."""
    page = changed(small_page(), key, value)
    if problem[0] in ".:":
        more, colon, what = problem.partition(":")
        problem = counted_from_one(named_place(key, page) + more) + colon + what
    assert problem in refusal(page)


def test_a_place_is_told_by_the_name_of_a_part():
    page = changed(small_page(), "bearings.1.at", -30)
    assert refusal(page).startswith("bearings.rear.at: ")
    assert named_place("shaft.stretches.0.outer", page) == "shaft.stretches.0.outer"


def test_faces_may_touch():
    faces = [SIDED, SIDED | {"side": 330}, SIDED | {"from": 60, "to": 80}]
    assert machine_of(changed(small_page(), "housing.faces", faces))


def test_a_stretch_without_material_in_a_page_of_its_own_material():
    page = changed(small_page(), "shaft.material", "ours")
    page["materials"] = {
        "ours": {"density": 7800, "specific_heat": 460, "conductivity": 30, "expansion": 11.0}
    }
    assert "ours_conductivity" in machine_of(page).numbers
    page["materials"]["ours"]["density"] = 7.8
    assert refusal(page).startswith("materials.ours.density: 7.8 is not allowed: 100 to 25000")
