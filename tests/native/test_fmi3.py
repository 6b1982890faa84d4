"""The FMI 3.0 form of the C FMU beside its FMI 2.0 form."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

import build_fmu
from tests.fmu_packaging.apart import apart
from tests.fmus.models import five_point_text
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
               if v.causality == "input" and v.type == "Float64"]
    return fmu
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both forms of one compensator."""
    folder = tmp_path_factory.mktemp("dist")
    model = folder / "by_hand.json"
    model.write_text(five_point_text())
    for fmi in ("2", "3"):
        arguments = [
            "--native",
            "--only",
            "compensator",
            "--fmi",
            fmi,
            "--model",
            str(model),
            "--out",
            str(folder),
        ]
        assert build_fmu.main(arguments) == 0
    return folder


def test_validation_is_clean(folder: Path) -> None:
    assert validate_fmu(str(folder / "compensator_native_fmi3.fmu")) == []


def test_variables_keep_their_value_references_and_the_time_comes_last(folder: Path) -> None:
    two, three = (
        fmpy.read_model_description(str(folder / name)).modelVariables
        for name in ("compensator_native.fmu", "compensator_native_fmi3.fmu")
    )
    names = ("name", "valueReference", "causality", "variability", "unit", "min", "max", "nominal")
    names += ("description", "start")
    facts = [[[getattr(one, name) for name in names] for one in listed] for listed in (two, three)]
    assert facts[1][:-1] == facts[0]
    assert three[-1].causality == "independent"


def test_a_run_and_a_state_are_those_of_the_other_form(folder: Path) -> None:
    expected = apart(
        RUN + "show(steps(started(opened(sys.argv[1])), 0, 200))",
        folder / "compensator_native.fmu",
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
        folder / "compensator_native_fmi3.fmu",
    )
    assert found == expected


def test_what_cannot_be_done_is_refused(folder: Path) -> None:
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
        folder / "compensator_native_fmi3.fmu",
    )
    assert found == [3, 3, 3, 2, 3, 0]


@pytest.mark.long
def test_fmpy_compiles_the_sources_into_the_same_numbers(folder: Path, tmp_path: Path) -> None:
    built, path = folder / "compensator_native_fmi3.fmu", tmp_path / "bare.fmu"
    with zipfile.ZipFile(built) as given, zipfile.ZipFile(path, "w") as bare:
        for name in given.namelist():
            if not name.startswith("binaries/"):
                bare.writestr(name, given.read(name))
    command = [sys.executable, "-m", "fmpy", "compile", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    code = OPENED3 + RUN3 + "show(steps(opened3(sys.argv[1]), 0, 60))"
    assert apart(code, path) == apart(code, built)


def test_the_python_fmu_has_no_fmi_3(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        build_fmu.main(["--fmi", "3"])
    assert ended.value.code == 2
    assert "--fmi: only the FMUs without Python" in capsys.readouterr().err
