"""The worked examples of CONTRIBUTING: each is put into a copy of the project and runs there."""

import json
import shutil
import socket
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import ROOMS, ROOT
from tests.docs.test_docs import FENCE
from tests.running import python


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project with the files that CONTRIBUTING shows."""
    folder = tmp_path_factory.mktemp("copy")
    for room in ROOMS:
        shutil.copytree(ROOT / room, folder / room)
    for info, text in FENCE.findall((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")):
        if info.startswith("python "):
            (folder / info.split()[1]).write_text(text, encoding="utf-8")
    time_s = 60.0 * np.arange(40)
    warming = {"time_s": time_s, "speed_rpm": 3000.0, "growth_um": 10.0 * time_s / time_s[-1]}
    for number in range(3):
        frame = pd.DataFrame(warming | {"T1_degC": 20 + time_s / 600, "T2_degC": 20 + time_s / 500})
        frame["T3_degC"] = frame["T1_degC"] + number
        if number == 2:
            frame["T3_degC"] += 1.5 * (-1.0) ** np.arange(len(frame))
        frame.to_csv(folder / f"run{number}.csv", index=False)
    return folder


def run_in(folder: Path, *argv: str) -> str:
    return python(*argv, folder=folder, path=str(folder))


@pytest.mark.long
def test_an_error_model(copied):
    fit = ["fit", "run0.csv", "run1.csv", "--model", "mean", "--points", "T1,T2", "-o", "mean.json"]
    run_in(copied, "-m", "scenarios.cli", *fit)
    assert json.loads((copied / "mean.json").read_text())["error_model"]["kind"] == "mean"


@pytest.mark.long
def test_a_check_for_broken_sensors(copied):
    shown = run_in(copied, "-m", "scenarios.cli", "summary", "run0.csv", "run1.csv", "run2.csv")
    assert "run2, T3_degC, 0 to 39 min: moves by 2.9 K from one reading to the next" in shown
    assert "run1, T3_degC" not in shown


PROTOCOL = """
import argparse
import sys
from gateway.protocols import adapters
from gateway.protocols.base import Report
(kind,) = [kind for kind in adapters() if kind.__name__ == "Udp"]
parser = argparse.ArgumentParser()
kind.add_arguments(parser)
at_work = kind(parser.parse_args(["--udp", sys.argv[1]])).join(None, None, None, print)
at_work.update(0.0, lambda: Report({}, {}, {"dX": 1.5, "dZ": -2.25}, {}))
at_work.close()
"""


@pytest.mark.long
def test_a_protocol_of_the_gateway(copied):
    assert "--udp PORT" in run_in(copied, "-m", "scenarios.cli", "gateway", "--help")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        control.bind(("127.0.0.1", 0))
        control.settimeout(30.0)
        run_in(copied, "-c", PROTOCOL, str(control.getsockname()[1]))
        assert control.recv(200) == b"dX=1.5000 dZ=-2.2500"


@pytest.mark.long
def test_a_report(copied):
    command = ["warmth", "run0.csv", "run1.csv", "-o", "warmth.html"]
    run_in(copied, "-m", "scenarios.cli", *command)
    page = (copied / "warmth.html").read_text(encoding="utf-8")
    assert page.count("Plotly.newPlot") == 2
    assert "T2_degC" in page
    assert "2 runs." in page
