"""Reads runs, imports them from any recorder's log, and summarises them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import pandas as pd

from measurement.errors import BadInput
from measurement.importing.log import Imported, import_files
from measurement.importing.mapping import Mapping as Rules
from measurement.importing.mapping import adjusted, read_mapping
from measurement.iso230 import Summary, summarise
from measurement.rig import Rig, default_rig, rig_from_table
from measurement.runs import Run
from scenarios.imported import write_imported
from scenarios.outputs import guarding
from spindle_drift._inputs import MachineLike, RunLike, as_run
from spindle_drift._plots import plot_run
from spindle_drift._refusals import refusing, refusing_methods

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@refusing
def read_run(source: RunLike, name: str = "run") -> Run:
    """Read a run file, or check a frame of the same form.

    Parameters
    ----------
    source : path or DataFrame
        A run file, or a frame with ``time_s`` [s] first and columns such as ``T1_degC``.
    name : str
        Name of a frame in reports; a file has its own name.

    Returns
    -------
    Run
        With ``name``, ``frame``, ``temperatures``, ``displacements`` and ``resampled``.

    Raises
    ------
    BadInput
        For the first error: file, row, column, value and what is allowed.

    Examples
    --------
    >>> import pandas as pd
    >>> import spindle_drift as sd
    >>> frame = pd.DataFrame({"time_s": [0, 60, 120], "T1_degC": [20.0, 20.4, 20.7]})
    >>> run = sd.read_run(frame, name="monday")
    >>> run.name, run.temperatures, len(run.frame)
    ('monday', ['T1_degC'], 3)
    """
    return as_run(source, name)


@refusing_methods
@dataclass(frozen=True)
class ImportedLog:
    """The runs made from a log, and what was doubtful in it.

    Attributes
    ----------
    runs : list of Run
        In order of time.
    table : DataFrame
        Start, length and preceding rest [h] of each run, and whether it began warm.
    left_out : dict of str to str
        By header: why a column is not in the runs, and how to include it.
    doubts : dict of str to list of str
        By column: what its numbers contradict.
    notes : list of str
        What was ignored.
    asks : dict of str to str
        By header: displacements whose axis is unknown, and how to state it.
    """

    runs: list[Run]
    table: pd.DataFrame
    left_out: dict[str, str]
    doubts: dict[str, list[str]]
    notes: list[str]
    asks: dict[str, str]
    _imported: Imported = field(repr=False)
    _paths: tuple[Path, ...] = field(repr=False)

    def plot(self, which: int = 0) -> Figure:
        """Return a figure of one of the runs: temperatures, displacements, speed.

        Parameters
        ----------
        which : int
            Index of the run.
        """
        return plot_run(self.runs[which])

    def save(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """Write the run files and the mapping file, as ``spindle-drift import`` does.

        Parameters
        ----------
        folder : path
            Created if missing; other files in it stay, and so does an existing mapping file.
        force : bool
            Whether files that are in the way may be replaced.

        Returns
        -------
        list of Path
            The files written.

        Raises
        ------
        BadInput
            If a file is in the way.
        """
        target = Path(folder)
        with guarding("import", self._paths, force):
            fresh = force or not (target / "import.toml").exists()
            return write_imported(self._imported, self._paths, target, with_mapping=fresh)


@refusing
def import_log(
    files: str | Path | Sequence[str | Path],
    *,
    mapping: str | Path | None = None,
    units: Mapping[str, str] | None = None,
    axes: Mapping[str, str] | None = None,
    time: str | Mapping[str, object] | None = None,
    every_row_s: float | None = None,
    day_first: bool | None = None,
    timezone: str | None = None,
    split: Literal["pauses", "days", "none"] | None = None,
    pause_s: float | None = None,
    cold_after_s: float | None = None,
    every_s: float | None = None,
    **rules: object,
) -> ImportedLog:
    """Make runs from spreadsheets, text tables or logs of any recorder.

    Parameters
    ----------
    files : path or sequence of path
        Text tables, .xlsx, .xls, .ods, .tdms or .mf4: tables with the same columns are joined end
        to end, others side by side on one clock.
    mapping : path, optional
        Mapping file to follow, written by an earlier import.
    units : mapping of str to str, optional
        Unit of a column whose header has none, by header, such as 'T*=degC'.
    axes : mapping of str to str, optional
        Axis that a displacement measures, by header, such as 'Dia*=X', or -X if it grows towards
        -X.
    time : str or mapping, optional
        Time column, if it is not found.
    every_row_s : float, optional
        Time from row to row, such as 60s, for tables without a time column [s].
    day_first : bool, optional
        Read 03/04 as the 3rd of April.
    timezone : str, optional
        Time zone of local times, such as Europe/Berlin.
    split : {"pauses", "days", "none"}, optional
        Where a log is cut into runs (default: pauses); days also cuts at midnight.
    pause_s : float, optional
        A longer pause ends a run (default: 1800) [s].
    cold_after_s : float, optional
        A machine is cold after a longer rest (default: 28800) [s].
    every_s : float, optional
        Resample the rows to an even grid [s].
    **rules
        Other entries of a mapping file.

    Returns
    -------
    ImportedLog

    Raises
    ------
    BadInput
        For the first error.

    Examples
    --------
    >>> from pathlib import Path
    >>> import spindle_drift as sd
    >>> rows = "\\n".join(f"02.03.2026 07:{n:02d};{20 + n / 10:.1f};{n}".replace(".", ",", 3)
    ...                  .replace("02,03,", "02.03.") for n in range(9))
    >>> _ = Path("log.csv").write_text(f"Zeit;Lager [°C];Druck\\n{rows}\\n", encoding="utf-8")
    >>> log = sd.import_log("log.csv")
    >>> log.runs[0].name, list(log.runs[0].frame.columns)
    ('20260302_0700', ['time_s', 'Lager_degC'])
    >>> log.left_out["Druck"].startswith("it has no unit")
    True
    """
    paths = [Path(file) for file in ([files] if isinstance(files, (str, Path)) else files)]
    given = adjusted(
        read_mapping(Path(mapping)) if mapping is not None else Rules(),
        "import_log",
        time=time,
        every_row_s=every_row_s,
        day_first=day_first,
        timezone=timezone,
        split=split,
        pause_s=pause_s,
        cold_after_s=cold_after_s,
        every_s=every_s,
        **rules,
    )
    imported = import_files(paths, given, units, axes)
    doubts: dict[str, list[str]] = {}
    for column, text in imported.doubts:
        doubts.setdefault(column, []).append(text)
    rows = [
        (run.name, piece.starts, run.time_s[-1] / 3600.0, piece.rested_s / 3600.0, piece.warm)
        for run, piece in zip(imported.runs, imported.pieces, strict=True)
    ]
    pieces = pd.DataFrame(rows, columns=["run", "starts", "hours", "rested_h", "warm_start"])
    return ImportedLog(
        imported.runs,
        pieces,
        dict(imported.hints),
        doubts,
        list(imported.notes),
        dict(imported.asks),
        imported,
        tuple(paths),
    )


@refusing
def summary(
    run: RunLike, *, machine: MachineLike | None = None, ambient: str | None = None
) -> Summary:
    """Summarise a run in the terms of ISO 230-3.

    Parameters
    ----------
    run : Run, DataFrame or path
    machine : Machine, path or name, optional
        Machine that defines the displacements and the ambient column; without it the column names
        do.
    ambient : str, optional
        Column of the ambient temperature; by default that of the machine's input ``ambient``.

    Returns
    -------
    Summary
        With ``displacements``, ``temperatures``, ``findings``, ``text()`` and ``to_dict()``.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> found = sd.summary(sd.simulate("jig_borer", "step_speed", every_s=60.0))
    >>> round(found.duration_s / 3600.0, 1), found.temperatures["T2_degC"].rise > 1.0
    (8.0, True)
    """
    recorded = as_run(run)
    return summarise(
        recorded, rig_for(recorded, machine), ambient or _ambient_column(recorded, machine)
    )


def rig_for(run: Run, machine: MachineLike | None) -> Rig | None:
    """Return the machine's rig; without a machine, the one the column names define, or None."""
    from spindle_drift.machines import as_machine

    if machine is not None:
        model = as_machine(machine)
        return rig_from_table(model.model.rig, f"machine {model.name}")
    try:
        return default_rig(run)
    except BadInput:
        return None


def _ambient_column(run: Run, machine: MachineLike | None) -> str | None:
    """Return the column of the machine's input ``ambient``, or None if the run lacks it."""
    from spindle_drift.machines import as_machine

    inputs = () if machine is None else as_machine(machine).model.inputs
    column = next((entry.column for entry in inputs if entry.name == "ambient"), None)
    return column if column in run.frame.columns else None
