"""Machine files: what ships reads, what is wrong is refused in one line."""

import copy
import json
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.errors import BadInput
from plant_model.machine import Machine
from plant_model.machine_file import (
    SHIPPED,
    machine_from_table,
    machine_path,
    read_machine,
    shipped_machines,
)
from plant_model.parameters import ParameterError
from tests.mangling import JUNK, mangled, places
from tests.refusing import refusal

TABLE = tomllib.loads((SHIPPED / "jig_borer_lumps.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", shipped_machines())
def test_shipped_machines_read_and_survive_json(name):
    machine = read_machine(name)
    assert Machine.from_dict(json.loads(json.dumps(machine.to_dict()))) == machine
    assert machine.parameters
    assert all(parameter.source for parameter in machine.parameters.values())


@pytest.mark.parametrize("name", ["jig_borer_lumps", "lathe"])
def test_references_are_used_and_known(name):
    machine = read_machine(name)
    used = {parameter.source for parameter in machine.parameters.values()}
    assert set(machine.references) <= used
    single_words = {source for source in used if " " not in source}
    assert single_words - {"definition"} <= set(machine.references)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("format", 2, "format: 2 is not allowed"),
        ("name", ..., "name: is missing"),
        ("colour", "red", "colour: is not a known field"),
        ("nodes.0.capacity.value", -1.0, "shaft_front.capacity.value: -1 is outside its range"),
        ("nodes.0.capacity.unit", "W/K", "'W/K' is not allowed: it is J/K"),
        ("nodes.0.capacity.low", float("nan"), "shaft_front.capacity.low: nan is not allowed"),
        ("nodes.0.capacity", 5.0, "nodes.shaft_front.capacity: 5 is not allowed"),
        ("nodes.0.start", "T99", "did you mean T9?"),
        ("nodes.0.start", "speed", "start: 'speed' is not one of ambient, coolant_inlet, T1, T2"),
        ("nodes.1.name", "shaft_front", "the name shaft_front stands twice"),
        ("links.0.between", ["shaft_front", "shaft_front"], "joins something to itself"),
        (
            "links.0.between",
            ["shaft_front", "shaft_midle"],
            "links.shaft_front-shaft_midle.between: ",
        ),
        ("links.0.between", ["shaft_front", "shaft_midle"], "did you mean shaft_middle?"),
        (
            "links.0.between",
            "shaft_front",
            "item 1, between: 'shaft_front' is not a list of 2",
        ),
        ("links.1.between", ["shaft_front", "shaft_middle"], "shaft_front-shaft_middle stands"),
        ("links.3.name", "", "links, item 4, name: '' is not a name"),
        ("sources.1.name", "front_bearing", "the name front_bearing stands twice"),
        ("links.0.kind", "conductoin", "did you mean conduction?"),
        ("links.0.kind", ..., "links.shaft_front-shaft_middle.kind: is missing"),
        ("links.0.conductance", ..., "links.shaft_front-shaft_middle.conductance: is missing"),
        ("links.0.speed", 3, "links.shaft_front-shaft_middle.speed: is not a known field"),
        ("links.0.conductance.low", 5.0, "the range 5..0.96 must ascend"),
        ("sources.0.driven_by", "sped", "did you mean speed?"),
        ("sources.0.driven_by", "ambient", "sources.front_bearing.driven_by: 'ambient' is not"),
        ("sources.0.f0.source", "", "f0"),
        ("sensors.0.of", "nowhere", "sensors.T1.of: 'nowhere' is not one of"),
        ("sensors.1.name", "T1", "the name T1 stands twice"),
        ("sensors.0.noise", "small", "sensors.T1.noise: 'small' is not allowed"),
        ("rig.kind", "six_point", "rig"),
        ("rig.axial_sign", 0, "mine.toml: rig.axial_sign: 0 is not allowed"),
        ("rig.spacing_mm", 0.0, "mine.toml: rig.spacing_mm: 0 is not allowed"),
        ("effects.air_gap", ..., "the effect air_gap is not in force"),
        ("effects.air_gapp", {}, "did you mean air_gap?"),
        ("effects.motor_loss", {"scael": {}}, "did you mean scale?"),
        ("inputs.speed", ..., "is not one of"),
        ("inputs.speed.column", "n_Hz", "does not end in _rpm"),
        ("inputs.torque.default", 900.0, "900 is outside -200..200 Nm"),
        ("inputs.speed.low", 1e9, "must be below high"),
        ("axis.slew_um_per_s", 0.0, "axis.slew_um_per_s: 0 is not allowed"),
    ],
)
def test_refusals_name_place_value_and_what_is_allowed(path, value, words):
    said = refusal(machine_from_table, mangled(TABLE, path, value), "mine.toml")
    assert said.startswith("mine.toml: ")
    assert words in said


def test_two_located_bearings_are_refused():
    table = copy.deepcopy(TABLE)
    located = next(item for item in table["structure"] if item["kind"] == "located")
    table["structure"].append(located | {"name": "rear_bearing"})
    assert "only one bearing can locate" in refusal(machine_from_table, table, "mine.toml")


@given(where=st.sampled_from(list(places(TABLE))), value=st.just(...) | JUNK)
def test_a_mangled_field_is_refused_or_read(where, value):
    table = mangled(TABLE, where, value)
    try:
        machine = machine_from_table(table, "mine.toml")
    except BadInput as error:
        message = str(error)
    else:
        message = ""
        assert isinstance(machine, Machine)
    assert "\n" not in message


@given(text=st.binary(max_size=200))
def test_any_bytes_are_refused_in_one_line(text, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "bytes.toml"
    path.write_bytes(text)
    assert refusal(read_machine, path)


def test_names_and_paths(tmp_path):
    assert machine_path("jig_borer_lumps") == SHIPPED / "jig_borer_lumps.toml"
    assert machine_path("jig_borer_lumps.toml") == SHIPPED / "jig_borer_lumps.toml"
    assert "did you mean jig_borer" in refusal(read_machine, "jig_boorer")
    assert "no such file" in refusal(read_machine, tmp_path / "none.toml")


def test_moving_values_is_checked(jig_borer_lumps):
    moved = jig_borer_lumps.with_values({"nodes.column.capacity": 460000.0})
    assert moved.parameters["nodes.column.capacity"].value == 460000.0
    assert jig_borer_lumps.parameters["nodes.column.capacity"].value == 450000.0
    with pytest.raises(ParameterError, match="outside"):
        jig_borer_lumps.with_values({"nodes.column.capacity": 1.0})
    with pytest.raises(ParameterError, match="no parameter"):
        jig_borer_lumps.with_values({"nodes.colum.capacity": 1.0})


@pytest.mark.parametrize("name", ["time", "speed", "dX", "error_Z", "noise_seed", "tool_length"])
def test_a_sensor_with_the_name_of_another_signal_is_refused(name, tmp_path):
    text = machine_path("jig_borer_lumps").read_text(encoding="utf-8")
    path = tmp_path / "machine.toml"
    path.write_text(text.replace('name = "T3"', f'name = "{name}"'), encoding="utf-8")
    said = f"sensors.{name}.name: '{name}' is not allowed: it is the name of an input, an output"
    assert said in refusal(read_machine, path)
    path.write_text(text.replace('near_y = "S2"', f'near_y = "{name}"'), encoding="utf-8")
    with pytest.raises(BadInput, match=f"rig: '{name}' is not allowed"):
        read_machine(path)
