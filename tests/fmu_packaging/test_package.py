"""The package as files and bytes."""

import hashlib
import io
import os
import posixpath
import zipfile
from xml.etree import ElementTree as ET

import pytest

from fmu_packaging.package import Package, build
from fmu_packaging.publish import PublishError, Reference, publish
from tests.fmu_packaging.apart import apart
from tests.fmu_packaging.conftest import tiny_recipe


def _description(package: Package) -> ET.Element:
    return ET.fromstring(package.files["modelDescription.xml"])


def test_other_content_gives_another_guid_and_other_modules(tiny):
    other = build(tiny_recipe(2.0))
    assert other.guid != tiny.guid
    names = [package.files["resources/slavemodule.txt"] for package in (tiny, other)]
    assert names[0] != names[1]


def test_holds_what_users_expect(tiny):
    names = set(zipfile.ZipFile(io.BytesIO(tiny.zipped())).namelist())
    assert {
        "modelDescription.xml",
        "model.png",
        "binaries/linux64/tiny.so",
        "binaries/win64/tiny.dll",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "documentation/licenses/pythonfmu.txt",
    } <= names
    assert not any(name.startswith("resources/pythonfmu/") for name in names)
    assert b"MIT" in tiny.files["documentation/licenses/license.txt"]


def test_a_variable_has_what_fmi_wants_of_its_kind(tiny):
    variables = {v.get("name"): v for v in _description(tiny).iter("ScalarVariable")}
    assert variables["gain"][0].attrib == {"unit": "1", "min": "0", "max": "5", "start": "1"}
    assert variables["total"].get("initial") == "calculated"
    assert "start" not in variables["total"][0].attrib


def test_dependencies_are_what_the_slave_declares(tiny):
    root = _description(tiny)
    names = [v.get("name") for v in root.iter("ScalarVariable")]

    def listed(tag: str) -> dict[str, str | None]:
        group = root.find(f"ModelStructure/{tag}")
        return {str(names[int(str(u.get("index"))) - 1]): u.get("dependencies") for u in group}

    outputs = ["total", "count_out", "flag_out", "word_out"]
    assert listed("Outputs") == dict.fromkeys(outputs, "")
    assert listed("InitialUnknowns") == {
        "total": None,
        "count_out": None,
        "flag_out": str(names.index("flag") + 1),
        "word_out": "",
    }


def test_the_page_names_every_variable(tiny):
    page = tiny.files["documentation/index.html"].decode()
    for variable in tiny.slave.variables:
        assert f"<code>{variable.name}</code>" in page
        assert variable.description in page


REFERENCE = Reference({"u": lambda time_s: 1.0 + time_s}, 10.0, 1.0, 5.0)


def test_publishes_with_reference_results_and_only_once(tiny, tmp_path):
    path, written = publish(tiny, tmp_path, REFERENCE)
    assert written
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        "tiny.fmu",
        "tiny_in.csv",
        "tiny_ref.csv",
        "tiny_ref.opt",
    ]
    rows = (tmp_path / "tiny_ref.csv").read_text().splitlines()
    assert rows[0].startswith('"time","total"')
    # u = 1 + t, held over each step of 1 s: the sum over t = 0..9 of 1 + t is 55.
    assert rows[-1].split(",")[:2] == ["10.0", "55.0"]
    before = path.stat().st_mtime_ns
    assert publish(tiny, tmp_path, REFERENCE) == (path, False)
    assert path.stat().st_mtime_ns == before


def test_what_fails_leaves_the_old_one_in_place(tmp_path):
    (tmp_path / "tiny.fmu").write_bytes(b"the old one")
    broken = build(tiny_recipe())
    files = dict(broken.files)
    text = files["modelDescription.xml"].decode()
    files["modelDescription.xml"] = text.replace('name="count_out"', 'name="total"').encode()
    with pytest.raises(PublishError, match="not unique"):
        publish(Package(broken.name, broken.guid, files, broken.slave), tmp_path, REFERENCE)
    script = next(path for path in files if path.endswith("_slave.py") and path.count("/") == 1)
    files = dict(broken.files) | {script: b"import a_module_that_is_not_there\n"}
    with pytest.raises(PublishError, match="reference run failed"):
        publish(Package(broken.name, broken.guid, files, broken.slave), tmp_path, REFERENCE)
    files = dict(broken.files) | {script: b"import os\nos.kill(os.getpid(), 11)\n"}
    with pytest.raises(PublishError, match="the process crashed: Segmentation fault"):
        publish(Package(broken.name, broken.guid, files, broken.slave), tmp_path, REFERENCE)
    assert [entry.name for entry in tmp_path.iterdir()] == ["tiny.fmu"]
    assert (tmp_path / "tiny.fmu").read_bytes() == b"the old one"


def test_a_disk_that_is_full_changes_nothing_in_the_folder(tiny, tmp_path, monkeypatch):
    before = {
        entry.name: b"old" for entry in publish(tiny, tmp_path, REFERENCE)[0].parent.iterdir()
    }
    for name in before:
        (tmp_path / name).write_bytes(b"old")
    sync, count = os.fsync, []

    def full(handle: int) -> None:
        count.append(handle)
        if len(count) == 3:
            raise OSError(28, "No space left on device")
        sync(handle)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(PublishError, match="cannot be written: No space left on device"):
        publish(tiny, tmp_path, REFERENCE)
    assert {entry.name: entry.read_bytes() for entry in tmp_path.iterdir()} == before


DEVIATION = """
from fmpy.util import read_csv
fmu, given, wanted, stop, step = sys.argv[1:]
wanted = read_csv(wanted)
names = wanted.dtype.names
found = fmpy.simulate_fmu(fmu, stop_time=float(stop), output_interval=float(step),
                          input=read_csv(given), output=names[1:])
show(float(max(abs(found[name] - wanted[name]).max() for name in names)))
"""


def test_an_fmu_carries_its_reference_run(tiny, tmp_path):
    path, _ = publish(tiny, tmp_path, REFERENCE)
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    folder = "extra/org.fmi-standard.fmi-ls-ref"
    manifest = ET.fromstring(files[f"{folder}/fmi-ls-manifest.xml"])
    assert manifest.tag == "fmiReferences"
    names = {key.rpartition("}")[2]: value for key, value in manifest.attrib.items()}
    assert names["fmi-ls-name"] == "org.fmi-standard.fmi-ls-ref"
    related = {entry.get("role"): entry for entry in manifest}
    assert set(related) == {"experiment/smoke-test", "result"}
    for entry in manifest:
        data = files[posixpath.normpath(f"{folder}/{entry.get('source')}")]
        assert hashlib.sha3_256(data).hexdigest() == entry.get("checksum")

    exp = related["experiment/smoke-test"].get("source")
    (experiment,) = ET.fromstring(files[f"{folder}/{exp}"])
    parts = {part.tag: part.attrib for part in experiment}
    assert list(parts) == ["TransientSimulation", "Stimuli", "References"]
    for tag in ("Stimuli", "References"):
        (tmp_path / tag).write_bytes(files[f"{folder}/{parts[tag]['source']}"])
    times = parts["TransientSimulation"]
    tables = (tmp_path / "Stimuli", tmp_path / "References")
    assert apart(DEVIATION, path, *tables, times["stopTime"], times["stepSize"]) < 1e-6
