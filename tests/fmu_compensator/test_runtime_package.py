"""The runtime as a package: standard library only, error models found by walking."""

import subprocess
import sys
from pathlib import Path

import pytest

from fmu_compensator.runtime.walk import classes_found
from tests.conftest import ROOT

THIRD_PARTY = {"numpy", "pandas", "scipy", "pydantic", "measurement", "pythonfmu"}


def test_the_runtime_loads_the_standard_library_only():
    code = (
        "import sys, fmu_compensator.runtime.compensator as c\n"
        "from fmu_compensator.runtime.modelfile import load_model\n"
        "model = load_model('fmu_compensator/library/jig_borer.json')\n"
        f"print(model.name, sorted({THIRD_PARTY!r} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "jig_borer []"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package whose modules define variants of `Exception`."""
    folder = tmp_path / "walked_variants"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "one.py").write_text("class One(LookupError): pass")
    (folder / "two.py").write_text("from walked_variants.one import One\nclass Two(One): pass")
    (folder / "none.py").write_text("from walked_variants.one import One\nx = 1")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.startswith("walked_variants")]:
        monkeypatch.delitem(sys.modules, name)
    return folder


def test_a_variant_is_a_file(package):
    found = classes_found("walked_variants", [str(package)], LookupError)
    assert {name: kind.__name__ for name, kind in found.items()} == {"one": "One", "two": "Two"}


def test_two_variants_in_one_file_are_refused(package):
    (package / "both.py").write_text("class A(LookupError): pass\nclass B(LookupError): pass")
    with pytest.raises(TypeError, match="both defines 2 variants"):
        classes_found("walked_variants", [str(package)], LookupError)
