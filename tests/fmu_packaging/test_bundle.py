"""Which modules travel, and how their imports change."""

import sys
from pathlib import Path

import pytest

from fmu_packaging.bundle import BundleError, collect, rewritten
from tests.running import output_of

OURS = ("ours", "more")


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("from ours.a import b\n", "from root.ours.a import b\n"),
        ("from ours import (\n    a,\n    b,\n)\n", "from root.ours import (\n    a,\n    b,\n)\n"),
        ("import ours.a as x, json\n", "import root.ours.a as x, json\n"),
        ("é = 1; from more.a import b\n", "é = 1; from root.more.a import b\n"),
        (
            "def f():\n    from ours.a import b as c  # from ours.a\n",
            "def f():\n    from root.ours.a import b as c  # from ours.a\n",
        ),
        ("from .a import b\nimport json\n", "from .a import b\nimport json\n"),
        ("x = 'from ours.a import b'\n", "x = 'from ours.a import b'\n"),
        ("from oursbutnot.a import b\n", "from oursbutnot.a import b\n"),
    ],
)
def test_rewrites_only_imports_of_ours(before, after):
    assert rewritten(before, "root", OURS) == after


def test_refuses_an_import_that_binds_the_top_name():
    with pytest.raises(BundleError, match=r"m:2: .*ours\.a"):
        rewritten("import json\nimport ours.a\n", "root", OURS, "m")


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    files = {
        "ours/__init__.py": "",
        "ours/start.py": "from typing import TYPE_CHECKING\nfrom ours.used import X\n"
        "if TYPE_CHECKING:\n    from ours.typing_only import Y\n\ndef late():\n"
        "    from ours import late_one\n    return late_one.Z\n",
        "ours/used.py": "import math\nX = math.pi\n",
        "ours/typing_only.py": "import pandas\nY = 1\n",
        "ours/late_one.py": "from .sub import thing\nZ = thing.W\n",
        "ours/sub/__init__.py": "",
        "ours/sub/thing.py": "W = 5\n",
        "ours/sub/walked.py": "V = 6\n",
        "ours/unused.py": "1 / 0\n",
        "ours/heavy.py": "import numpy\nimport pandas\n",
    }
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [name for name in sys.modules if name.partition(".")[0] == "ours"]:
        monkeypatch.delitem(sys.modules, name)
    return tmp_path


def test_takes_only_what_is_needed(packages):
    bundle = collect("ours.start", ["ours"])
    assert sorted(bundle.sources) == [
        "ours",
        "ours.late_one",
        "ours.start",
        "ours.sub",
        "ours.sub.thing",
        "ours.used",
    ]
    whole = collect("ours.start", ["ours"], whole=["ours.sub"])
    assert "ours.sub.walked" in whole.sources
    assert whole.digest() != bundle.digest()


def test_what_is_bundled_runs_without_the_original(packages, tmp_path):
    folder = tmp_path / "elsewhere"
    for path, text in collect("ours.start", ["ours"]).files("root").items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    code = (
        f"import sys; sys.path.insert(0, {str(folder)!r})\n"
        "from root.ours.start import late, X\nprint(late(), X)\n"
        "assert not any(name == 'ours' or name.startswith('ours.') for name in sys.modules)\n"
    )
    assert output_of(sys.executable, "-P", "-c", code).split() == ["5", "3.141592653589793"]


def test_refuses_what_the_host_may_not_have(packages):
    with pytest.raises(BundleError, match=r"heavy\.py:2: imports pandas"):
        collect("ours.heavy", ["ours"], allowed=["numpy"])
    with pytest.raises(BundleError, match=r"heavy\.py:1: imports numpy"):
        collect("ours.heavy", ["ours"])
    with pytest.raises(BundleError, match=r"no module ours\.absent"):
        collect("ours.absent", ["ours"])
