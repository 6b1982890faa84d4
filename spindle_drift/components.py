"""Builds FMUs and co-simulates scenarios with them."""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import pandas as pd

from fmu_compensator.runtime.modelfile import model_text
from measurement.errors import BadInput
from measurement.runs import read_run
from plant_model.machine import Machine as MachineModel
from scenarios.building import Form, job_for
from scenarios.outputs import guarding
from scenarios.runner import run_scenario as run_scenario_files
from scenarios.scenario import read_scenario
from scenarios.table import Group
from spindle_drift._plots import plot_frames
from spindle_drift._refusals import refusing, refusing_methods
from spindle_drift.compensators import Compensator
from spindle_drift.machines import Machine

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@refusing
def build_fmu(
    source: Compensator | Machine | str | Path,
    out: str | Path = "dist",
    *,
    name: str | None = None,
    native: bool = False,
    fmi: Literal[2, 3] = 2,
    force: bool = False,
) -> Path:
    """Build an FMU; before it is written, it is validated and run in a fresh process.

    Parameters
    ----------
    source : Compensator, Machine or path
        A compensator or its file (``.json``); or a machine, its file, or a shipped name.
    out : path
        Folder for the FMU and its reference results; created if missing.
    name : str, optional
        Name of the FMU; ``compensator`` or ``plant`` by default.
    native : bool
        Build it in C99, without Python.
    fmi : {2, 3}
        FMI version; an FMU of version 3 is always without Python.
    force : bool
        Whether an FMU that this library did not make may be replaced.

    Returns
    -------
    Path
        The FMU.

    Raises
    ------
    BadInput
        If the source cannot be used, or another file is in the way.
    PublishError
        If the FMU fails validation or its run.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> runs = [sd.simulate("jig_borer", "training_down", every_s=60.0, noise_seed=1)]
    >>> sd.build_fmu(sd.fit(runs, model="mlr", machine="jig_borer"), name="mine").name
    'mine.fmu'
    """
    is_compensator = isinstance(source, Compensator) or str(source).endswith(".json")
    with (
        tempfile.TemporaryDirectory(prefix="spindle-drift-built-") as work,
        guarding("build_fmu", (), force),
    ):
        if is_compensator:
            given: Path | MachineModel = _file_of(source, Path(work))
        else:
            given = (source if isinstance(source, Machine) else Machine(str(source))).model
        usual = "compensator" if is_compensator else "plant"
        return job_for(given, Path(out), Form(native, fmi), name=name or usual).run()[1]


def _file_of(source: Any, work: Path) -> Path:
    """Return a compensator's file; a compensator in memory is written to *work* first."""
    if not isinstance(source, Compensator):
        return Path(source)
    file = work / "model.json"
    file.write_text(model_text(source.model.table), encoding="utf-8")
    return file


@refusing_methods
@dataclass(frozen=True)
class Scenario:
    """A co-simulated scenario.

    Attributes
    ----------
    folder : Path
        Time series, figures and ``report.html``.
    table : DataFrame
        For each variant the largest and mean absolute drift of the tool tip [um], and the
        improvement over no compensation [%].
    frames : dict of str to DataFrame
        The time series of each variant.
    details : dict
        Everything, as ``table.json`` holds it.
    """

    folder: Path
    table: pd.DataFrame
    frames: dict[str, pd.DataFrame]
    details: dict[str, Any]

    def plot(self) -> Figure:
        """Return a figure of the remaining error in each variant."""
        return plot_frames(self.frames)


@refusing
def run_scenario(
    scenario: str | Path,
    out: str | Path | None = None,
    *,
    settings: Mapping[str, Any] | None = None,
    plant: str | Path | None = None,
    compensator: str | Path | None = None,
    fmu_dir: str | Path = "dist",
    live: bool = False,
    force: bool = False,
) -> Scenario:
    """Simulate a scenario: plant and compensator FMU in closed loop.

    Parameters
    ----------
    scenario : str or path
        A name from ``spindle-drift list``, or a scenario file (TOML).
    out : path, optional
        Results folder (default: ``results/SCENARIO``).
    settings : mapping of str to any, optional
        Keys to set in the scenario, such as duration_s=3600 or signals.speed=6000.
    plant : path, optional
        Another plant: an FMU or a machine file.
    compensator : path, optional
        Another compensator: an FMU or a compensator file.
    fmu_dir : path
        Folder of the FMUs; ``plant.fmu`` and ``compensator.fmu`` are built there if missing.
    live : bool
        Also write a page in which both run live.
    force : bool
        Whether *out* may hold other files.

    Returns
    -------
    Scenario

    Raises
    ------
    BadInput
        If the scenario or its FMUs cannot be used; no folder is left behind.
    FmuError
        If an FMU fails; no folder is left behind.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> found = sd.run_scenario("step_speed", "results/hour", settings={"duration_s": 600})
    >>> sorted(path.name for path in found.folder.glob("*.html"))
    ['report.html']
    >>> bool((found.table["Z_better_percent"].iloc[1] > 50.0))
    True
    """
    read = read_scenario(str(scenario), list((settings or {}).items()))
    if read.settings.replay is not None:
        raise BadInput(read.path, "replay", "is no simulation: see Compensator.judge")
    folder = Path(out) if out is not None else Path("results") / read.settings.name
    files = [path for path in (plant, compensator) if path is not None]
    with guarding("run", files, force), contextlib.redirect_stderr(io.StringIO()):
        details, groups, _ = run_scenario_files(
            read,
            folder,
            Path(fmu_dir),
            plant=None if plant is None else str(plant),
            compensator=None if compensator is None else str(compensator),
            live=live,
            quiet=True,
        )
    details = json.loads(json.dumps(details))
    frames = {
        entry["name"]: read_run(folder / entry["files"]["results"]).frame
        for entry in details["variants"]
    }
    return Scenario(folder, _headline(groups), frames, details)


def _headline(groups: list[Group]) -> pd.DataFrame:
    rows = []
    for group in groups:
        for row in group.rows:
            cells: dict[str, Any] = {"group": group.title, "variant": row.label}
            for axis, cell in row.axes.items():
                cells[f"{axis}_max_um"] = cell.after_max_um
                cells[f"{axis}_mean_um"] = cell.after_mean_um
                cells[f"{axis}_better_percent"] = cell.improvement_percent
            rows.append(cells)
    return pd.DataFrame(rows)
