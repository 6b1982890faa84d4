"""The FMI 3.0 form of the C FMU beside its FMI 2.0 form."""

import zipfile
from xml.etree import ElementTree as ET

import fmpy

from tests.fmu_packaging.apart import apart
from tests.fmus.models import RUN


def test_variables_keep_their_value_references_and_the_time_comes_last(by_hand):
    two, three = (
        fmpy.read_model_description(str(by_hand / name)).modelVariables
        for name in ("compensator_native.fmu", "compensator_native_fmi3.fmu")
    )
    names = ("name", "valueReference", "causality", "variability", "unit", "min", "max", "nominal")
    names += ("description", "start")
    facts = [[[getattr(one, name) for name in names] for one in listed] for listed in (two, three)]
    assert facts[1][:-1] == facts[0]
    assert three[-1].causality == "independent"


def test_a_run_is_that_of_the_other_form(by_hand):
    code = """
fmu = started(opened(sys.argv[1]))
rows = steps(fmu, 0, 200)
assert fmu.two or fmu.getFloat64([fmu.refs["time"]]) == [200.0]
show(rows)
"""
    names = ("compensator_native.fmu", "compensator_native_fmi3.fmu")
    expected, found = (apart(RUN + code, by_hand / name) for name in names)
    assert found == expected


def test_what_cannot_be_done_is_status_of(by_hand):
    found = apart(
        """
fmu = started(opened(sys.argv[1]))
data = bytearray(fmu.serializeFMUState(fmu.getFMUState()))
data[300] ^= 1
show([status_of(fmu.getFloat64, [999]), status_of(fmu.setFloat64, [fmu.refs["dX"]], [1.0]),
      status_of(fmu.getFloat32, [0]), status_of(fmu.doStep, 0.0, 0.0),
      status_of(fmu.deserializeFMUState, bytes(data)), status_of(fmu.doStep, 0.0, 1.0),
      status_of(fmu.fmi3GetNumberOfVariableDependencies, fmu.component, 0, None),
      len(messages)])
""",
        by_hand / "compensator_native_fmi3.fmu",
    )
    assert found == [3, 3, 3, 2, 3, 0, 3, 6]


def test_the_sources_say_how_they_are_compiled(by_hand):
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
