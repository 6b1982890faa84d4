"""The pages: their links, commands, examples, and the tables that are made from the code."""

import argparse
import importlib
import importlib.util
import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, get_args

import numpy as np
import pandas as pd
import pytest

import build_fmu
from benchmarks.results_page import BLOCK, PAGE
from docs import make_tables
from fmu_compensator.runtime.modelfile import parse_model
from measurement.rig import default_rig
from measurement.runs import read_run
from plant_model.checks import check_sheet
from plant_model.drawing.expand import expanded
from plant_model.drawing.fits import odd_fits
from plant_model.drawing.layout import Drawing
from plant_model.machine_file import machine_from_table, read_machine
from plant_model.network import effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.simulate import simulate
from plant_model.structure import drift_at, pose
from scenarios import cli
from scenarios.faults import Kind
from scenarios.scenario import scenario_from_text
from scenarios.signals import kinds
from tests.conftest import ROOMS, ROOT

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
IMAGE_OR_LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
PROMPTS = ("spindle-drift", "python", "make", ".")


class Block(NamedTuple):
    """A fenced block: the page, the words after the fence, the text."""

    page: Path
    info: str
    text: str


def blocks(info: str = "") -> Iterator[Block]:
    for page in PAGES:
        for words, text in FENCE.findall(page.read_text(encoding="utf-8")):
            if not info or words == info:
                yield Block(page, words, text)


def example(name: str) -> str:
    """Return an example: a file beside the pages, or what a page shows under this name."""
    file = ROOT / "docs" / "examples" / name
    if file.is_file():
        return file.read_text(encoding="utf-8")
    (found,) = [block.text for block in blocks() if block.info.split()[1:] == [name]]
    return found


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {heading.strip().replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_resolve(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    for target in IMAGE_OR_LINK.findall(text):
        if target.startswith("https://"):
            continue
        name, _, anchor = target.partition("#")
        file = page.parent / name if name else page
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_in_code_marks_exist(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    rooms = "|".join([*ROOMS, "benchmarks", "tests", "docs"])
    for path in re.findall(rf"`((?:{rooms})/[\w./*-]*)`", text):
        known = re.sub(r"\bNAME\b", "*", path)
        assert any(ROOT.glob(known.rstrip("/"))), path


def command_lines() -> list[str]:
    lines = []
    for block in blocks("sh"):
        joined = block.text.replace("\\\n", " ")
        lines += [line for line in joined.splitlines() if line.strip()]
    return lines


def targets() -> set[str]:
    return set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def check_command(line: str) -> None:
    """Parse a command line with the parser that would parse it."""
    program, *words = shlex.split(line, comments=True)
    assert program in PROMPTS, line
    if program == "spindle-drift":
        name, *rest = words
        module = importlib.import_module(cli.commands()[name][0])
        parser = argparse.ArgumentParser(exit_on_error=False)
        module.add_arguments(parser)
        parser.parse_args(rest)
    elif program == "make":
        assert set(words) <= targets(), line
    elif words[:1] == ["build_fmu.py"]:
        build_fmu._arguments(words[1:])
    elif words[:1] == ["-m"]:
        assert importlib.util.find_spec(words[1]), line


@pytest.mark.parametrize("line", command_lines())
def test_commands_exist_with_their_options(line):
    check_command(line)


def test_commands_in_running_text_exist():
    known = set(cli.commands()) | {"COMMAND"}
    for page in PAGES:
        text = FENCE.sub("", page.read_text(encoding="utf-8"))
        named = set(re.findall(r"`spindle-drift (\w[\w-]*)", text))
        assert named <= known, page.name


def test_python_examples_compile_and_import():
    found = list(blocks("python"))
    assert len(found) >= 3
    for block in found:
        compile(block.text, str(block.page), "exec")
        for module in re.findall(r"^from ([\w.]+) import", block.text, re.MULTILINE):
            assert importlib.util.find_spec(module), module


def test_the_run_example_reads(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(example("run.csv"), encoding="utf-8")
    run = read_run(path)
    assert run.temperatures == ["T1_degC", "T2_degC"]
    assert run.frame["T1_degC"].isna().sum() == 1
    assert default_rig(run).columns == ["disp_z_um"]


def test_the_machine_example_reads_and_runs(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(example("machine.toml"), encoding="utf-8")
    machine = read_machine(path)
    rows = [(0.0, 6000.0, 20.0), (1800.0, 6000.0, 20.0)]
    inputs = pd.DataFrame(rows, columns=["time_s", "speed_rpm", "hall_degC"])
    result = simulate(machine, inputs)
    assert result.temperatures[0, -1].min() > 20.0
    assert result.run_frame()["disp_z_um"].iloc[-1] < -1.0
    assert check_sheet(machine).wrong == ()


def test_the_example_of_a_belt_spindle_looks_right_and_moves_as_the_page_says(tmp_path):
    path = tmp_path / "belt.toml"
    path.write_text(example("belt.toml"), encoding="utf-8")
    sheet = check_sheet(read_machine(path))
    assert sheet.wrong == ()
    assert odd_fits(Drawing(tomllib.loads(example("belt.toml")), path)) == []
    assert sheet.drift[2] < -10.0
    text = (ROOT / "docs" / "drawing.md").read_text(encoding="utf-8")
    assert "8.3 urad and 2.9 um for each kelvin" in text
    bent = pose_of(path, "headstock", grows={}, bends=None)
    assert bent[[1, 4]] == pytest.approx([2.9, 8.3], abs=0.05)
    pushed = pose_of(path, "headstock", grows={"x": 100.0, "y": -280.0, "z": 80.0}, bends=[])
    assert pushed[[0, 1, 2]] == pytest.approx([1.05, -2.94, 0.84])
    assert drift_at(pushed, 0.0) == pytest.approx([1.05, -2.94, -0.84])
    warm = pose_of(path, "_yp", grows={}, bends=[])
    assert drift_at(warm, 0.0)[1] < -0.1


def pose_of(path: Path, warm: str, grows: dict[str, float], bends: list[Any] | None) -> FloatArray:
    """Return the pose of a page whose nodes of one ending are a kelvin warmer."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    table["carriers"][0]["grows"] = grows
    if bends is not None:
        table["carriers"][0]["bends"] = bends
    machine = machine_from_table(expanded(table, path), path)
    effects = effects_in_force(machine, Values(machine.parameters))
    rise = np.array([float(node.name.endswith(warm)) for node in machine.nodes])[None, None]
    still = {entry.name: np.zeros(1) for entry in machine.inputs}
    return pose(effects, {}, still, rise, np.zeros((1, 1, 0)))[0, 0]


def test_the_compensator_example_reads():
    model = parse_model(example("compensator.json"), "compensator.json")
    assert [model.sensors[index].name for index in model.chosen] == ["T1"]
    assert model.geometry.drift([-28.6], 0.0) == (0.0, 0.0, -28.6)


def test_the_scenario_example_reads():
    scenario = scenario_from_text(example("scenario.toml"), Path("scenario.toml"))
    assert [case.name for case in scenario.cases] == ["compensated", "without"]
    variables = make_tables.plant_slave.variables(read_machine(make_tables.DEFAULT_MACHINE))
    declared = {entry.name: entry for entry in variables}
    for case in scenario.cases:
        assert set(case.signals) <= declared.keys()
        for name, value in case.settings.plant.parameters.items():
            assert declared[name].refusal(value) == ""


def test_the_effects_example_fits_the_shipped_machine():
    texts = [block.text for block in blocks("toml") if block.page.name == "effects.md"]
    assert len(texts) == 2
    path = ROOT / "plant_model" / "machines" / "jig_borer_lumps.toml"
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    more = {key: entry for text in texts for key, entry in tomllib.loads(text)["effects"].items()}
    table["effects"] |= more
    assert set(more) <= machine_from_table(table, "example").effects.keys()


@pytest.mark.parametrize("name", make_tables.PAGES)
def test_tables_are_up_to_date(name):
    text = (ROOT / "docs" / name).read_text(encoding="utf-8")
    assert make_tables.MARKS.search(text)
    assert make_tables.renewed(text) == text, "run: python -m docs.make_tables"


def test_every_table_stands_in_a_page():
    pages = [(ROOT / "docs" / name).read_text(encoding="utf-8") for name in make_tables.PAGES]
    found = {mark[2] for page in pages for mark in make_tables.MARKS.finditer(page)}
    assert found == make_tables.TABLES.keys()


def test_format_page_names_every_kind_of_signal_and_fault():
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    assert all(f"| `{kind}` |" in text for kind in kinds())
    assert all(f"`{kind}`: " in text for kind in get_args(Kind))


def test_every_field_of_the_shipped_compensator_is_described():
    table = json.loads(make_tables.DEFAULT_MODEL.read_text(encoding="utf-8"))
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    text = page[page.index("## Compensator file") : page.index("## Scenario file")]
    inner = {**table["sensors"][0], **table["limits"], **table["gaussian"], **table["spare"]}
    assert not [
        key for key in {**table, **inner} if f"{key}`" not in text and f"`{key}" not in text
    ]


def test_every_measured_table_stands_under_the_command_that_makes_it():
    page = PAGE.read_text(encoding="utf-8")
    assert len(BLOCK.findall(page)) >= 10
    for _, name, command, _ in BLOCK.findall(page):
        check_command(command)
        assert f"    {command}\n\n<!-- begin {name}:" in page
    outside = BLOCK.sub("", page)
    assert not re.search(r"^\|", outside, re.MULTILINE)
