"""A sweep on a real Dask scheduler with workers of its own, on this computer."""

import os
import signal
import socket
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from measurement.errors import BadInput
from tests.patience import until

pytestmark = pytest.mark.skipif(not find_spec("distributed"), reason="Dask is not installed")

PATIENCE = {"distributed.comm.timeouts.connect": "500ms"}

CASES = 12


class Cluster:
    """A scheduler and workers, each a process; everything they write is under *folder*."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self.processes: list[subprocess.Popen[bytes]] = []
        host = ["--host", "127.0.0.1"]
        self._start("scheduler", *host, "--port", str(port), "--no-dashboard", "--no-show")

    def _start(self, kind: str, *words: str) -> subprocess.Popen[bytes]:
        name = f"{kind}_{len(self.processes)}"
        with (self.folder / f"{name}.log").open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", kind, *words],
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        self.processes.append(process)
        return process

    def worker(self) -> subprocess.Popen[bytes]:
        folder = str(self.folder / f"worker_{len(self.processes)}")
        words = ["--nthreads", "2", "--no-nanny", "--no-dashboard", "--local-directory", folder]
        return self._start("worker", self.address, *words)

    def until_joined(self, count: int) -> None:
        """Wait for workers: one that is not there yet cannot lose anything."""
        logs = self.folder.glob
        until(lambda: sum("Registered to" in log.read_text() for log in logs("w*.log")) >= count)

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    folder = tmp_path / "dask"
    folder.mkdir()
    found = Cluster(folder)
    yield found
    found.close()


SWEPT = ("gain=1e-3..2e-3",)
MORE = {"repeat": CASES, "overrides": (("duration_s", 500.0),)}


def ended(out: Path) -> int:
    return len(list((out / "cases").glob("*.json"))) if out.is_dir() else 0


@pytest.mark.long
def test_a_worker_that_is_killed_loses_nothing_and_nothing_counts_twice(
    cluster, sweep, tmp_path, monkeypatch
):
    from scenarios.sweep.store import Store

    victim, _ = cluster.worker(), cluster.worker()
    cluster.until_joined(2)
    kept: Counter[int] = Counter()
    record = Store.record

    def watched(store: Store, outcome: dict[str, Any]) -> None:
        record(store, outcome)
        kept[outcome["number"]] += 1
        if sum(kept.values()) == 3:
            os.kill(victim.pid, signal.SIGKILL)
            victim.wait()

    monkeypatch.setattr(Store, "record", watched)
    # The workers are given the FMUs: they do not read this folder.
    found = sweep("out", *SWEPT, **MORE, workers=None, cluster=cluster.address)
    assert victim.poll() == -signal.SIGKILL
    assert (found["cases"], found["failed"]) == (CASES, 0)
    assert kept == dict.fromkeys(range(CASES), 1)
    local = sweep("local", *SWEPT, **MORE)
    assert found == local
    for name in ("sweep.csv", "sweep.parquet", "percentiles.csv", "summary.json"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "local" / name).read_bytes()


def refusal(sweep: Any, address: str) -> str:
    """Return what a sweep on a cluster that does not answer in time is refused with."""
    from distributed import dask  # which has its settings then

    with dask.config.set(PATIENCE), pytest.raises(BadInput) as refused:
        sweep("out", *SWEPT, **MORE, workers=None, cluster=address)
    return str(refused.value)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense"])
def test_no_scheduler_is_one_line(sweep, address):
    answer = refusal(sweep, address)
    assert answer.startswith(f"--cluster: {address}: no Dask scheduler answers")


def test_a_scheduler_without_workers_is_one_line(cluster, sweep):
    def it_has_started() -> bool:
        answer = refusal(sweep, cluster.address)
        started = "no worker has joined in 500ms" in answer
        assert started or "no Dask scheduler answers" in answer
        return started

    until(it_has_started)
