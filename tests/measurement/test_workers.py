"""The gap finder's processes end with it, whatever ends it."""

import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

from measurement.workers import workers
from tests.patience import PATIENCE_S, until

SCRIPT = '''
import os, struct, sys, time
import numpy as np
from scenarios import cli
from measurement.workers import workers

def torn():
    """Begin to send a result, and end it never."""
    results = sys._getframe(1).f_locals["result_queue"]
    os.write(results._writer.fileno(), struct.pack("!i", 1000))
    time.sleep(3600.0)

def work(_):
    with workers(2) as pool:
        # More than a pipe holds, so that the thread that feeds the workers is stuck in it.
        jobs = [pool.submit(time.sleep, 3600.0), pool.submit(torn)]
        jobs += [pool.submit(np.sum, np.zeros(1_000_000)) for _ in range(8)]
        time.sleep(0.2)
        print(*(process.pid for process in pool._processes.values()), flush=True)
        return jobs[0].result()

cli._run = work
sys.exit(cli.main([]))
'''


def alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="processes are looked up in /proc")
@pytest.mark.parametrize(
    ("number", "group", "code"),
    [
        (signal.SIGTERM, False, 143),
        (signal.SIGTERM, True, 143),
        (signal.SIGINT, True, 130),
        (signal.SIGKILL, False, -9),
    ],
)
def test_workers_end_with_what_started_them(number, group, code):
    with subprocess.Popen(
        [sys.executable, "-c", SCRIPT],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        pids = [int(word) for word in process.stdout.readline().split()]
        assert len(pids) == 2
        assert all(alive(pid) for pid in pids)
        (os.killpg if group else os.kill)(process.pid, number)
        assert process.wait(PATIENCE_S) == code, process.stderr and process.stderr.read()
        assert "Traceback" not in process.stderr.read()
    until(lambda: not any(alive(pid) for pid in pids))


def test_a_pool_gives_results_and_passes_on_what_fails():
    with workers(1) as pool:
        assert pool.submit(np.sum, np.ones(3)).result() == 3.0
        processes = list(pool._processes.values())
    assert not any(process.is_alive() for process in processes)
    before = set(threading.enumerate())
    with pytest.raises(ZeroDivisionError), workers(1) as pool:
        pool.submit(divmod, 1, 0).result()
    assert set(threading.enumerate()) <= before
