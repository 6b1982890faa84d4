"""Power pulled while a state is written: ``python -m benchmarks.power_cut --cuts 100``.

A guest of user-mode-linux writes states, one after another, to an ext4 file system of its own, as a
gateway does. It is ended by ``kill -9`` at a random instant: what it had not given to its disk by
then is gone, as when the power goes, which killing a process does not show. The next guest mounts
the disk and says what it finds. Told is how often the state was missing, half-written or older than
the last one that was reported as written, and by how much.

It needs what the tests on a real bus need (Debian: user-mode-linux), and mkfs.ext4.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from tests.gateway.amx import preload
from tests.gateway.on_vcan import SYSTEM_PATH

ROOT = Path(__file__).resolve().parents[1]
DISK_BYTES = 64 * 2**20
STATE_BYTES = 40_000
"""About as large as the state of a gateway with 24 thermometers."""
LIVES_S = (0.5, 4.0)
"""A guest is ended so long after its first state was written [s]."""
BOOT_S = 120.0

INIT = """\
#!/bin/sh
export PATH={path}
mount -t proc proc /proc
mount -t devtmpfs devtmpfs /dev
mount -t tmpfs tmpfs /run
mkdir /run/disk
mount -t ext4 /dev/ubda /run/disk
cd {root}
PYTHONPATH={root} {python} -m benchmarks.power_cut --write /run/disk --tell {told}
"""


@dataclass
class Found:
    """What the disk held after the cuts so far."""

    cuts: int = 0
    missing: int = 0
    half: int = 0
    behind: int = 0
    most_behind: int = 0

    def take(self, on_disk: str, told: int) -> None:
        """Take in what was on the disk after one cut, and the last count reported before it."""
        self.cuts += 1
        if not on_disk:
            self.missing += 1
            return
        try:
            count = whole_count(on_disk)
        except ValueError:
            self.half += 1
            return
        self.behind += count < told
        self.most_behind = max(self.most_behind, told - count)


def state_of(count: int) -> str:
    """Return a state that shows whether it is whole."""
    return json.dumps({"count": count, "filling": f"{count:08d}" * (STATE_BYTES // 8)})


def whole_count(text: str) -> int:
    """Return the count of a state.

    Raises
    ------
    ValueError
        If it is not whole.
    """
    table = json.loads(text)
    if text != state_of(int(table["count"])):
        raise ValueError("its parts are not of one state")
    return int(table["count"])


def write_for_ever(disk: Path, told: Path) -> None:
    """Report what the disk holds, then write states until the power goes."""
    from measurement.files import write_atomically

    state = disk / "state.json"
    told.with_suffix(".found").write_text(state.read_text() if state.exists() else "")
    count = 0
    while True:
        count += 1
        write_atomically(state, state_of(count))
        # This file lies on the computer around the guest, which keeps its power.
        told.write_text(str(count))


def one_life(image: Path, folder: Path, environment: dict[str, str], life_s: float) -> str:
    """Boot a guest, let it write for a while and cut its power; return what its disk held."""
    told = folder / "told"
    told.unlink(missing_ok=True)
    script = folder / "init.sh"
    script.write_text(
        INIT.format(
            path=SYSTEM_PATH,
            root=shlex.quote(str(ROOT)),
            python=shlex.quote(sys.executable),
            told=shlex.quote(str(told)),
        )
    )
    script.chmod(0o755)
    boot = [
        *("linux.uml", "mem=512M", "rootfstype=hostfs", "rootflags=/", "rw", f"ubd0={image}"),
        *(f"init={script}", "con0=fd:0,fd:1", "con=null"),
    ]
    with (folder / "console").open("wb") as console:
        guest = subprocess.Popen(
            boot,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=console,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            begun = time.monotonic()
            while not told.exists():
                if time.monotonic() - begun > BOOT_S or guest.poll() is not None:
                    text = (folder / "console").read_text(errors="replace")
                    raise SystemExit(f"the guest wrote nothing:\n{text[-3000:]}")
                time.sleep(0.02)
            time.sleep(life_s)
        finally:
            os.killpg(guest.pid, 9)
            guest.wait()
    return told.with_suffix(".found").read_text()


def main() -> int:
    """Cut the power again and again and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cuts", type=int, default=20, help="how often (20)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--tell", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.write:
        write_for_ever(args.write, args.tell)
    missing = [
        name for name in ("linux.uml", "mkfs.ext4") if not shutil.which(name, path=SYSTEM_PATH)
    ]
    if missing:
        raise SystemExit(f"cannot be done here: {', '.join(missing)} missing")
    rng = random.Random(args.seed)
    found = Found()
    with tempfile.TemporaryDirectory(prefix="spindle-drift-power-") as name:
        folder = Path(name)
        image = folder / "disk"
        with image.open("wb") as stream:
            stream.truncate(DISK_BYTES)
        subprocess.run(["/usr/sbin/mkfs.ext4", "-q", str(image)], check=True)
        environment = os.environ | {"PATH": SYSTEM_PATH} | preload(folder)
        last = 0
        for life in tqdm(range(args.cuts + 1), unit="cut"):
            on_disk = one_life(image, folder, environment, rng.uniform(*LIVES_S))
            if life:
                found.take(on_disk, last)
            last = int((folder / "told").read_text() or 0)
    print(
        f"power cut {found.cuts} times while states of {STATE_BYTES:,} bytes were written: "
        f"{found.half} half-written, {found.missing} missing, {found.behind} older than the last "
        f"one reported as written, by at most {found.most_behind}"
    )
    return 1 if found.half or found.missing else 0


if __name__ == "__main__":
    sys.exit(main())
