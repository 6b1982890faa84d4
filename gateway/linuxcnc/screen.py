"""A picture of LinuxCNC's own screen while its axes are compensated, on a display without a screen.

``python -m gateway.linuxcnc.screen PICTURE PLANT_FMU COMPENSATOR_FMU``; it needs Debian's xvfb."""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from gateway.linuxcnc.day import program
from gateway.linuxcnc.folder import NAME, write_folder
from gateway.linuxcnc.sandbox import sandboxed
from gateway.linuxcnc.session import running
from gateway.linuxcnc.study import BUS

SIZE = (738, 720)
SPEED_UP = "60"
DISPLAY = ":7"
WORK_S = 40.0
"""The picture is taken so long after the program began [s]."""


def main(argv: Sequence[str]) -> int:
    """Take the picture."""
    picture, plant, compensator = (Path(word).resolve() for word in argv)
    module = [sys.executable, "-m"]
    with tempfile.TemporaryDirectory(prefix="spindle-drift-") as name:
        folder = Path(name)
        thermal = [*module, "gateway.linuxcnc.component", "--name", NAME, *BUS]
        spindle = [*module, "gateway.linuxcnc.spindle", "--plant", str(plant)]
        spindle += ["--speed-up", SPEED_UP, "--duration", "600", "--out", str(folder / "run.csv")]
        commands = {"thermal": [*thermal, "--speed-up", SPEED_UP], "spindle": spindle}
        ini = write_folder(folder, "external", {**commands, "display": ["true"]})
        shown = "DISPLAY = ./display.sh\nOPEN_FILE = program.ngc"
        ini.write_text(ini.read_text().replace("DISPLAY = ./display.sh", shown))
        (folder / "program.ngc").write_text(program(1, 12000, 90.0))
        axis = '#!/bin/sh\necho $$ > display.pid\nexec axis "$@" > axis.txt 2>&1\n'
        (folder / "display.sh").write_text(axis)
        gateway = [*module, "scenarios.cli", "gateway", *BUS, "--speed-up", SPEED_UP]
        gateway += ["--compensator", str(compensator)]
        inside = [*module, "gateway.linuxcnc.screen", "--inside", name, json.dumps(gateway)]
        subprocess.run(sandboxed(inside), check=True)
        _save(folder / "screen.xwd", picture)
    return 0


def _inside(folder: Path, gateway: list[str]) -> None:
    size = f"{SIZE[0]}x{SIZE[1]}x24"
    screen = ["Xvfb", DISPLAY, "-screen", "0", size, "-fbdir", str(folder), "-nolisten", "tcp"]
    with subprocess.Popen(screen, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        time.sleep(5.0)
        os.environ["DISPLAY"] = DISPLAY
        with running(folder, gateway) as session:
            time.sleep(15.0)  # the screen comes later than the control
            session.switch_on()
            session.home()
            session.wait(lambda: session.signal("valid") == 1.0, "no offsets", 60.0)
            session.begin(folder / "program.ngc")
            time.sleep(WORK_S)
            shutil.copy(folder / "Xvfb_screen0", folder / "screen.xwd")
        server.terminate()


def _save(dump: Path, picture: Path) -> None:
    """Turn an X window dump of 32 bits a pixel into a picture."""
    from PIL import Image

    data = dump.read_bytes()
    head = struct.unpack(">25I", data[:100])
    width, height, line = head[4], head[5], head[12]
    begin = head[0] + 12 * head[19]
    raw = data[begin : begin + line * height]
    Image.frombytes("RGB", (width, height), raw, "raw", "BGRX", line).save(picture)


if __name__ == "__main__":
    if sys.argv[1] == "--inside":
        _inside(Path(sys.argv[2]), json.loads(sys.argv[3]))
    else:
        sys.exit(main(sys.argv[1:]))
