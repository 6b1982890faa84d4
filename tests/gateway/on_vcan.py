"""Run the tests marked vcan: ``python tests/gateway/on_vcan.py [COMMAND …]``.

Where the kernel has vcan they run here. Otherwise they run in user-mode-linux, whose kernel has CAN
and boots in seconds as an ordinary process with this system's own files; on a processor with AMX it
needs a library that gcc builds. Where any of this is missing, it is said and nothing is run; under
CI that is a failure. Another command can be given instead of the tests. The exit status is the
command's.

The guest writes to this system's real files, with the rights of who started it.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MODULES = Path("/usr/lib/uml/modules")
NEEDED = ("linux.uml", "insmod", "ip", "cangen", "cansend")
TIME_S = float(os.environ.get("ON_VCAN_S", "600"))
PYTEST = [
    *(sys.executable, "-m", "pytest", "-m", "vcan", "-p", "no:cacheprovider"),
    *("--durations=8", "-q"),
]
SHARES = [
    tuple(f"tests/gateway/test_{name}.py" for name in ("vcan", "wire", "canopen")),
    (
        "tests/gateway/test_processes.py",
        "tests/gateway/test_robust.py",
        "tests/gateway/test_maps.py",
    ),
]
"""Files that hold tests marked vcan."""
SYSTEM_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"

INIT = """\
#!/bin/sh
# The first process of the guest.
export PATH={path}
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t tmpfs tmpfs /run
modules={modules}/$(uname -r)/kernel
for module in net/can/can net/can/can-raw net/can/can-bcm drivers/net/can/dev/can-dev \\
    drivers/net/can/vcan; do
    insmod "$modules/$module.ko"
done
ip link set lo up
ip link add dev vcan0 type vcan
ip link set vcan0 up
cd {root}
{environment}
{command} >{folder}/output 2>&1 </dev/null
# The console carries no exit status.
echo $? >{folder}/status
sync
halt -f -p
"""


def main(command: list[str]) -> int:
    """Run a command where there is a vcan0."""
    if (Path("/sys/class/net") / "vcan0").exists():
        command = command or [*PYTEST, "tests/gateway"]
        return subprocess.run(command, cwd=ROOT, check=False).returncode
    missing = [name for name in NEEDED if not shutil.which(name, path=SYSTEM_PATH)]
    if missing or not MODULES.is_dir():
        what = f"no vcan0 here, and no user-mode-linux to have one in: {', '.join(missing)} missing"
        return _cannot(what)
    # A guest has one processor: the tests are shared out to two.
    commands = [command] if command else [[*PYTEST, *share] for share in SHARES]
    with tempfile.TemporaryDirectory(prefix="spindle-drift-vcan-") as name:
        folders = [Path(name) / str(number) for number in range(len(commands))]
        try:
            environment = _preload(Path(name))
        except (OSError, subprocess.CalledProcessError) as error:
            why = "a processor with AMX needs a library to boot user-mode-linux"
            return _cannot(f"no vcan0 here, and {why}: {error}")
        environment = os.environ | {"PATH": SYSTEM_PATH} | environment
        with ThreadPoolExecutor() as pool:
            return max(pool.map(_in_guest, commands, folders, [environment] * len(commands)))


def _preload(folder: Path) -> dict[str, str]:
    """Return what the guest's environment needs; ``amx_ptrace.c`` says why."""
    if "amx_tile" not in Path("/proc/cpuinfo").read_text(errors="replace").split():
        return {}
    library = folder / "amx_ptrace.so"
    source = Path(__file__).with_name("amx_ptrace.c")
    subprocess.run(["gcc", "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    return {"LD_PRELOAD": str(library)}


def _cannot(what: str) -> int:
    if os.environ.get("CI"):
        print(what, file=sys.stderr)
        return 1
    print(f"tests on a real bus are skipped: {what}")
    return 0


def _in_guest(command: list[str], folder: Path, environment: dict[str, str]) -> int:
    folder.mkdir()
    if command[: len(PYTEST)] == PYTEST:
        command = [*command, f"--basetemp={folder / 'tmp'}"]
    kept = {key: os.environ[key] for key in ("CI", "HOME", "LANG") if key in os.environ}
    kept |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(ROOT)}
    script = folder / "init.sh"
    script.write_text(
        INIT.format(
            path=shlex.quote(f"{Path(sys.executable).parent}:{SYSTEM_PATH}"),
            modules=MODULES,
            root=shlex.quote(str(ROOT)),
            environment="\n".join(f"export {k}={shlex.quote(v)}" for k, v in kept.items()),
            command=shlex.join(command),
            folder=folder,
        )
    )
    script.chmod(0o755)
    boot = [
        *("linux.uml", "mem=1G", "rootfstype=hostfs", "rootflags=/", "rw", f"init={script}"),
        *("con0=fd:0,fd:1", "con=null"),
    ]
    try:
        guest = subprocess.run(
            boot,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=TIME_S,
            check=False,
        )
        console = guest.stdout.decode(errors="replace")
    except subprocess.TimeoutExpired as error:
        console = f"{(error.stdout or b'').decode(errors='replace')}\nnot done in {TIME_S} s"
    output, status = folder / "output", folder / "status"
    if output.exists():
        print(output.read_text(errors="replace"), end="")
    if not status.exists():
        print(f"the guest did not come to its end:\n{console[-3000:]}", file=sys.stderr)
        return 1
    return int(status.read_text())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
