"""A gateway that is killed, and one that runs for long: python -m benchmarks.gateway_endurance.

Both parts run the shipped scenario as two processes on a bus, in step with each other.

- Killed: the gateway is ended by ``kill -9`` at random instants of a warm-up and started again,
  with its state and, in another run, without. Told is how far the Z offset is from that of the
  direct co-simulation while it is called valid.
- Long: both processes run for hours of machine time; told is how much memory they have at the
  beginning and at the end.
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measurement.runs import read_run
from scenarios.cosimulation import simulate
from scenarios.scenario import read_scenario

ROOT = Path(__file__).resolve().parents[1]
SCENARIO, STEP_S = "step_speed", 1.0
FIRST_S = 8.0
"""How long the first gateway and the last one live at least [s]."""
LIVES_S = (1.0, 16.0)
"""Every other gateway lives for a time between these: some are killed while they start [s]."""
KILLS_A_RUN = 20


class Pair:
    """The two ends of a bus as processes.

    Parameters
    ----------
    arguments : list of str
        What both commands are given: the bus, and where the FMUs are.
    """

    def __init__(self, arguments: list[str]) -> None:
        self._arguments = arguments

    @contextlib.contextmanager
    def machine(self, duration_s: float, *more: str) -> Iterator[subprocess.Popen[bytes]]:
        """Run a machine as fast as the gateway answers."""
        pace = ["--speed-up", "max", "--timeout", "2000", "--set", f"duration_s={duration_s:g}"]
        command = ["machine", SCENARIO, "--wait", "60", *pace, *more]
        with self._run(command) as process:
            yield process

    @contextlib.contextmanager
    def gateway(self, *more: str) -> Iterator[subprocess.Popen[bytes]]:
        """Run a gateway that steps by the machine's time."""
        with self._run(["gateway", "--clock", "machine", "--timeout", "2000", *more]) as process:
            yield process

    @contextlib.contextmanager
    def _run(self, command: list[str]) -> Iterator[subprocess.Popen[bytes]]:
        full = [sys.executable, "-m", "scenarios.cli", *command, *self._arguments, "--quiet"]
        process = subprocess.Popen(full, cwd=ROOT)
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()
            process.wait(30.0)


@dataclass
class Killed:
    """What came of a gateway that was killed again and again: rows, valid ones, kills, worst."""

    rows: int = 0
    valid_after: int = 0
    kills: int = 0
    worst_um: float = 0.0

    def add(self, other: Killed) -> None:
        """Take in another warm-up."""
        self.rows += other.rows
        self.valid_after += other.valid_after
        self.kills += other.kills
        self.worst_um = max(self.worst_um, other.worst_um)


def killed(
    pair: Pair, fmu_dir: Path, kills: int, rng: np.random.Generator, *, with_state: bool
) -> Killed:
    """Kill a gateway so many times in one warm-up and hold its offsets against the truth [um]."""
    done = 0
    with tempfile.TemporaryDirectory() as name:
        out, state = Path(name) / "run.csv", Path(name) / "state.json"
        more = ["--state", str(state), "--state-every", "0.5"] if with_state else []
        with pair.machine(28_800.0, "--out", str(out)) as machine:
            with pair.gateway(*more):
                time.sleep(FIRST_S)  # so that there is a warm-up to be lost
                time.sleep(float(rng.uniform(*LIVES_S)))
            done += 1
            while done < kills and machine.poll() is None:
                with pair.gateway(*more):
                    time.sleep(float(rng.uniform(*LIVES_S)))
                done += 1
            with pair.gateway(*more):
                time.sleep(FIRST_S)
                machine.terminate()
                machine.wait(60.0)
        over_bus = read_run(out).frame
    steps = len(over_bus) - 1
    overrides = [("duration_s", steps * STEP_S), ("step_s", STEP_S), ("record_s", STEP_S)]
    case = read_scenario(SCENARIO, overrides).cases[0]
    plant, compensator = fmu_dir / "plant.fmu", fmu_dir / "compensator.fmu"
    direct = simulate(case, plant, compensator, quiet=True).frame
    valid = over_bus["valid_1"].to_numpy() == 1.0
    if not valid.any():
        return Killed(len(valid), 0, done, 0.0)
    gone = np.flatnonzero(~valid & (np.arange(len(valid)) > np.flatnonzero(valid)[0]))
    after = np.arange(len(valid)) > (gone[0] if gone.size else len(valid))
    wrong = np.abs(over_bus["dZ_um"].to_numpy() - direct["dZ_um"].to_numpy())
    return Killed(len(valid), int((valid & after).sum()), done, float(wrong[valid].max()))


def memory_kb(process: subprocess.Popen[bytes]) -> int:
    """Return the memory that a process has in use [kB]."""
    lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def long(pair: Pair, hours: float) -> tuple[float, list[tuple[int, int]]]:
    """Return how long it took [s], and the memory of gateway and machine, ten times [kB]."""
    begun, found = time.monotonic(), []
    with pair.gateway("--until-off") as gateway, pair.machine(hours * 3600.0) as machine:
        time.sleep(8.0)
        while machine.poll() is None and gateway.poll() is None:
            with contextlib.suppress(OSError, StopIteration):
                found.append((memory_kb(gateway), memory_kb(machine)))
            time.sleep(2.0)
    if not found:
        raise SystemExit("the machine was at its end before anything could be measured")
    picked = [found[round(k * (len(found) - 1) / 9)] for k in range(10)]
    return time.monotonic() - begun, picked


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--interface", default="udp_multicast")
    parser.add_argument("--channel", default="239.74.163.2")
    parser.add_argument("--option", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--fmu-dir", type=Path, default=Path("dist"))
    parser.add_argument("--kills", type=int, default=5, help="of each kind (5)")
    parser.add_argument(
        "--state", choices=("with", "without", "both"), default="both", help="in the kills (both)"
    )
    parser.add_argument("--hours", type=float, default=2.0, help="of machine time (2)")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    bus = ["--interface", args.interface, "--channel", args.channel]
    bus += [word for option in args.option for word in ("--option", option)]
    pair = Pair([*bus, "--fmu-dir", str(args.fmu_dir)])
    kinds = {"with": (True,), "without": (False,), "both": (True, False)}[args.state]
    for with_state in kinds if args.kills else ():
        rng, whole = np.random.default_rng([args.seed, with_state]), Killed()
        # Each warm-up begins with a cold machine, and ends before the machine is warm.
        while whole.kills < args.kills:
            left = min(args.kills - whole.kills, KILLS_A_RUN)
            whole.add(killed(pair, args.fmu_dir, left, rng, with_state=with_state))
        what = "with its state" if with_state else "without a state"
        print(
            f"killed {whole.kills} times, started again {what}: {whole.rows:,} s of machine time, "
            f"{whole.valid_after:,} of them called valid after the first kill, dZ at most "
            f"{whole.worst_um:.2f} um from the direct co-simulation while valid",
            flush=True,
        )
    if args.hours:
        took, found = long(pair, args.hours)
        gateway, machine = zip(*found, strict=True)
        print(
            f"{args.hours:g} h of machine time in {took:.0f} s; memory from beginning to end [MB]: "
            f"gateway {', '.join(f'{kb / 1024:.1f}' for kb in gateway)}; "
            f"machine {', '.join(f'{kb / 1024:.1f}' for kb in machine)}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
