"""Temperatures as one array beside a variable each: the same numbers."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET
from zipfile import ZipFile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import build_fmu
from tests.fmu_packaging.apart import apart

pytestmark = pytest.mark.long
NAMES = [f"T{number}" for number in range(1, 12)]
ROLES = ("plant", "compensator")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("arrays")
    assert build_fmu.main(["--fmi", "3", "--arrays", "--out", str(folder)]) == 0
    return folder


LOOP = """
plant, compensator = (started(opened(path)) for path in sys.argv[1:3])
names, offsets = json.loads(sys.argv[3]), ["dX", "dY", "dZ"]
refs = lambda fmu, *names: [fmu.refs[name] for name in names]
rows = []
for k in range(360):
    readings = list(plant.get(refs(plant, *names), *([] if plant.two else [11])))
    # Beside the array, in one call with it.
    compensator.put(refs(compensator, *names, "speed"), [*readings, 6000.0])
    compensator.doStep(10.0 * k, 10.0)
    moved = list(compensator.get(refs(compensator, *offsets)))
    plant.put(refs(plant, *offsets, "speed"), [*moved, 6000.0])
    plant.doStep(10.0 * k, 10.0)
    rows.append([*readings, *moved, *plant.get(refs(plant, "error_X", "error_Z"))])
show(rows)
"""


def test_numbers_are_those_of_a_variable_each(folder, shipped_in_c):
    found, wanted = (
        apart(LOOP, *(place / f"{role}_{form}.fmu" for role in ROLES), json.dumps(names))
        for place, form, names in (
            (folder, "native_fmi3_arrays", ["temperatures"]),
            (shipped_in_c, "native", NAMES),
        )
    )
    assert found == wanted
    assert max(map(abs, found[-1][11:14])) > 1.0


DERIVATIVES = """
three, two = (started(opened(path, exchange=True)) for path in sys.argv[1:3])
variables = fmpy.read_model_description(sys.argv[2]).modelVariables
knowns = [v.derivative.name for v in variables if v.derivative]
knowns += [v.name for v in variables if v.causality == "input"]
each = ["drift_X", *json.loads(sys.argv[3]), "drift_Z"]
some = ["drift_X", "temperatures", "drift_Z"]
seeds = [1.0 + place for place in range(len(knowns))]
weights = [2.0 - place for place in range(len(each))]
refs = lambda fmu, names: [fmu.refs[name] for name in names]
wanted = two.getDirectionalDerivative(refs(two, each), refs(two, knowns), seeds)
sides = refs(three, some), refs(three, knowns)
show([list(wanted), three.getDirectionalDerivative(*sides, seeds, len(each)),
      three.getAdjointDerivative(*sides, weights, len(knowns)), seeds, weights])
"""


def test_derivatives_of_the_array_are_those_of_its_elements(folder, shipped_in_c):
    fmus = (folder / "plant_native_fmi3_arrays.fmu", shipped_in_c / "plant_native.fmu")
    wanted, found, back, seeds, weights = apart(DERIVATIVES, *fmus, json.dumps(NAMES))
    assert found == wanted
    assert np.count_nonzero(found) > 5
    assert np.dot(back, seeds) == pytest.approx(np.dot(weights, found), rel=1e-9)


@pytest.mark.parametrize("name", ROLES)
def test_the_description_has_one_variable(name, folder):
    path = folder / f"{name}_native_fmi3_arrays.fmu"
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    known = {variable.name: variable for variable in description.modelVariables}
    array = known["temperatures"]
    assert not set(NAMES) & set(known)
    assert array.shape == (11,)
    assert ", ".join(NAMES) in array.description
    assert (array.unit, float(array.min), float(array.max)) == ("degC", -60.0, 400.0)
    if name == "compensator":
        assert array.start.split() == ["20"] * 11
        depends = {v.variable.name: v.dependencies for v in description.outputs}
        assert depends["dZ"] == [array, known["tool_length"]]
    with ZipFile(path) as archive:
        icons = ET.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    terminal = next(t for t in icons.iter("Terminal") if t.get("name") == "temperatures")
    assert [member.get("variableName") for member in terminal] == ["temperatures"]


FEW = """
fmu = started(opened(sys.argv[1]))
array, speed = fmu.refs["temperatures"], fmu.refs["speed"]
said = [status_of(fmu.setFloat64, refs, [30.0] * count)
        for refs, count in (([array], 1), ([array, speed], 11), ([speed], 2))]
show([said, list(fmu.getFloat64([array, speed], 12))])
"""


def test_too_few_numbers_are_refused_and_none_is_set(folder):
    said, kept = apart(FEW, folder / "compensator_native_fmi3_arrays.fmu")
    assert said == [3, 3, 3]
    assert kept == [20.0] * 11 + [0.0]
