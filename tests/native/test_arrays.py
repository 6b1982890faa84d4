"""Temperatures as one array beside a variable each: the same numbers."""

import ctypes
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET
from zipfile import ZipFile

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu

import build_fmu
from tests.fmus.models import five_point_text

pytestmark = pytest.mark.long
NAMES = [f"T{number}" for number in range(1, 12)]
OFFSETS = ("dX", "dY", "dZ")
STEP_S = 10.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("arrays")
    assert build_fmu.main(["--fmi", "3", "--arrays", "--out", str(folder)]) == 0
    return folder


class Fmu:
    """An FMU in either version of FMI, by the names of its numbers."""

    def __init__(self, path: Path, folder: Path, *, exchange: bool = False) -> None:
        self.description = fmpy.read_model_description(str(path))
        self.refs = {v.name: v.valueReference for v in self.description.modelVariables}
        self.three = self.description.fmiVersion == "3.0"
        kinds: Any = (FMU3Slave, FMU3Model) if self.three else (FMU2Slave, FMU2Model)
        self.fmu = kinds[exchange](
            guid=self.description.guid,
            unzipDirectory=fmpy.extract(str(path), str(folder)),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.fmu.instantiate()
        if not self.three:
            self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def get(self, names: Sequence[str], count: int = 0) -> list[float]:
        refs = [self.refs[name] for name in names]
        found = self.fmu.getFloat64(refs, count or None) if self.three else self.fmu.getReal(refs)
        return list(found)

    def put(self, names: Sequence[str], values: Sequence[float]) -> None:
        refs = [self.refs[name] for name in names]
        (self.fmu.setFloat64 if self.three else self.fmu.setReal)(refs, list(values))


def loop(plant: Fmu, compensator: Fmu, names: Sequence[str]) -> list[list[float]]:
    """An hour of both, with the temperatures under these names; returns what they compute."""
    rows = []
    for step in range(360):
        readings = plant.get(names, len(NAMES))
        # Beside the array, in one call with it.
        compensator.put([*names, "speed"], [*readings, 6000.0])
        compensator.fmu.doStep(step * STEP_S, STEP_S)
        offsets = compensator.get(OFFSETS)
        plant.put([*OFFSETS, "speed"], [*offsets, 6000.0])
        plant.fmu.doStep(step * STEP_S, STEP_S)
        rows.append([*readings, *offsets, *plant.get(["error_X", "error_Z"])])
    return rows


def test_numbers_are_those_of_a_variable_each(folder, shipped_in_c, tmp_path):
    found, wanted = (
        loop(
            Fmu(place / f"plant_{form}.fmu", tmp_path / f"plant_{form}"),
            Fmu(place / f"compensator_{form}.fmu", tmp_path / f"compensator_{form}"),
            names,
        )
        for place, form, names in (
            (folder, "native_fmi3_arrays", ["temperatures"]),
            (shipped_in_c, "native", NAMES),
        )
    )
    assert found == wanted
    assert max(map(abs, found[-1][11:14])) > 1.0


def test_derivatives_of_the_array_are_those_of_its_elements(folder, shipped_in_c, tmp_path):
    three = Fmu(folder / "plant_native_fmi3_arrays.fmu", tmp_path / "3", exchange=True)
    two = Fmu(shipped_in_c / "plant_native.fmu", tmp_path / "2", exchange=True)
    inputs = [v.name for v in two.description.modelVariables if v.causality == "input"]
    states = [v.derivative.name for v in two.description.modelVariables if v.derivative]
    knowns, outputs = [*states, *inputs], ["drift_X", *NAMES, "drift_Z"]
    seeds = [1.0 + place for place in range(len(knowns))]
    wanted = two.fmu.getDirectionalDerivative(
        [two.refs[n] for n in outputs], [two.refs[n] for n in knowns], seeds
    )

    def call(name: str, unknowns: Sequence[str], given: Sequence[float], count: int) -> list[float]:
        def refs(names: Sequence[str]) -> Any:
            return (ctypes.c_uint32 * len(names))(*(three.refs[n] for n in names))

        found = (ctypes.c_double * count)()
        row = (ctypes.c_double * len(given))(*given)
        sides = (refs(unknowns), len(unknowns), refs(knowns), len(knowns))
        getattr(three.fmu, name)(three.fmu.component, *sides, row, len(given), found, count)
        return list(found)

    some = ["drift_X", "temperatures", "drift_Z"]
    found = call("fmi3GetDirectionalDerivative", some, seeds, len(outputs))
    assert found == list(wanted)
    assert np.count_nonzero(found) > 5
    weights = [2.0 - place for place in range(len(outputs))]
    back = call("fmi3GetAdjointDerivative", some, weights, len(knowns))
    assert np.dot(back, seeds) == pytest.approx(np.dot(weights, found), rel=1e-9)


@pytest.mark.parametrize("name", ["compensator", "plant"])
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


def test_too_few_numbers_are_refused_and_none_is_set(folder, tmp_path):
    one = Fmu(folder / "compensator_native_fmi3_arrays.fmu", tmp_path)
    for names, count in ((["temperatures"], 1), (["temperatures", "speed"], 11), (["speed"], 2)):
        with pytest.raises(FMICallException):
            one.put(names, [30.0] * count)
    assert one.get(["temperatures", "speed"], 12) == [20.0] * 11 + [0.0]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "--arrays: add --fmi 3"),
        (["--native"], "--arrays: add --fmi 3"),
        (["--can", "--fmi", "3"], "--arrays: not with --can"),
    ],
)
def test_options_that_do_not_go_together_are_refused(options, said, capsys):
    assert build_fmu.main(["--arrays", *options]) == 2
    assert capsys.readouterr().err == f"{said}\n"


def test_another_variable_of_this_name_is_refused(tmp_path, capsys):
    model = tmp_path / "model.json"
    model.write_text(five_point_text().replace('"T3"', '"temperatures"'))
    options = ["--fmi", "3", "--arrays", "--only", "compensator", "--out", str(tmp_path)]
    assert build_fmu.main([*options, "--model", str(model)]) == 2
    assert capsys.readouterr().err == "--arrays: there is a variable temperatures already\n"
