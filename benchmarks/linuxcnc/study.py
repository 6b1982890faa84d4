"""A day at LinuxCNC, once with a gateway and once with the compensator inside the control."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.linuxcnc.folder import NAME, write_folder
from benchmarks.linuxcnc.nose import Nose, read_nose
from benchmarks.linuxcnc.sandbox import check, sandboxed
from gateway.linuxcnc.component import arguments_of
from gateway.linuxcnc.native_component import build_component
from measurement.errors import BadInput

BUS = ("--interface", "udp_multicast", "--channel", "239.74.163.2")
GATEWAY, COMPONENT = "gateway", "component"
ROOT = Path(__file__).resolve().parents[2]
HOLD_S = 5.0
"""How long offsets are held without a gateway, in real time [s]: set on no data."""


@dataclass(frozen=True)
class Plan:
    """A day.

    Attributes
    ----------
    parts : int
        Number of parts, each with a tool, a speed and a fault.
    part_s : float
        Length of a part, in real time [s].
    speed_up : float
        Thermal time relative to real time.
    way : {"external", "own"}
        How offsets are applied in the control.
    """

    parts: int = 8
    part_s: float = 60.0
    speed_up: float = 60.0
    way: str = "external"


def run_days(out: Path, kinds: Mapping[str, Path], plant: Path, plan: Plan) -> dict[str, Nose]:
    """Run a day for each kind, all at the same time.

    Parameters
    ----------
    out : Path
        A folder for each kind is made here.
    kinds : mapping of str to Path
        ``gateway`` with its FMU, ``component`` with its compensator file.
    plant : Path
        The plant FMU.
    plan : Plan

    Returns
    -------
    dict of str to Nose
        The motion of the nose, by kind.

    Raises
    ------
    BadInput
        If LinuxCNC cannot run here, or a day did not finish.
    """
    check()
    running = {}
    for kind, fmu in kinds.items():
        folder = (out / kind).resolve()
        folder.mkdir(parents=True)
        running[kind] = folder, _begin(folder, kind, fmu, plant.resolve(), plan)
    noses = {}
    try:
        for kind, (folder, process) in running.items():
            printed = process.communicate()[1].decode(errors="replace")
            if process.returncode:
                (folder / "error.txt").write_text(printed)
                last = printed.strip().rpartition("\n")[2]
                raise BadInput(folder, "", f"the day came to no end: {last}")
            noses[kind] = read_nose(folder, HOLD_S)
    finally:  # end all processes that could still write to a folder being removed
        for _, process in running.values():
            if process.poll() is None:
                process.kill()
                process.communicate()
    return noses


def _begin(folder: Path, kind: str, fmu: Path, plant: Path, plan: Plan) -> subprocess.Popen[bytes]:
    module = ["env", f"PYTHONPATH={ROOT}", sys.executable, "-m"]
    speed_up, slew, gateway = f"{plan.speed_up:g}", f"{arguments_of([]).slew:g}", []
    state = str(folder / "state")
    if kind == GATEWAY:
        thermal = [*module, "gateway.linuxcnc.component", "--name", NAME, *BUS]
        thermal += ["--offsets", plan.way, "--slew", slew, "--speed-up", speed_up]
        thermal += ["--hold", f"{HOLD_S * plan.speed_up:g}"]
        gateway = [*module, "scenarios.cli", "gateway", *BUS, "--speed-up", speed_up]
        gateway += ["--compensator", str(fmu.resolve()), "--state", state, "--state-every", "1"]
        os.mkfifo(folder / "bus")
    else:
        build_component(fmu, folder / "thermal")
        thermal = [str(folder / "thermal"), NAME, slew, speed_up, plan.way, state]
    most_s = 3.0 * plan.parts * plan.part_s + 600.0
    spindle = [*module, "benchmarks.linuxcnc.spindle", "--plant", str(plant)]
    spindle += ["--speed-up", speed_up]
    spindle += ["--duration", f"{most_s:g}", "--out", str(folder / "run.csv")]
    display = ["sh", "-c", "echo $$ > display.pid; exec sleep infinity"]
    write_folder(folder, plan.way, {"thermal": thermal, "spindle": spindle, "display": display})
    day = [*module, "benchmarks.linuxcnc.day", str(folder), "--parts", str(plan.parts)]
    day += ["--part", f"{plan.part_s:g}", "--hold", f"{HOLD_S:g}", "--gateway", json.dumps(gateway)]
    command = sandboxed(day, folder / "bus" if gateway else None)
    return subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
