"""The site: its reference is made of the commands and the library as they are."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

import spindle_drift
from scenarios import cli
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def hooks() -> ModuleType:
    pytest.importorskip("mkdocs", reason="mkdocs is not installed (make docs installs it)")
    spec = importlib.util.spec_from_file_location("site_hooks", ROOT / "docs" / "site" / "hooks.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["site_hooks"] = module
    spec.loader.exec_module(module)
    return module


def test_every_command_and_option_stands_on_the_page(hooks):
    page = hooks.commands_page()
    for name in cli.commands():
        assert f"\n## {name}\n" in page
        for action in cli.parser_of(name)._actions:
            assert "\\|" not in hooks._argument(action)
            if action.option_strings and action.option_strings[0] != "-h":
                assert action.option_strings[-1] in page


def test_every_public_name_stands_on_the_page(hooks):
    page = hooks.python_names()
    assert all(f"::: spindle_drift.{name}\n" in page for name in spindle_drift.__all__)


@pytest.mark.parametrize(
    ("text", "source", "place", "found"),
    [
        ("[a](docs/fmu.md#x)", "README.md", "index.md", "[a](fmu.md#x)"),
        ("[a](../README.md)", "docs/fmu.md", "fmu.md", "[a](index.md)"),
        ("![a](docs/figures/b.png)", "README.md", "index.md", "![a](figures/b.png)"),
        ("[a](https://x.org/y)", "README.md", "index.md", "[a](https://x.org/y)"),
    ],
)
def test_links_point_at_the_site(hooks, text, source, place, found):
    assert hooks.LINK.sub(lambda match: hooks._link(match, source, place), text) == found


def test_every_page_is_in_the_navigation():
    listed = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = [path.name for path in (ROOT / "docs").glob("*.md")]
    pages += [f"notebooks/{path.name}" for path in (ROOT / "docs" / "notebooks").glob("*.py")]
    assert [name for name in pages if f": {name}\n" not in listed] == []


def test_the_notebooks_log_is_the_one_that_is_made():
    import pandas as pd

    import spindle_drift as sd

    log = sd.import_log(ROOT / "docs" / "notebooks" / "march.xlsx")
    fresh = sd.simulate("jig_borer", "training_down", every_s=60.0, noise_seed=40).frame
    pd.testing.assert_series_equal(
        log.runs[0].frame["Lager_vorn_degC"],
        fresh["T1_degC"],
        atol=0.011,
        check_names=False,
        check_index=False,
    )
    assert Path(ROOT / "docs" / "site" / "make_march.py").is_file()
