"""A place in which LinuxCNC runs beside others: namespaces of its own, and no root.

LinuxCNC refuses root, its keys and ports are fixed, and its own clean-up kills by name. In
namespaces of its own it sees no other, and its user is an ordinary one there, whoever started it.
The network is a loopback that carries multicast, which is the bus.
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
    while read -r word <"$bus"; do [ "$word" = up ] && up || ip link set lo down; done &
fi
exec unshare --user --map-user={USER} --map-group={USER} -- "$@"
"""
# It also ends with the program that began it, however that ends.
OUTSIDE = (
    "setpriv --pdeathsig KILL unshare --user --map-root-user --ipc --net --mount --pid --fork "
    "--kill-child --mount-proc sh -c"
)


def sandboxed(command: Sequence[str], bus: Path | None = None) -> list[str]:
    """Return the command that runs another one so; all that it started ends with it.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments.
    bus : Path, optional
        A pipe: ``down`` and ``up``, written to it, take the bus away and bring it back.
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
    """Refuse where LinuxCNC cannot run.

    Raises
    ------
    BadInput
        With the reason.
    """
    reason = problem()
    if reason:
        raise BadInput("LinuxCNC", "", reason)
