"""Runs a sweep and writes its folder."""

from __future__ import annotations

import importlib.util
import json
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from tqdm import tqdm

from measurement.errors import BadInput
from measurement.files import write_atomically
from scenarios.runner import versions
from scenarios.sweep.plan import Plan, Request, plan
from scenarios.sweep.pool import cores, on_cores
from scenarios.sweep.store import Store
from scenarios.sweep.tables import case_table, over_time, summary
from scenarios.version import version

TABLE, BANDS, SUMMARY = "sweep", "percentiles.csv", "summary.json"


def run_sweep(
    request: Request,
    out: Path,
    fmu_dir: Path,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    quiet: bool = False,
) -> dict[str, Any]:
    """Run every case of a sweep that its folder does not have yet, and write the results.

    Parameters
    ----------
    request : Request
    out : Path
        New, empty, or the folder of the same sweep, which is then resumed.
    fmu_dir : Path
        Folder of FMUs named without a folder.
    workers : int, optional
        Number of processes (default: all cores).
    cluster : str, optional
        Address of a Dask scheduler, such as tcp://host:8786, instead of this computer's cores.
    quiet : bool
        No progress bar, no messages.

    Returns
    -------
    dict
        The content of ``summary.json``.

    Raises
    ------
    BadInput
        If the sweep cannot be run; finished cases stay in the folder.
    """
    if workers is not None and not 1 <= workers <= 1024:
        raise BadInput("--workers", "", f"{workers} is not allowed: 1 to 1024")
    if cluster and importlib.util.find_spec("distributed") is None:
        raise BadInput("--cluster", "", "needs dask: pip install 'spindle-drift[cluster]'")
    with tempfile.TemporaryDirectory(prefix="spindle-drift-built-") as work:
        planned = plan(request, fmu_dir, Path(work), version(), quiet=quiet)
        store = Store(out, planned)
        done = store.outcomes()
        # Failed cases are run again: the cause may be a full disk, not the case.
        left = [job for job in planned.jobs if done.get(job.number, {"problem": "?"})["problem"]]
        outcomes: Iterator[dict[str, Any]] = iter(())
        if left and cluster:
            from scenarios.sweep.cluster import on_cluster

            outcomes = on_cluster(left, planned.fmus, cluster, store.digest)
        elif left:
            count = min(workers or cores(), len(left))
            outcomes = on_cores(left, planned.fmus, count)
        with tqdm(
            total=len(planned.jobs),
            initial=len(planned.jobs) - len(left),
            desc=planned.scenario.settings.name,
            unit="case",
            disable=quiet or None,
        ) as bar:
            for outcome in outcomes:
                store.record(outcome)
                bar.update()
    return _written(planned, store.outcomes(), out)


def _written(planned: Plan, outcomes: Mapping[int, dict[str, Any]], out: Path) -> dict[str, Any]:
    table = case_table(planned, outcomes)
    bands = over_time(planned, outcomes)
    files = _tables(table, out)
    if not bands.empty:
        from scenarios.sweep.figure import draw  # only here: it loads Matplotlib

        write_atomically(out / BANDS, bands.to_csv(index=False, lineterminator="\n"))
        files += [BANDS, *draw(planned, table, bands, out)]
    facts = {
        "scenario": planned.identity["scenario"],
        "title": planned.scenario.settings.title,
        **summary(planned, table),
        "files": files,
        "versions": versions(),
    }
    text = json.dumps(facts, indent=1, allow_nan=False, ensure_ascii=False)
    write_atomically(out / SUMMARY, text + "\n")
    return facts


def _tables(table: pd.DataFrame, out: Path) -> list[str]:
    """Write the table as CSV, and as Parquet if pandas can; return the names of the files."""
    write_atomically(out / f"{TABLE}.csv", table.to_csv(index=False, lineterminator="\n"))
    if importlib.util.find_spec("pyarrow") is None:
        return [f"{TABLE}.csv"]
    write_atomically(out / f"{TABLE}.parquet", table.to_parquet(index=False))
    return [f"{TABLE}.csv", f"{TABLE}.parquet"]
