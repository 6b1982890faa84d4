"""The report in a browser: figures drawn, nothing to complain about, nothing fetched."""

import base64
import re
import shutil
from pathlib import Path

import pytest

from scenarios.runner import run_scenario
from scenarios.scenario import read_scenario
from tests.scenarios.conftest import MISSING, TINY

VARIANTS = (
    '\n[[variants]]\nname = "on"\ntitle = "With <b>offsets</b> & care"\n'
    '[[variants]]\nname = "off"\nset = { "compensator.enabled" = false }\n'
)


@pytest.fixture(scope="module")
def report(
    tiny_plant: Path, tiny_compensator: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A report of the tiny scenario with a fault and two variants."""
    folder = tmp_path_factory.mktemp("report")
    shutil.copy(tiny_plant, folder / "plant.fmu")
    shutil.copy(tiny_compensator, folder / "compensator.fmu")
    (folder / "tiny.toml").write_text(TINY + MISSING + VARIANTS, encoding="utf-8")
    run_scenario(read_scenario(folder / "tiny.toml"), folder / "out", folder, quiet=True)
    return folder / "out" / "report.html"


def test_the_report_names_what_a_reader_needs(report):
    text = report.read_text(encoding="utf-8")
    page = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    for needed in ("A tiny scenario", "No compensation", "GUID", "SHA-256", "run.csv", "µm"):
        assert needed in page
    assert "With &lt;b&gt;offsets&lt;/b&gt; &amp; care" in page
    assert "holding: T1 is missing" in page
    # Nothing to be fetched: no address in an attribute that a browser follows.
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]*"', page)


@pytest.mark.browser
@pytest.mark.parametrize("width", [1280, 390])
def test_the_report_draws_its_figures_without_complaint(report, browser, width):
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get(report.as_uri())
    browser.set_script_timeout(60)
    browser.execute_async_script("plotly.then(arguments[0])")
    charts = browser.execute_script(
        "return [...document.querySelectorAll('.chart')].map(chart => ({"
        "  name: chart.id, traces: chart.data.length, right: chart.getBoundingClientRect().right,"
        "  drawn: [...chart.querySelectorAll('.scatterlayer .trace')].filter(trace =>"
        "    [...trace.querySelectorAll('path.js-line')].some(path =>"
        "      path.getAttribute('d').length > 10)).length,"
        "  titles: [...chart.querySelectorAll('.ytitle, .y2title, .y3title')]"
        "    .map(title => title.textContent)}))"
    )
    named = {chart["name"] for chart in charts}
    assert {"chart-speed", "chart-temperatures", "chart-drift", "chart-tilt"} <= named
    for chart in charts:
        assert chart["traces"] > 0, chart
        assert chart["drawn"] == chart["traces"], chart
        assert chart["right"] <= width, chart
        assert chart["titles"], chart
        assert all("[" in title for title in chart["titles"]), chart
    assert browser.get_log("browser") == []
    wide = browser.execute_script("return document.documentElement.scrollWidth")
    assert wide <= width
    cells = browser.execute_script("return document.querySelectorAll('.headline tr.row').length")
    assert cells == 2
    shot = browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
    assert len(base64.b64decode(shot["data"])) > 10_000
