"""`spindle-drift ssp`: what is in the file; tests/masters runs it in other tools."""

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu
from fmpy.ssp.ssd import Component, SystemStructureDescription, read_ssd
from fmpy.validation import validate_fmu

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


@pytest.fixture
def pack(tiny_scenario: Path, tiny_folder: Path, tmp_path: Path) -> Callable[..., Path]:
    """Runs the command and returns its file."""

    def made(*options: str, name: str = "a.ssp") -> Path:
        out = tmp_path / name
        argv = ["ssp", str(tiny_scenario), "--fmu-dir", str(tiny_folder), "-o", str(out)]
        assert main([*argv, *options]) == 0
        return out

    return made


@pytest.fixture
def packed(pack: Callable[..., Path]) -> Callable[..., SystemStructureDescription]:
    """The same, and reads the file with fmpy, which checks it against the SSP schema."""
    return lambda *options: read_ssd(str(pack(*options)))


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
            found |= {entry.name: float(entry.value) for entry in values.parameters}
    return found


def test_equal_names_are_connected(packed):
    ssd = packed()
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


def test_the_file_holds_the_fmus_as_they_are(pack, tiny_folder):
    first, second = pack(), pack(name="b.ssp")
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        for name in ("plant", "compensator"):
            data = archive.read(f"resources/{name}.fmu")
            assert data == (tiny_folder / f"{name}.fmu").read_bytes()
        text = archive.read("SystemStructure.ssd").decode()
    assert '<ssd:DefaultExperiment startTime="0.0" stopTime="20.0">' in text
    assert '<osp:FixedStepAlgorithm baseStepSize="1.0" />' in text


def test_the_signals_fmu_validates_and_plays_the_scenario(pack, tmp_path):
    with zipfile.ZipFile(pack()) as archive:
        archive.extract("resources/signals.fmu", tmp_path)
    plays_the_scenario(tmp_path / "resources" / "signals.fmu")


def test_the_signals_fmu_in_c_does_the_same(tiny_scenario, tiny_plant, c_compiler, tmp_path):
    (case,) = read_scenario(tiny_scenario, [("compensator.enabled", False)]).cases
    data = ssp_bytes(case, tiny_plant, None, [c_compiler])
    assert data == ssp_bytes(case, tiny_plant, None, [c_compiler])
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


def test_version_2_is_valid_by_its_schema(pack):
    with zipfile.ZipFile(pack("--ssp", "2", "--set", "plant.parameters.gain=0.5")) as archive:
        text = archive.read("SystemStructure.ssd").decode()
    assert text.count('version="2.0"') == 2
    import xmlschema
    from pyssp_standard.standard import ModelicaStandard

    schemas = ModelicaStandard.schemas
    xmlschema.validate(text, str(schemas["ssd2"]))
    table = ElementTree.fromstring(text).find(f".//{{{NAMESPACES['ssv']}}}ParameterSet")
    xmlschema.validate(table, str(schemas["ssv2"]))
    with pytest.raises(xmlschema.XMLSchemaException):
        xmlschema.validate(text, str(schemas["ssd"]))


def test_parameters_and_the_seed_are_start_values(packed):
    ssd = packed("--set", "plant.parameters.gain=0.5", "--set", "seed=7")
    assert starts(ssd, "plant") == {"gain": 0.5, "noise_seed": 7.0}
    ssd = packed("--set", "plant.noise=false")
    assert starts(ssd, "plant")["noise_seed"] == 0.0


def test_a_blind_compensator_is_told_a_constant(packed):
    ssd = packed("--set", "compensator.tool_length_mm=30.0")
    told = {wire for wire in wires(ssd) if wire.startswith("signals.tool_length")}
    assert told == {"signals.tool_length>plant.tool_length"}
    assert starts(ssd, "compensator") == {"tool_length": 30.0}


def test_without_a_compensator_only_the_signals_are_connected(packed):
    ssd = packed("--set", "compensator.enabled=false")
    assert {element.name for element in ssd.system.elements} == {"plant", "signals"}
    assert wires(ssd) == {"signals.speed>plant.speed", "signals.tool_length>plant.tool_length"}


def test_only_changes_are_kept_with_every_digit():
    time_s = np.arange(5.0)
    values = np.array([0.1, 0.1, 1 / 3, 1 / 3, 0.1])
    steady = np.full(5, 2.0)
    found = pd.read_csv(io.StringIO(table_text(time_s, {"a_1": values, "b_mm": steady})))
    assert found["time_s"].tolist() == [0.0, 2.0, 4.0]
    assert found["a_1"].tolist() == [0.1, 1 / 3, 0.1]


def test_a_blind_compensator_without_the_signal_is_refused(tiny_scenario, tiny_plant, tmp_path):
    source = COMPENSATOR.replace(', ("tool_length", "mm")]', "]")
    other = build_tiny(source, "ShortCompensator", tmp_path)
    override = [("compensator.tool_length_mm", 30.0)]
    (case,) = read_scenario(tiny_scenario, override).cases
    with pytest.raises(BadInput, match="there is no signal tool_length"):
        ssp_bytes(case, tiny_plant, other)
