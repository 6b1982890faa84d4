"""The FMI 3.0 form of the C FMU beside its FMI 2.0 form."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import pytest

from tests.fmu_packaging.apart import apart
from tests.native.test_fmu import RUN

# The same steps in both; only the names of the functions differ.
RUN3 = RUN.replace("getReal", "getFloat64").replace("setReal", "setFloat64")
RUN3 = RUN3.replace("getInteger", "getInt32").replace(".decode()", "")
OPENED3 = """
from fmpy.fmi3 import FMU3Slave

def opened3(path):
    description = fmpy.read_model_description(path)
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                    modelIdentifier=description.coSimulation.modelIdentifier, instanceName="one")
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.refs = {v.name: v.valueReference for v in description.modelVariables}
    fmu.outs = [v.valueReference for v in description.modelVariables
                if v.causality == "output" and v.type == "Float64"]
    fmu.ins = [v.valueReference for v in description.modelVariables
               if v.causality == "input" and v.type == "Float64" and "measured" not in v.name]
    return fmu
"""


def test_variables_keep_their_value_references_and_the_time_comes_last(by_hand: Path) -> None:
    two, three = (
        fmpy.read_model_description(str(by_hand / name)).modelVariables
        for name in ("compensator_native.fmu", "compensator_native_fmi3.fmu")
    )
    names = ("name", "valueReference", "causality", "variability", "unit", "min", "max", "nominal")
    names += ("description", "start")
    facts = [[[getattr(one, name) for name in names] for one in listed] for listed in (two, three)]
    assert facts[1][:-1] == facts[0]
    assert three[-1].causality == "independent"


def test_a_run_and_a_state_are_those_of_the_other_form(by_hand: Path) -> None:
    expected = apart(
        RUN + "show(steps(started(opened(sys.argv[1])), 0, 200))",
        by_hand / "compensator_native.fmu",
    )
    found = apart(
        OPENED3
        + RUN3
        + """
fmu = opened3(sys.argv[1])
rows = steps(fmu, 0, 60)
data = fmu.serializeFMUState(fmu.getFMUState())
other = opened3(sys.argv[1])
other.setFMUState(other.deserializeFMUState(data))
assert other.getFloat64([other.refs["time"]]) == [60.0]
show(rows + steps(other, 60, 140))
""",
        by_hand / "compensator_native_fmi3.fmu",
    )
    assert found == expected


def test_what_cannot_be_done_is_refused(by_hand: Path) -> None:
    found = apart(
        OPENED3
        + RUN3
        + """
from fmpy.fmi1 import FMICallException as Refused
def refused(call, *args):
    try:
        call(*args)
    except Refused as error:
        return error.status
    return 0
fmu = opened3(sys.argv[1])
data = bytearray(fmu.serializeFMUState(fmu.getFMUState()))
data[300] ^= 1
show([refused(fmu.getFloat64, [999]), refused(fmu.setFloat64, [fmu.refs["dX"]], [1.0]),
      refused(fmu.getFloat32, [0]), refused(fmu.doStep, 0.0, 0.0),
      refused(fmu.deserializeFMUState, bytes(data)), refused(fmu.doStep, 0.0, 1.0)])
""",
        by_hand / "compensator_native_fmi3.fmu",
    )
    assert found == [3, 3, 3, 2, 3, 0]


def test_the_sources_say_how_they_are_compiled(by_hand: Path) -> None:
    with zipfile.ZipFile(by_hand / "compensator_native_fmi3.fmu") as archive:
        text = archive.read("sources/buildDescription.xml").decode()
        terminals = ET.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        notice = archive.read("documentation/licenses/fmi_headers.txt").decode()
        assert "documentation/licenses/license.txt" in archive.namelist()
    assert 'compilerOptions="-ffp-contract=off"' in text
    assert '<Library name="m" external="true" />' in text
    assert notice.startswith("Copyright (C) 2011 MODELISAR")
    assert "in binary form must reproduce" in notice
    named = {
        terminal.get("name"): [member.get("variableName") for member in terminal]
        for terminal in terminals.iter("Terminal")
    }
    assert named["spindle"] == ["speed", "tool_length"]
    assert named["offsets"] == ["dX", "dY", "dZ"]


@pytest.mark.long
def test_fmpy_compiles_the_sources_into_the_same_numbers(by_hand: Path, tmp_path: Path) -> None:
    built, path = by_hand / "compensator_native_fmi3.fmu", tmp_path / "bare.fmu"
    with zipfile.ZipFile(built) as given, zipfile.ZipFile(path, "w") as bare:
        for name in given.namelist():
            if not name.startswith("binaries/"):
                bare.writestr(name, given.read(name))
    command = [sys.executable, "-m", "fmpy", "compile", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    code = OPENED3 + RUN3 + "show(steps(opened3(sys.argv[1]), 0, 60))"
    assert apart(code, path) == apart(code, built)
