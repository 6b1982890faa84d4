"""``spindle-drift update`` and ``spindle-drift monitor``."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.special import stdtrit

from fmu_compensator.runtime.modelfile import load_model
from measurement.runs import Run, read_run, write_run
from measurement.warm import WARM_START
from scenarios.cli import main
from tests.fmu_compensator.conftest import make_run


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A compensator file; the runs that it was fitted to are gone."""
    folder = tmp_path_factory.mktemp("fitted")
    files = [write_run(make_run(f"old{n}", n, hours=2.0), folder / f"old{n}.csv") for n in range(4)]
    out = folder / "c.json"
    assert main(["fit", *map(str, files), "--model", "bayes", "--no-speed", "-o", str(out)]) == 0
    for file in files:
        file.unlink()
    return out


@pytest.fixture
def compensator(fitted: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(fitted, tmp_path))


@pytest.fixture
def new_run(tmp_path: Path) -> Path:
    return write_run(make_run("new", 50, hours=2.0), tmp_path / "new.csv")


def test_an_update_writes_a_file_and_shows_the_old_one_s_errors(
    compensator, new_run, tmp_path, prints
):
    before = compensator.read_bytes()
    out = tmp_path / "d.json"
    told = prints(["update", str(compensator), str(new_run), "-o", str(out)])
    assert "  new: X " in told
    assert f"wrote {out}" in told
    names = [run["name"] for run in load_model(out).provenance["runs"]]
    assert names == ["old0", "old1", "old2", "old3", "new"]
    assert compensator.read_bytes() == before


def test_an_update_leaves_warm_restarts_out_and_says_so(compensator, new_run, tmp_path, prints):
    warm = make_run("warm", 51, hours=2.0).frame.assign(**{WARM_START: 1.0})
    paths = map(str, (new_run, write_run(warm, tmp_path / "warm.csv")))
    out = tmp_path / "d.json"
    told = prints(["update", str(compensator), *paths, "-o", str(out)])
    assert (
        "left out, since the machine was warm when they began: warm; use them by themselves" in told
    )
    assert re.findall(r"^  (\w+): X", told, re.MULTILINE) == ["new"]
    names = [run["name"] for run in load_model(out).provenance["runs"]]
    assert names == ["old0", "old1", "old2", "old3", "new"]


@pytest.mark.usefixtures("drawn")
def test_the_first_line_of_monitor_is_the_verdict(compensator, new_run, tmp_path, prints):
    out = tmp_path / "watched"
    told = prints(["monitor", str(compensator), str(new_run), "--out", str(out)]).splitlines()
    assert told[0] == "fits: still fits, but more than promised remains in new (Z)"
    assert told[1].startswith("what to do: measure more runs")
    report = json.loads((out / "monitor.json").read_text())
    assert report["verdict"] == "fits"
    assert report["runs"][0]["errors"][0]["axis"] == "X"
    assert (out / "monitor.png").stat().st_size > 10_000


def test_monitor_as_json_is_one_document(compensator, tmp_path, prints):
    frame = make_run("silent", 60, hours=2.0).frame
    frame = frame[[name for name in frame if not str(name).endswith("_um")]]
    silent = write_run(Run("silent", frame), tmp_path / "silent.csv")
    report = json.loads(prints(["monitor", str(compensator), str(silent), "--json"]))
    assert report["verdict"] == "not_measured"
    assert report["runs"][0]["errors"] == []


def test_the_range_of_a_gain_has_the_level_that_is_printed(compensator, tmp_path, prints):
    files = []
    for seed in range(3):
        frame = make_run(f"far{seed}", 50 + seed, hours=2.0).frame
        moved = [name for name in frame if str(name).endswith("_um")]
        run = Run(f"far{seed}", frame.assign(**(2.0 * frame[moved])))
        files.append(str(write_run(run, tmp_path / f"far{seed}.csv")))
    told = prints(["monitor", str(compensator), *files])
    report = json.loads(prints(["monitor", str(compensator), *files, "--json"]))
    gain = report["gains"][0]
    pattern = rf"^{gain['axis']} moves .* \((\S+) to (\S+), (\d+)%\)$"
    low, high, level = map(float, re.search(pattern, told, re.MULTILINE).groups())
    gains = [e["gain"] for r in report["runs"] for e in r["errors"] if e["axis"] == gain["axis"]]
    half = np.std(gains, ddof=1) / np.sqrt(len(gains))
    half *= stdtrit(len(gains) - 1, 0.5 + level / 200.0)
    ends = np.mean(gains) - half, np.mean(gains) + half
    assert (low, high) == pytest.approx(ends, abs=0.006)


def test_a_run_that_is_too_short_is_drawn_too(compensator, new_run, tmp_path):
    short = tmp_path / "short.csv"
    short.write_text("".join(new_run.read_text().splitlines(keepends=True)[:12]))
    out = tmp_path / "watched"
    assert main(["monitor", str(compensator), str(short), "--out", str(out)]) == 0
    assert json.loads((out / "monitor.json").read_text())["runs"][0]["verdict"] == "too_short"


def test_swapped_thermometers_of_one_run_are_doubted_by_monitor_and_replay(
    compensator, new_run, tmp_path, prints
):
    frame = read_run(new_run).frame
    swapped = frame.assign(T1_degC=frame["T4_degC"], T4_degC=frame["T1_degC"])
    path = write_run(swapped, tmp_path / "swapped.csv")
    doubt = "T1 behaves like T4 in training, and that one like it, in swapped: swapped there?"
    for command in (["monitor"], ["replay", "--out", str(tmp_path / "out")]):
        name, *options = command
        assert doubt in prints([name, str(compensator), str(path), *options])
