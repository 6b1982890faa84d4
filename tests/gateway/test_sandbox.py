"""The bus in LinuxCNC's sandbox."""

import os
import subprocess
from pathlib import Path

from benchmarks.linuxcnc import sandbox
from tests.running import cannot_run

ASKED = """
up() { ip link show lo | grep -q ',UP'; }
exec 3>"$0"; echo down >&3
while up; do sleep 0.05; done
sleep 0.3 # still open: the writer is slow
exec 3>&-; sleep 0.3
timeout 20 sh -c 'echo up >"$0"' "$0" || exit 2
until up; do sleep 0.05; done
"""


def test_the_bus_comes_back_after_a_slow_writer(tmp_path: Path):
    if problem := sandbox.problem():
        cannot_run(problem)
    bus = tmp_path / "bus"
    os.mkfifo(bus)
    command = sandbox.sandboxed(["timeout", "60", "sh", "-c", ASKED, str(bus)], bus)
    assert subprocess.run(command, check=False).returncode == 0
