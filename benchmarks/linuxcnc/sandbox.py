"""Runs LinuxCNC in separate namespaces and without root, so that several can run at once.

LinuxCNC refuses to run as root, its keys and ports are fixed, and its clean-up kills processes by
name. In separate namespaces it sees no other instance, and its user is always an ordinary one. The
network is a loopback with multicast, which is the bus.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from measurement.errors import BadInput

USER = "1000"
# Only the outer user may take the bus away and bring it back; the inner one asks for it.
INSIDE = f"""
up() {{ ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo; }}
up || exit
bus=$1; shift
if [ -p "$bus" ]; then
    # Opened both ways: a reader that met the same slow writer twice would end with it.
    while read -r word; do
        if [ "$word" = up ]; then up; else ip link set lo down; fi
    done <>"$bus" &
fi
exec unshare --user --map-user={USER} --map-group={USER} -- "$@"
"""
# The sandbox also ends when the program that started it ends, for any reason.
OUTSIDE = (
    "setpriv --pdeathsig KILL unshare --user --map-root-user --ipc --net --mount --pid --fork "
    "--kill-child --mount-proc sh -c"
)


def sandboxed(command: Sequence[str], bus: Path | None = None) -> list[str]:
    """Return the command that runs another in a sandbox; all processes started there end with it.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments.
    bus : Path, optional
        A pipe: writing ``down`` or ``up`` to it takes the bus away or brings it back.
    """
    pipe = "" if bus is None else str(bus)
    return [*shlex.split(OUTSIDE), INSIDE, "sh", pipe, *command]


@cache
def problem() -> str:
    """Return why LinuxCNC cannot run here; empty if it can."""
    for program, package in (
        ("linuxcnc", "linuxcnc-uspace"),
        ("unshare", "util-linux"),
        ("setpriv", "util-linux"),
        ("ip", "iproute2"),
    ):
        if shutil.which(program, path="/usr/bin:/bin:/usr/sbin:/sbin") is None:
            return f"{program} is not installed (package {package})"
    tried = subprocess.run(sandboxed(["true"]), capture_output=True, text=True, check=False)
    if tried.returncode:
        return f"no namespaces: {' '.join(tried.stderr.split())}"
    return ""


def check() -> None:
    """Refuse if LinuxCNC cannot run here.

    Raises
    ------
    BadInput
        With the reason.
    """
    reason = problem()
    if reason:
        raise BadInput("LinuxCNC", "", reason)
