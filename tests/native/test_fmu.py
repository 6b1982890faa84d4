"""The C FMU as a host meets it: beside the Python FMU of the same compensator file."""

import io
import json
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree as ET

import fmpy
import pytest

import build_fmu
from fmu_packaging.description import CAPABILITIES
from fmu_packaging.native.build import native_package
from fmu_packaging.native.compilers import compilers
from measurement.errors import BadInput
from scenarios.building import native_of
from scenarios.fmu import Slave
from scenarios.fmu_file import FmuFile
from tests.fmu_packaging.apart import apart, variables_of
from tests.fmu_packaging.test_slave import LIFE
from tests.fmus.models import RUN, five_point_text
from tests.running import output_of


@pytest.fixture
def both(by_hand: Path) -> SimpleNamespace:
    """The FMU in C, the one in Python, and the compensator file of both."""
    return SimpleNamespace(
        native=by_hand / "compensator_native.fmu",
        python=by_hand / "compensator.fmu",
        model=by_hand / "by_hand.json",
    )


def test_the_variables_are_those_of_the_python_fmu(both):
    found, expected = variables_of(both.native), variables_of(both.python)
    assert found[-1]["name"] == "model_file"
    for one in [*found, *expected]:
        if one["causality"] == "parameter":
            del one["description"]
    assert found == expected
    native, python = (
        [unit.name for unit in fmpy.read_model_description(str(path)).unitDefinitions]
        for path in (both.native, both.python)
    )
    assert native == python


def test_the_flags_are_those_of_the_python_fmu_but_no_tool_is_needed(both):
    flags = fmpy.read_model_description(str(both.native)).coSimulation
    assert not flags.needsExecutionTool
    for name, value in CAPABILITIES.items():
        if hasattr(flags, name):
            assert str(getattr(flags, name)).lower() == value, name


def test_a_run_gives_the_numbers_and_words_of_the_python_fmu(both):
    code = "show(steps(started(opened(sys.argv[1])), 0, 200))"
    found, expected = (apart(RUN + code, path) for path in (both.native, both.python))
    assert {row[9] for row in expected} >= {0, 11, 12, 21}
    for one, other in zip(found, expected, strict=True):
        assert one[9:] == other[9:]
        assert one[:9] == pytest.approx(other[:9], rel=1e-12, abs=1e-12)


def test_what_cannot_be_done_is_refused_with_a_cause_and_the_host_lives(both):
    found = apart(
        RUN
        + """
fmu = opened(sys.argv[1])
refs = fmu.refs
said = [status_of(fmu.doStep, 0.0, 1.0), status_of(fmu.getReal, [999]),
        status_of(fmu.setReal, [refs["dX"]], [1.0]), status_of(fmu.getReal, [refs["status"]])]
fmu.setString([refs["model_file"]], ["other.json"])
fmu.enterInitializationMode()
said.append(status_of(fmu.exitInitializationMode))
fmu.setString([refs["model_file"]], [""])
said.append(status_of(fmu.exitInitializationMode))
said += [status_of(fmu.setString, [refs["model_file"]], ["x"]),
         status_of(fmu.doStep, 0.0, 0.0), status_of(fmu.doStep, 0.0, math.nan)]
data = bytearray(fmu.serializeFMUstate(fmu.getFMUstate()))
data[300] ^= 1
said.append(status_of(fmu.deSerializeFMUstate, bytes(data)))
said.append(status_of(fmu.deSerializeFMUstate, bytes(data[:100])))
steps(fmu, 0, 10)
show([said, [m[1] for m in messages]])
""",
        both.native,
    )
    statuses, messages = found
    assert statuses == [3, 3, 3, 3, 3, 0, 3, 2, 2, 3, 3]
    words = (
        "before the end of the initialisation",
        "value reference 999: there is no such variable",
        "dX: what the FMU computes cannot be set",
        "status: there is no such variable of this type",
        "model_file: this FMU has its compensator file compiled in",
        "a parameter cannot be set after the start",
        "above 0 s",
        "above 0 s",
        "damaged",
        "another size",
    )
    for said, word in zip(messages, words, strict=True):
        assert word in said


def test_a_host_that_keeps_no_order_is_refused(both):
    assert apart(LIFE, both.native) == [["single precision"], True]


def test_only_the_categories_asked_for_are_logged(both):
    """Those declared are those there are."""
    declared = fmpy.read_model_description(str(both.native)).logCategories
    found = apart(
        """
import json
fmu = started(opened(sys.argv[1]))
seen = []
for categories in (*json.loads(sys.argv[2]), None):
    chosen = [] if categories is None else [categories]
    fmu.setDebugLogging(True, chosen)
    messages.clear()
    status_of(fmu.doStep, 0.0, 0.0)
    status_of(fmu.getReal, [999])
    seen.append([m[0] for m in messages])
fmu.setDebugLogging(False, [])
messages.clear()
status_of(fmu.getReal, [999])
show([seen, messages, status_of(fmu.setDebugLogging, True, ["logAll"])])
""",
        both.native,
        json.dumps([category.name for category in declared]),
    )
    assert found == [[[2], [3], [2, 3]], [], 3]


def test_a_refusal_says_why_without_debug_logging(both):
    """As most hosts run an FMU: otherwise all that they can show is that it failed."""
    found = apart(
        """
fmu = opened(sys.argv[1])
again = type(fmu)(guid=fmu.guid, unzipDirectory=fmu.unzipDirectory,
                  modelIdentifier=fmu.modelIdentifier, instanceName="quiet")
again.instantiate(callbacks=callbacks, loggingOn=False)
again.setupExperiment(startTime=0.0)
show([status_of(again.getReal, [999]), messages])
""",
        both.native,
    )
    assert found == [3, [[3, "value reference 999: there is no such variable of this type"]]]


def test_only_an_fmu_in_python_needs_a_plain_folder(both, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "ü"))
    (tmp_path / "ü").mkdir()
    with pytest.raises(BadInput, match=r"set TMPDIR to .* or use FMUs in C"):
        FmuFile(both.python)
    with Slave(both.native, "compensator", print, io.StringIO()) as slave:
        with slave.starting(10.0):
            pass
        slave.step(0.0, 10.0)


def test_a_code_has_a_type_that_says_what_it_means(both):
    for path in (both.native, both.python):
        status = next(
            variable
            for variable in fmpy.read_model_description(str(path)).modelVariables
            if variable.name == "status"
        )
        assert status.declaredType.name == "Status"
        with zipfile.ZipFile(path) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
        said = root.find("TypeDefinitions/SimpleType[@name='Status']")
        assert "1: waiting for the first valid sample" in str(said.get("description"))


def test_a_state_of_another_model_is_refused(both, tmp_path):
    model, other = tmp_path / "other.json", tmp_path / "other.fmu"
    model.write_text(five_point_text(gain=2.0))
    recipe, _ = build_fmu.compensator_recipe(model, "compensator_native", True)
    other.write_bytes(native_package(recipe, native_of(recipe, model), compilers()[:1]).zipped())
    found = apart(
        """
one, two = (started(opened(path)) for path in sys.argv[1:])
data = one.serializeFMUstate(one.getFMUstate())
show([status_of(two.deSerializeFMUstate, data), messages[-1][1]])
""",
        both.native,
        other,
    )
    assert found == [3, "the state belongs to another FMU"]


@pytest.mark.long
def test_builds_in_two_processes_give_the_same_bytes(both, every_compiler, tmp_path):
    """On all platforms that there is a compiler for; nothing is remembered between them."""
    arguments = ["--native", "--only", "compensator", "--model", str(both.model), "--json"]
    for name in ("one", "other"):
        command = [sys.executable, build_fmu.__file__, *arguments, "--out", str(tmp_path / name)]
        assert json.loads(output_of(*command))[0]["written"]
    one, other = (tmp_path / name / both.native.name for name in ("one", "other"))
    assert one.read_bytes() == other.read_bytes()
    code = RUN + "show(steps(started(opened(sys.argv[1])), 0, 200))"
    assert apart(code, one) == apart(code, both.native)  # which is compiled quickly
    with zipfile.ZipFile(one) as archive:
        platforms = {name.split("/")[1] for name in archive.namelist() if "binaries/" in name}
    assert platforms == {compiler.platform for compiler in compilers()}


@pytest.mark.long
@pytest.mark.parametrize("version", [2, 3])
def test_fmpy_compiles_the_sources_into_the_same_numbers(by_hand, version, tmp_path):
    built = by_hand / f"compensator_native{'_fmi3' if version == 3 else ''}.fmu"
    path = tmp_path / built.name
    with zipfile.ZipFile(built) as given, zipfile.ZipFile(path, "w") as bare:
        for name in given.namelist():
            if not name.startswith("binaries/"):
                bare.writestr(name, given.read(name))
    output_of(sys.executable, "-m", "fmpy", "compile", path, folder=tmp_path)
    with zipfile.ZipFile(path) as archive:
        ending = fmpy.sharedLibraryExtension
        library = next(name for name in archive.namelist() if name.endswith(ending))
        archive.extract(library, tmp_path)
    listed = output_of("nm", "-D", "--defined-only", tmp_path / library)
    shown = [line.split()[-1] for line in listed.splitlines()]
    assert f"fmi{version}DoStep" in shown
    assert [name for name in shown if not name.startswith(f"fmi{version}")] == []
    code = "show(steps(started(opened(sys.argv[1])), 0, 60))"
    assert apart(RUN + code, path) == apart(RUN + code, built)


def test_without_a_compiler_one_line_says_so(both, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert shutil.which("gcc") is None
    arguments = ["--only", "compensator", "--model", str(both.model), "--out", str(tmp_path)]
    assert build_fmu.main(["--native", *arguments]) == 2
    said = capsys.readouterr().err
    assert said == "--native: no C compiler: of gcc, clang, cc none can be found\n"
    assert list(tmp_path.iterdir()) == []
