"""The spindle in a web page: the FMUs' numbers, its controls, and what cannot be made."""

import importlib.util
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from fmu_packaging.native.web import WebModule
from plant_model.machine_file import machine_path
from scenarios.building import DEFAULT_MODEL
from scenarios.cli import main
from scenarios.pages.report import STATES
from tests.conftest import once
from tests.fmu_packaging.apart import apart
from tests.running import need_ziglang

AGREE = 1e-9
STEPS = 400
RUN = """
const [role, rows, step] = arguments, { Fmu, told, code } = window.spindle;
return Fmu.load(code(role), told[role]).then((fmu) => {
  const given = fmu.port(fmu.names("input")), seen = fmu.port(fmu.names("output"));
  const codes = fmu.port(fmu.names("output", "integer"), "integer");
  given.set(rows[0].map((value) => value ?? NaN));
  fmu.start();
  return rows.map((row) => {
    given.set(row.map((value) => value ?? NaN));
    fmu.step(step);
    return [...seen.get(), ...codes.get()];
  });
});
"""


OF_THE_FMU = """
fmu, rows, step = opened(sys.argv[1]), json.load(open(sys.argv[2])), float(sys.argv[3])
given = fmu.ins + fmu.probed
codes = [fmu.refs[name] for name in ("status", "status_sensor") if name in fmu.refs]
def shown(place):
    fmu.put(given, rows[place])
    fmu.doStep(place * step, step)
    return [*fmu.get(fmu.outs), *(fmu.whole(codes) if codes else [])]
fmu.put(given, rows[0])
started(fmu)
show([shown(place) for place in range(len(rows))])
"""


@pytest.fixture(scope="module")
def page(shared: Path) -> Path:
    """The page of the shipped machine and compensator."""
    need_ziglang()

    def make(new: Path) -> None:
        assert main(["web", "jig_borer", str(DEFAULT_MODEL), "-o", str(new)]) == 0

    return once(shared / "spindle.html", make)


def rows_of(path: Path) -> list[list[float]]:
    """Inputs that change: everything moves about its start, one thermometer fails a while."""
    dice = np.random.default_rng(5)
    rows: list[list[float]] = []
    inputs = [
        variable
        for variable in fmpy.read_model_description(path).modelVariables
        if variable.causality == "input" and variable.type == "Real"
    ]
    for step in range(STEPS):
        row = []
        for place, variable in enumerate(inputs):
            wave = math.sin(step / (20.0 + 3.0 * place)) ** 2
            if variable.name == "speed":
                row.append(float(2000 * (step // 60)))
            else:
                row.append(float(variable.start) + 2.0 * wave + dice.normal(0.0, 0.01))
        if "T3" in (names := [variable.name for variable in inputs]) and 150 < step < 250:
            row[names.index("T3")] = math.nan
        rows.append(row)
    return rows


@pytest.mark.long
@pytest.mark.browser
@pytest.mark.parametrize("role", ["plant", "compensator"])
def test_the_numbers_are_those_of_the_fmu(page, browser, shipped_in_c, role, tmp_path):
    path = shipped_in_c / f"{role}_native.fmu"
    rows = rows_of(path)
    (tmp_path / "rows.json").write_text(json.dumps(rows))
    expected = np.array(apart(OF_THE_FMU, path, tmp_path / "rows.json", 10.0))
    browser.get(page.as_uri())
    opened(browser)
    sent = [[None if math.isnan(value) else value for value in row] for row in rows]
    found = np.array(browser.execute_script(RUN, role, sent, 10.0), dtype=float)
    assert found.shape == expected.shape
    assert np.ptp(expected, axis=0).max() > 1.0
    if role == "compensator":
        assert {0, 4} <= set(expected[:, -2])
    np.testing.assert_allclose(found, expected, rtol=AGREE, atol=AGREE)


def opened(browser: Any) -> None:
    """Wait for the page's modules."""
    browser.set_script_timeout(60)
    browser.execute_async_script(
        "const done = arguments[0]; const look = () => window.spindle ? done() :"
        " setTimeout(look, 20); look()"
    )


@pytest.mark.long
@pytest.mark.browser
@pytest.mark.parametrize("width", [1280, 390])
def test_the_page_runs_and_shows_what_its_controls_do(page, browser, width):
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get(page.as_uri())
    opened(browser)

    def shown(script: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = browser.execute_script(
            # One script, no frame of the page's own between: what is shown does not depend on pace.
            f"const {{ page }} = window.spindle; {script}; page.play(false); page.draw();"
            "const text = (name) => document.getElementById(name).textContent;"
            "return { time: page.loop.plant.time, state: text('state'), words: text('words'),"
            " left: Math.abs(page.loop.value('error_Z')),"
            " drift: Math.abs(page.loop.value('drift_Z')),"
            " half: page.loop.value('dZ_uncertainty'),"
            " wide: document.documentElement.scrollWidth }"
        )
        return found

    def change(name: str, value: object, kind: str = "value") -> str:
        return (
            f"document.getElementById('{name}').{kind} = {json.dumps(value)};"
            f"document.getElementById('{name}').dispatchEvent(new Event('input'));"
            f"document.getElementById('{name}').dispatchEvent(new Event('change'))"
        )

    assert shown("page.restart()")["time"] == 0.0
    ran = shown("page.advance(6000)")
    assert ran["time"] == 6000.0
    assert ran["state"] == STATES[0][0]
    assert ran["drift"] > 5.0
    assert ran["left"] < 0.3 * ran["drift"]
    broken = shown(change("sensor", "T5") + "; page.advance(600)")
    assert "T5" in broken["words"]
    assert broken["state"] == "without a sensor"
    assert broken["half"] > ran["half"]
    off = shown(
        change("sensor", "") + ";" + change("compensating", False, "checked") + ";"
        "page.advance(3600)"
    )
    assert off["left"] == pytest.approx(off["drift"], abs=1.0)
    still = shown(change("input-speed", 0) + "; page.advance(36000)")
    assert still["drift"] < 0.5 * off["drift"]
    again = shown("page.restart()")
    assert again["time"] == 0.0
    assert again["wide"] <= width
    assert browser.get_log("browser") == []


@pytest.mark.long
def test_the_page_needs_nothing_else(page):
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]*"', text)
    assert not re.search(r"\b(?:fetch|XMLHttpRequest|import)\s*\(", text)
    assert '<meta name="generator" content="spindle-drift">' in text[:2000]


def test_the_interval_is_named_by_the_share_of_the_compensator_file(tmp_path, monkeypatch):
    monkeypatch.setattr(WebModule, "code", b"")
    model = json.loads(DEFAULT_MODEL.read_text("utf-8"))
    model["gaussian"]["coverage"] = 0.68
    other, path = tmp_path / "compensator.json", tmp_path / "page.html"
    other.write_text(json.dumps(model), "utf-8")
    assert main(["web", "jig_borer_lumps", str(other), "-o", str(path)]) == 0
    assert "interval, 68 %" in path.read_text("utf-8")


def test_a_page_steers_a_speed_of_any_name(tmp_path, monkeypatch):
    monkeypatch.setattr(WebModule, "code", b"")
    machine, page = tmp_path / "mine.toml", tmp_path / "page.html"
    text = machine_path("jig_borer_lumps").read_text("utf-8")
    text = re.sub(r"^speed = \{", "drehzahl = {", text, flags=re.MULTILINE)
    # Air gaps know no other name.
    text = re.sub(
        r'\[\[links\]\]\nkind = "air_gap".*?\n\n|air_gap = \{\}', "", text, flags=re.DOTALL
    )
    machine.write_text(text.replace('"speed"', '"drehzahl"'), "utf-8")
    assert main(["web", str(machine), str(DEFAULT_MODEL), "-o", str(page)]) == 0
    assert re.search(r'"shared": ?\{"speed": ?"drehzahl"', page.read_text("utf-8"))


def test_without_its_compiler_nothing_is_written(tmp_path, monkeypatch, refused):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "ziglang" else find(name)
    )
    path = tmp_path / "page.html"
    assert "pip install ziglang" in refused(
        ["web", "jig_borer_lumps", str(DEFAULT_MODEL), "-o", str(path)]
    )
    assert not path.exists()


@pytest.mark.long
def test_a_scenario_links_the_page_of_its_machine_and_compensator(page, shipped, tmp_path):
    out = tmp_path / "out"
    options = ["--set", "duration_s=60", "--fmu-dir", str(shipped), "--quiet", "--live"]
    assert main(["run", "step_speed", *options, "--out", str(out)]) == 0
    assert '<a href="spindle.html">' in (out / "report.html").read_text(encoding="utf-8")
    assert (out / "spindle.html").read_bytes() == page.read_bytes()
