"""Runs the cases of a sweep on a cluster: a Dask scheduler and its workers.

Every worker, including those that join later, gets the FMUs as a plugin, so the workers need the
packages but no shared folder. If a worker dies nothing is lost: the scheduler gives its cases to
another.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import dask
from distributed import Client, KilledWorker, WorkerPlugin, as_completed, get_worker
from distributed.comm.core import connect

from measurement.errors import BadInput, one_line
from measurement.files import write_atomically
from scenarios.sweep.case import failed, outcome_of
from scenarios.sweep.plan import Job
from scenarios.version import PROGRAM, version

OPTION = "--cluster"
PATIENCE = "distributed.comm.timeouts.connect"
"""Dask's own setting of how long a cluster may take to answer; also the time for a first worker.
"""
_alone = threading.Lock()  # an FMU shares its process: one case at a time, however many threads


class FmuStore(WorkerPlugin):
    """Puts FMUs into the folder of a worker.

    Parameters
    ----------
    fmus : mapping of str to Path
        By SHA-256.
    name : str
        Name of the plugin.
    """

    def __init__(self, fmus: Mapping[str, Path], name: str) -> None:
        self.name = name
        self.places: dict[str, Path] = {}
        self._content = {key: path.read_bytes() for key, path in fmus.items()}

    def setup(self, worker: Any) -> None:
        """Write the files, when the worker starts or the plugin arrives."""
        folder = Path(worker.local_directory) / PROGRAM
        for key, content in self._content.items():
            self.places[key] = write_atomically(folder / f"{key}.fmu", content)


def on_cluster(
    jobs: Sequence[Job], places: Mapping[str, Path], address: str, digest: str
) -> Iterator[dict[str, Any]]:
    """Yield the outcome of every job once, in the order in which they end.

    Parameters
    ----------
    jobs : sequence of Job
    places : mapping of str to Path
        The FMUs by SHA-256.
    address : str
        Address of the scheduler, for example ``tcp://10.0.0.5:8786``.
    digest : str
        Identifies this sweep's cases there.

    Raises
    ------
    BadInput
        If there is no scheduler or no worker, or a worker lacks these packages.
    """
    try:
        asyncio.run(_knock(address))
    except (OSError, ValueError, TypeError) as error:
        said = f"no Dask scheduler answers: {one_line(error)[:200]}"
        raise BadInput(OPTION, address, said) from None
    with Client(address, set_as_default=False) as client:
        try:
            client.wait_for_workers(1, timeout=dask.config.get(PATIENCE))
        except TimeoutError:
            waited = f"no worker has joined in {dask.config.get(PATIENCE)}"
            raise BadInput(OPTION, address, waited) from None
        store = FmuStore(places, f"{PROGRAM}-{digest[:12]}")
        try:
            client.register_plugin(store)
            yield from _outcomes(client, jobs, store.name)
        except ImportError as error:
            raise BadInput(OPTION, address, f"a worker lacks {PROGRAM}: {error}") from None
        finally:
            client.unregister_worker_plugin(store.name)


async def _knock(address: str) -> None:
    """Connect once, because a client that found no scheduler would not close cleanly."""
    comm = await connect(address)
    await comm.close()


def _outcomes(client: Any, jobs: Sequence[Job], store: str) -> Iterator[dict[str, Any]]:
    by_key = {f"{store}-{job.number}": job for job in jobs}
    futures = client.map(
        _on_worker,
        list(by_key.values()),
        key=list(by_key),
        store=store,
        expected=version(),
        pure=False,
    )
    for future in as_completed(futures, loop=client.loop):
        try:
            outcome = future.result()
        except KilledWorker as error:
            lost = f"{len(error.args[0]) if error.args else 'several'} workers died of it"
            outcome = failed(by_key[future.key], lost)
        yield outcome
        future.release()


def _on_worker(job: Job, *, store: str, expected: str) -> dict[str, Any]:
    if version() != expected:
        raise BadInput(
            OPTION, "", f"a worker has {PROGRAM} {version()}, and {expected} is needed there"
        )
    plugin: Any = get_worker().plugins[store]
    with _alone:
        return outcome_of(job, plugin.places)
