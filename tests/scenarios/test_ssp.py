"""`spindle-drift ssp`: what is in the file; tests/masters runs it in other tools."""

import io
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pandas as pd
import pytest
import xmlschema
from fmpy import simulate_fmu
from fmpy.ssp.ssd import Component, SystemStructureDescription, read_ssd
from fmpy.validation import validate_fmu
from pyssp_standard.standard import ModelicaStandard

from measurement.errors import BadInput
from scenarios.cli import main
from scenarios.scenario import read_scenario
from scenarios.ssp.package import ssp_bytes
from scenarios.ssp.signals import table_text
from scenarios.ssp.structure import NAMESPACES
from tests.fmu_packaging.apart import apart
from tests.scenarios.tiny_fmus import COMPENSATOR, build_tiny

SINGLE_PRECISION = """
import numpy as np
fmu = started(opened(sys.argv[1]))
step = float(np.float32(0.1))
for k in range(100):
    time = float(np.float32(0.1 * k))
    fmu.doStep(time, step)
show([time + step, *fmu.get([fmu.refs["speed"]])])
"""
"""A clock whose hundredth step of 0.1 s ends short of 10 s."""


def packed(scenario: Path, folder: Path, out: Path, *more: str) -> SystemStructureDescription:
    """Run the command and read the file with fmpy, which checks it against the SSP schema."""
    assert main(["ssp", str(scenario), "--fmu-dir", str(folder), "-o", str(out), *more]) == 0
    return read_ssd(str(out))


def component(ssd: SystemStructureDescription, name: str) -> Component:
    (found,) = (element for element in ssd.system.elements if element.name == name)
    return found


def wires(ssd: SystemStructureDescription) -> set[str]:
    return {
        f"{entry.startElement}.{entry.startConnector}>{entry.endElement}.{entry.endConnector}"
        for entry in ssd.system.connections
    }


def starts(ssd: SystemStructureDescription, name: str) -> dict[str, float]:
    found = {}
    for binding in component(ssd, name).parameterBindings:
        for values in binding.parameterValues:
            found |= {entry.name: entry.value for entry in values.parameters}
    return found


def test_equal_names_are_connected(tiny_scenario, tiny_folder, tmp_path):
    ssd = packed(tiny_scenario, tiny_folder, tmp_path / "a.ssp")
    assert wires(ssd) == {
        "plant.T1>compensator.T1",
        *(f"compensator.d{axis}>plant.d{axis}" for axis in "XYZ"),
        *(f"signals.{name}>plant.{name}" for name in ("speed", "tool_length")),
        *(f"signals.{name}>compensator.{name}" for name in ("speed", "tool_length")),
    }
    assert {element.source for element in ssd.system.elements} == {
        f"resources/{name}.fmu" for name in ("plant", "compensator", "signals")
    }
    connectors = {entry.name for entry in component(ssd, "plant").connectors}
    assert {"speed", "error_X", "drift_Z"} <= connectors


def test_the_file_holds_the_fmus_as_they_are(tiny_scenario, tiny_folder, tmp_path):
    packed(tiny_scenario, tiny_folder, tmp_path / "a.ssp")
    packed(tiny_scenario, tiny_folder, tmp_path / "b.ssp")
    assert (tmp_path / "a.ssp").read_bytes() == (tmp_path / "b.ssp").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.ssp") as archive:
        for name in ("plant", "compensator"):
            data = archive.read(f"resources/{name}.fmu")
            assert data == (tiny_folder / f"{name}.fmu").read_bytes()
        text = archive.read("SystemStructure.ssd").decode()
    assert '<ssd:DefaultExperiment startTime="0.0" stopTime="20.0">' in text
    assert '<osp:FixedStepAlgorithm baseStepSize="1.0" />' in text


def test_the_signals_fmu_validates_and_plays_the_scenario(tiny_scenario, tiny_folder, tmp_path):
    packed(tiny_scenario, tiny_folder, tmp_path / "a.ssp")
    with zipfile.ZipFile(tmp_path / "a.ssp") as archive:
        archive.extract("resources/signals.fmu", tmp_path)
    plays_the_scenario(tmp_path / "resources" / "signals.fmu")


def test_the_signals_fmu_in_c_does_the_same(tiny_scenario, tiny_plant, c_compiler, tmp_path):
    made = [c_compiler]
    (case,) = read_scenario(tiny_scenario, [("compensator.enabled", False)]).cases
    data = ssp_bytes(case, tiny_plant, None, made)
    assert data == ssp_bytes(case, tiny_plant, None, made)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        fmu = Path(archive.extract("resources/signals.fmu", tmp_path))
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
    assert not [name for name in names if name.endswith(".py")]
    plays_the_scenario(fmu)
    late = simulate_fmu(str(fmu), start_time=10.0, stop_time=11.0, output_interval=1.0)
    assert set(late["speed"]) == {2000.0}


def plays_the_scenario(path: Path) -> None:
    """Check what plays the tiny scenario's signals."""
    fmu = str(path)
    assert validate_fmu(fmu) == []
    units = {
        variable.name: variable.unit for variable in fmpy.read_model_description(fmu).modelVariables
    }
    assert units == {"speed": "rpm", "tool_length": "mm"}
    # A step whose sum falls short of 10 s by rounding still reaches the value of 10 s.
    for step in (1.0, 0.1, 2.5):
        result = simulate_fmu(fmu, stop_time=20.0, output_interval=step)
        wanted = np.where(result["time"] < 10.0 - 1e-6, 1000.0, 2000.0)
        assert result["speed"].tolist() == wanted.tolist()
        assert set(result["tool_length"]) == {100.0}
    end, shown = apart(SINGLE_PRECISION, path)
    assert end < 10.0
    assert shown == 2000.0


def test_version_2_is_valid_by_its_schema(tiny_scenario, tiny_folder, tmp_path):
    out = tmp_path / "a.ssp"
    arguments = ["ssp", str(tiny_scenario), "--fmu-dir", str(tiny_folder), "-o", str(out)]
    assert main([*arguments, "--ssp", "2", "--set", "plant.parameters.gain=0.5"]) == 0
    with zipfile.ZipFile(out) as archive:
        text = archive.read("SystemStructure.ssd").decode()
    assert text.count('version="2.0"') == 2
    schemas = ModelicaStandard.schemas
    xmlschema.validate(text, str(schemas["ssd2"]))
    table = ElementTree.fromstring(text).find(f".//{{{NAMESPACES['ssv']}}}ParameterSet")
    xmlschema.validate(table, str(schemas["ssv2"]))
    with pytest.raises(xmlschema.XMLSchemaException):
        xmlschema.validate(text, str(schemas["ssd"]))


def test_parameters_and_the_seed_are_start_values(tiny_scenario, tiny_folder, tmp_path):
    out = tmp_path / "a.ssp"
    gain = ["--set", "plant.parameters.gain=0.5", "--set", "seed=7"]
    ssd = packed(tiny_scenario, tiny_folder, out, *gain)
    assert {key: float(value) for key, value in starts(ssd, "plant").items()} == {
        "gain": 0.5,
        "noise_seed": 7.0,
    }
    ssd = packed(tiny_scenario, tiny_folder, out, "--set", "plant.noise=false")
    assert float(starts(ssd, "plant")["noise_seed"]) == 0.0


def test_a_blind_compensator_is_told_a_constant(tiny_scenario, tiny_folder, tmp_path):
    override = ["--set", "compensator.tool_length_mm=30.0"]
    ssd = packed(tiny_scenario, tiny_folder, tmp_path / "a.ssp", *override)
    assert "signals.tool_length>compensator.tool_length" not in wires(ssd)
    assert "signals.tool_length>plant.tool_length" in wires(ssd)
    assert {key: float(value) for key, value in starts(ssd, "compensator").items()} == {
        "tool_length": 30.0
    }


def test_without_a_compensator_only_the_signals_are_connected(tiny_scenario, tiny_folder, tmp_path):
    ssd = packed(
        tiny_scenario, tiny_folder, tmp_path / "a.ssp", "--set", "compensator.enabled=false"
    )
    assert {element.name for element in ssd.system.elements} == {"plant", "signals"}
    assert wires(ssd) == {"signals.speed>plant.speed", "signals.tool_length>plant.tool_length"}


def test_only_changes_are_kept_with_every_digit():
    time_s = np.arange(5.0)
    values = np.array([0.1, 0.1, 1 / 3, 1 / 3, 0.1])
    steady = np.full(5, 2.0)
    found = pd.read_csv(io.StringIO(table_text(time_s, {"a_1": values, "b_mm": steady})))
    assert found["time_s"].tolist() == [0.0, 2.0, 4.0]
    assert found["a_1"].tolist() == [0.1, 1 / 3, 0.1]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            ["--set", 'faults=[{sensor="T1", kind="missing", start_s=5}]'],
            "faults: cannot be put into an .ssp",
        ),
        (["--set", "compensator.probe.every_s=60"], "compensator.probe: cannot be put into"),
        (["--variant", "nope"], "--variant: 'nope' is not one of main"),
        (["--set", "signals.speeed=1"], "signals.speeed: is not an input of the plant FMU"),
        (["--plant", "compensator.fmu"], "is no plant"),
        (["-o", "/"], "cannot be written"),
    ],
)
def test_what_cannot_be_packed_is_refused_in_one_line(
    tiny_scenario, tiny_folder, tmp_path, refused, more, message
):
    out = tmp_path / "a.ssp"
    arguments = ["ssp", str(tiny_scenario), "--fmu-dir", str(tiny_folder), "-o", str(out)]
    line = refused([*arguments, *more])
    assert message in line
    assert not out.exists()


def test_a_replay_is_refused(refused):
    assert "replay: has no plant to put into an .ssp" in refused(["ssp", "replay"])


def test_a_blind_compensator_without_the_signal_is_refused(tiny_scenario, tiny_plant, tmp_path):
    source = COMPENSATOR.replace(', ("tool_length", "mm")]', "]")
    other = build_tiny(source, "ShortCompensator", tmp_path)
    override = [("compensator.tool_length_mm", 30.0)]
    (case,) = read_scenario(tiny_scenario, override).cases
    with pytest.raises(BadInput, match="there is no signal tool_length"):
        ssp_bytes(case, tiny_plant, other)
