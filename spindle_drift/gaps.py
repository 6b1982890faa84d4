"""Finds what is missing in a machine's model."""

from __future__ import annotations

import atexit
import json
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from gap_finder.calibrate import Progress, quiet
from gap_finder.search import MOST_ADDITIONS, Search
from scenarios.gap_runner import GAP, check_search, run_find_gap
from scenarios.outputs import guarding
from spindle_drift._inputs import MachineLike, RunLike, as_runs
from spindle_drift._plots import plot_bars
from spindle_drift._refusals import refusing, refusing_methods
from spindle_drift.machines import Machine, as_machine

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@refusing_methods
@dataclass(frozen=True)
class Gap:
    """What a search found missing in a machine's model.

    Attributes
    ----------
    verdict : str
        ``effect``, ``one_of``, ``none_missing`` or ``unknown``.
    in_doubt : bool
        Whether the residuals exceed the tolerance even with what was named: something else is
        missing too, or what was named only resembles it.
    effects : list of str
        Names of the added effects.
    text : str
        The answer in a few lines.
    table : dict
        Everything, as ``gap.json`` holds it.
    machine : Machine
        The machine with the effects.
    folder : Path or None
        Folder of the report and figures.
    """

    verdict: str
    in_doubt: bool
    effects: list[str]
    text: str
    table: dict[str, Any] = field(repr=False)
    machine: Machine
    folder: Path | None

    def plot(self) -> Figure:
        """Return a figure of each channel's gap before and after, next to the noise floor."""
        channels = pd.DataFrame.from_dict(self.table["channels"], orient="index")
        shown = channels[["before", "after", "floor"]].astype(float)
        return plot_bars(shown, f"Gap by channel: {self.verdict}", "RMS of residual [K, µm]")


@refusing
def find_gap(
    machine: MachineLike,
    runs: Sequence[RunLike],
    holdout: Sequence[RunLike] = (),
    *,
    out: str | Path | None = None,
    without: Sequence[str] = (),
    most: int = MOST_ADDITIONS,
    effects_only: bool = False,
    seed: int = 0,
    workers: int | None = None,
    fmu: bool = False,
    split_hours: float | None = None,
    force: bool = False,
    progress: Progress = quiet,
) -> Gap:
    """Find where a machine's model and measured runs disagree, and name what is missing.

    Parameters
    ----------
    machine : Machine, path or name
        Page, machine file or shipped name.
    runs : sequence of Run, DataFrame or path
        Runs to calibrate on, three or more.
    holdout : sequence of Run, DataFrame or path
        Runs to judge by, used once at the end (default: the last of four or more *runs* is held
        out).
    out : path, optional
        Folder for report, figures and machine files.
    without : sequence of str
        Effects not to consider.
    most : int
        Largest number of additions.
    effects_only : bool
        Only add effects; do not change the machine's description.
    seed : int
        Seed of random starts.
    workers : int, optional
        Number of processes; one per core by default.
    fmu : bool
        Whether to build the plant FMUs before and after and to co-simulate the held-out runs.
    split_hours : float, optional
        Cut longer runs into pieces of this length [h], each starting where the previous one ended.
    force : bool
        Whether *out* may hold other files.
    progress : callable
        Called with what is being done.

    Returns
    -------
    Gap

    Raises
    ------
    BadInput
        If the runs cannot be used.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> from plant_model.effects import catalogue
    >>> others = [name for name in catalogue() if name != "centrifugal_shift"]
    >>> names = ["training_down", "training_random", "stop_and_go", "training_stops"]
    >>> runs = [sd.simulate("jig_borer_lumps", name, every_s=120.0, noise_seed=n)
    ...         for n, name in enumerate(names)]
    >>> gap = sd.find_gap("jig_borer_lumps", runs, without=others, workers=1)
    >>> gap.verdict
    'none_missing'
    >>> gap.machine.save("calibrated.toml").name
    'calibrated.toml'
    """
    search = Search(tuple(without), most, not effects_only, seed, workers)
    check_search(search, split_hours)
    given = as_machine(machine)
    used, kept_back = as_runs(runs), as_runs(holdout) if len(holdout) else []
    inputs = [run.path for run in (*used, *kept_back) if run.path is not None]
    with tempfile.TemporaryDirectory(prefix="spindle-drift-gap-") as work:
        folder = Path(out) if out is not None else Path(work) / "gap"
        with guarding("find-gap", inputs, force):
            _, lines = run_find_gap(
                *(given.model, given.source, used, kept_back, folder),
                search=search,
                fmu=fmu,
                split_hours=split_hours,
                say=progress,
            )
        table = json.loads((folder / GAP).read_text(encoding="utf-8"))
        source = folder / table["machine"]
        if out is None:  # the file outlives the folder: saving the machine reads it
            lasting = tempfile.mkdtemp(prefix="spindle-drift-gap-")
            atexit.register(shutil.rmtree, lasting, ignore_errors=True)
            source = Path(shutil.copy(source, lasting))
        after = Machine(source)
    shown = "\n".join(lines if out is not None else lines[:-1])
    names = [entry["name"] for entry in table["effects"]]
    kept = None if out is None else folder
    return Gap(table["verdict"], table["in_doubt"], names, shown, table, after, kept)
