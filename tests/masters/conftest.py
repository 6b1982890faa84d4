"""The FMUs, the .ssp and the trajectories that every master must give."""

import io
import os
import subprocess
import sys
import zipfile
from importlib import metadata
from pathlib import Path

import pandas as pd
import pytest

from scenarios.cli import main
from scenarios.cosimulation import simulate
from scenarios.scenario import read_scenario
from tests import running
from tests.conftest import ROOT

EXAMPLES = ROOT / "docs" / "examples"
SCENARIO, VARIANT = "step_speed", "long_tool"
STEP_S, STOP_S = 10.0, 4500.0
"""Long enough for a change of speed, at 3600 s."""

SETTINGS = {"step_s": STEP_S, "duration_s": STOP_S}
INPUTS = ["speed", "ambient", "coolant_inlet", "tool_length"]
TOLERANCE = 1e-9
"""[um, degC, urad] All masters pass values on as this project's loop does, so only the last bits
could differ; a value that comes one step late is off by up to 1 um."""


def needs(*distributions: str) -> pytest.MarkDecorator:
    """Return the mark that skips a test without its master, but not in CI, where it fails."""
    lost = [
        name for name in distributions if not next(metadata.Distribution.discover(name=name), None)
    ]
    reason = f"{', '.join(lost)} is not installed: pip install --editable '.[masters]'"
    return pytest.mark.skipif(bool(lost) and not os.environ.get("CI"), reason=reason)


def run(*command: object, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a program in *folder*, where it also unpacks what it unpacks."""
    return running.run(*command, folder=folder, TMPDIR=str(folder), **environment)


def example(name: str, *arguments: object, folder: Path) -> pd.DataFrame:
    """Run a script of ``docs/examples`` as its head says and return the table that it writes."""
    out = folder / "out.csv"
    done = run(sys.executable, EXAMPLES / name, *arguments, out, folder=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return pd.read_csv(out)


def agree(found: pd.DataFrame, reference: pd.DataFrame, tolerance: float = TOLERANCE) -> None:
    """Check that a master's table gives the reference at each of its times."""
    wanted = reference.set_index(reference["time"].round(6))
    found = found.set_index(found["time"].round(6)).drop(columns="time")
    assert len(found) >= STOP_S / STEP_S
    assert found.index[-1] == STOP_S
    assert {"error_X", "error_Y", "error_Z", "drift_Z"} <= set(found.columns)
    for name in found:
        off = (found[name] - wanted.loc[found.index, name]).abs()
        assert off.max() <= tolerance, f"{name} is off by {off.max():g} at {off.idxmax():g} s"


@pytest.fixture(scope="session", params=["native", pytest.param("python", marks=pytest.mark.long)])
def compensator(request: pytest.FixtureRequest) -> Path:
    """The compensator FMU, of either kind."""
    if request.param == "native":
        folder: Path = request.getfixturevalue("shipped_in_c")
        return folder / "compensator_native.fmu"
    folder = request.getfixturevalue("shipped")
    return folder / "compensator.fmu"


@pytest.fixture(scope="session")
def plant(compensator: Path) -> Path:
    """The plant FMU, of the kind of the compensator."""
    return compensator.with_name(compensator.name.replace("compensator", "plant"))


@pytest.fixture(scope="session")
def reference(plant: Path, compensator: Path) -> pd.DataFrame:
    """What `spindle-drift run` computes; columns are variables, by their names in the FMUs."""
    cases = read_scenario(SCENARIO, list(SETTINGS.items())).cases
    (case,) = (case for case in cases if case.name == VARIANT)
    frame = simulate(case, plant, compensator, quiet=True).frame
    # The compensator is at work, else equal tables would say little.
    assert frame["valid_1"].mean() > 0.99
    assert frame["dZ_um"].iloc[-1] > 10.0
    return frame.rename(columns=lambda column: column.rpartition("_")[0])


@pytest.fixture(scope="session")
def signals(reference: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The signals of the scenario at every communication point, as the examples read them."""
    path = tmp_path_factory.mktemp("signals") / "signals.csv"
    reference[["time", *INPUTS]].to_csv(path, index=False)
    return path


@pytest.fixture(scope="session")
def ssp(plant: Path, compensator: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scenario as an .ssp file."""
    path = tmp_path_factory.mktemp("ssp") / f"{SCENARIO}.ssp"
    settings = [f"--set={key}={value}" for key, value in SETTINGS.items()]
    arguments = ["ssp", SCENARIO, "--variant", VARIANT, "--fmu-dir", str(plant.parent)]
    if "native" not in compensator.name:  # else it is what is taken by itself
        arguments += ["--plant", str(plant), "--compensator", str(compensator)]
    assert main([*arguments, *settings, "-o", str(path)]) == 0
    with zipfile.ZipFile(path) as archive:
        for name in ("plant", "compensator", "signals"):
            fmu = zipfile.ZipFile(io.BytesIO(archive.read(f"resources/{name}.fmu")))
            in_c = "sources/instance.c" in fmu.namelist()
            assert in_c == ("native" in compensator.name), name
    return path
