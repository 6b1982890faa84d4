"""The gateway's latency and largest load on a bus: python -m benchmarks.gateway_latency.

The gateway runs as a separate process. From the times at which the bus delivers frames to a third
node, it measures:

- the latency from the last temperature frame of a cycle to the offset frame of its answer, which
  includes two more frames of the cycle, checking it, a step of the FMU and encoding eight frames;
- the highest cycle rate at which every cycle gets a valid answer and nothing is lost.

For comparison, it measures bare python-can on the same bus in the same run: the time from a frame
to the reply of a process that only replies, and frames per second one way without loss.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path
from typing import Any

import can
import numpy as np

from benchmarks.results_page import as_table, parser_of, tell
from gateway.codec import Sender, Value, decode
from gateway.database import COMPENSATOR, MACHINE, Database
from gateway.mapping import read_database
from scenarios.assignments import options_of

ROOT = Path(__file__).resolve().parents[1]
KERNEL = ["socketcan", "vcan0"]
MULTICAST = ["udp_multicast", "239.74.163.2"]
HEAD = ("", "vcan0 in user-mode-linux", "`udp_multicast`")
ROWS = (
    "bare frame and reply, p50 / p99",
    "last temperature frame to offset frame, p50 / p99",
    "bare one way without loss",
    "loop without loss",
)
PING, PONG = 0x300, 0x301
RATES = [25, 50, 75, 100, 150, 200, 300, 400, 600, 800, 1200, 1600, 2400, 3200]
TRIES = 3
BLOCK = 50
ECHO = """
import json, sys, can
settings, BLOCK = json.loads(sys.argv[1]), int(sys.argv[2])
only = [{"can_id": 0x300, "can_mask": 0x7FF, "extended": False}]
with can.Bus(can_filters=only, **settings) as bus:
    print("ready", flush=True)
    count = 0
    while True:
        message = bus.recv(20.0)
        if message is None or message.data[7] == 2:
            break
        count += 1
        if message.data[7] == 0 or count % BLOCK == 0:
            bus.send(can.Message(arbitration_id=0x301, data=message.data, is_extended_id=False))
"""


class Bench:
    """The control's end of the bus, and a third node that receives all frames."""

    def __init__(self, settings: dict[str, Any]) -> None:
        self.database: Database = read_database()
        self.bus, self.ear = can.Bus(**settings), can.Bus(**settings)
        # Nothing reads this node's received frames, so filter them or they fill a queue.
        self.bus.set_filters([{"can_id": 0x7FF, "can_mask": 0x7FF, "extended": False}])
        self.sender = Sender(self.database, MACHINE)
        self.time_s = 0.0
        frames = self.database.of(MACHINE)
        self.last_reading = [
            frame for frame in frames if "T1" in frame.signals or "T11" in frame.signals
        ][-1].frame_id
        names = {frame.name: frame for frame in self.database.of(COMPENSATOR)}
        self.offsets = names["CompensatorOffsets"].frame_id
        self.heartbeat = names["CompensatorHeartbeat"]
        self.drawn = names["CompensatorChallenge"]
        self.challenge: int | None = None

    def close(self) -> None:
        """Leave the bus."""
        self.bus.shutdown()
        self.ear.shutdown()

    def send(self, step_s: float, state: str = "running") -> None:
        """Send a cycle."""
        values: dict[str, Value] = {f"T{n}": 20.0 for n in range(1, 12)}
        values |= {"speed": 3000.0, "tool_length": 150.0, "offset_use": "following"}
        values["thermal_state"] = "cold"
        values |= {"machine_state": state, "machine_time": self.time_s, "machine_step": step_s}
        for message in self.sender.messages(values, self.challenge):
            self.bus.send(message)
        self.time_s = round(self.time_s + step_s, 3)

    def hear(self, timeout_s: float) -> tuple[can.Message, dict[str, Any] | None] | None:
        """Return the next frame, and its content if it is the gateway's heartbeat."""
        message = self.ear.recv(timeout_s)
        if message is None:
            return None
        if message.arbitration_id == self.drawn.frame_id:
            self.challenge = int(decode(self.drawn, message.data).values["challenge"])
        if message.arbitration_id != self.heartbeat.frame_id:
            return message, None
        content = self.heartbeat.message.decode(bytes(message.data))
        assert isinstance(content, dict)
        return message, {name: str(value) for name, value in content.items()}

    def until(self, due: float) -> Iterator[tuple[can.Message, dict[str, Any] | None]]:
        """Yield the frames received until a time, and those still waiting then."""
        while (heard := self.hear(max(due - time.monotonic(), 0.0))) is not None:
            yield heard

    def drain(self, quiet_s: float = 0.3) -> None:
        """Discard waiting frames, and the idle gateway's frames for a while."""
        for _ in self.until(time.monotonic() + quiet_s):
            pass

    def begin(self) -> None:
        """Establish contact with the gateway."""
        until = time.monotonic() + 60.0
        while time.monotonic() < until:
            self.send(0.0, "starting")
            for _, content in self.until(time.monotonic() + 0.1):
                if content and content["bus_fault"] == "machine_not_running":
                    self.drain()
                    return
        raise SystemExit("the gateway does not answer")


def latency(bench: Bench, cycles: int) -> list[float]:
    """Return the latency of each of *cycles* consecutive cycles [s]."""
    found = []
    for _ in range(cycles):
        bench.send(0.1)
        asked = None
        while True:
            heard = bench.hear(1.0)
            if heard is None:
                raise SystemExit("a cycle was not answered")
            message, content = heard
            if message.arbitration_id == bench.last_reading:
                asked = message.timestamp
            elif message.arbitration_id == bench.offsets and asked is not None:
                found.append(message.timestamp - asked)
            if content is not None:
                break
        time.sleep(0.002)
    return found


def held(bench: Bench, rate: float, seconds: float) -> bool:
    """Return whether the gateway answers every cycle at a rate [1/s] without a fault."""
    count, told = round(rate * seconds), list[str]()
    begun = time.monotonic()
    for k in range(count):
        bench.send(0.1)
        heard = bench.until(begun + (k + 1) / rate)
        told += [content["bus_fault"] for _, content in heard if content]
    slow = time.monotonic() - begun > 1.05 * seconds
    heard = bench.until(time.monotonic() + 0.15)
    last = takewhile(lambda _: len(told) < count, heard)
    told.extend(content["bus_fault"] for _, content in last if content)
    answered, faults = len(told), sum(fault != "none" for fault in told)
    if answered >= count and faults == 0 and not slow:
        return True
    what = f"{answered} of {count} answered, {faults} of them with a fault"
    slow_too = ", the sender was too slow" if slow else ""
    print(f"  {rate:g} cycles/s: {what}{slow_too}", file=sys.stderr)
    return False


def bare(settings: dict[str, Any], cycles: int) -> tuple[list[float], float]:
    """Return the reply times [s] and the frames per second one way without loss, of python-can."""
    echo = subprocess.Popen(
        [sys.executable, "-c", ECHO, json.dumps(settings), str(BLOCK)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert echo.stdout is not None
    assert echo.stdout.readline().strip() == "ready"
    filters = [{"can_id": PONG, "can_mask": 0x7FF, "extended": False}]
    ping = can.Message(arbitration_id=PING, data=bytes(8), is_extended_id=False)
    times = []
    with can.Bus(can_filters=filters, **settings) as bus:
        for _ in range(cycles):
            begun = time.perf_counter()
            bus.send(ping)
            if bus.recv(1.0) is None:
                raise SystemExit("a bare frame was not replied to")
            times.append(time.perf_counter() - begun)
        # In blocks with one reply each, so that the receiver's queue never overflows.
        ping.data = bytearray(7) + b"\x01"
        begun, blocks = time.perf_counter(), 100
        for _ in range(blocks):
            for _ in range(BLOCK):
                bus.send(ping)
            if bus.recv(2.0) is None:
                raise SystemExit("frames were lost on the bare bus")
        rate = BLOCK * blocks / (time.perf_counter() - begun)
        ping.data = bytearray(7) + b"\x02"
        bus.send(ping)
    echo.wait(10.0)
    return times, rate


@contextlib.contextmanager
def gateway(arguments: list[str]) -> Iterator[None]:
    """Run a gateway in a separate process."""
    command = [sys.executable, "-m", "scenarios.cli", "gateway", *arguments]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(20.0)


def _in_ms(times: list[float]) -> str:
    """Return two percentiles with two digits each."""
    p50, p99 = np.percentile(times, [50, 99]) * 1e3
    return f"{p50:.2g} / {p99:.2g} ms"


def _highest(bench: Bench, seconds: float) -> float:
    """Return the highest rate held; a rate gets several tries, because computers are shared."""
    best, lost = 0.0, 0
    for rate in RATES:
        for _ in range(TRIES):
            _recover(bench)
            if held(bench, rate, seconds):
                best, lost = rate, 0
                break
        else:
            lost += 1
        if lost > 1:
            break
    return best


def _recover(bench: Bench) -> None:
    """Run slowly until the offsets are valid again."""
    for _ in range(400):
        bench.send(0.1)
        for _, content in bench.until(time.monotonic() + 0.02):
            if content and content["bus_fault"] == "none":
                bench.drain(0.02)
                return


def measured(bus: list[str], args: argparse.Namespace) -> dict[str, Any]:
    """Return a column of the table, and the cycles per second."""
    interface, channel, *options = bus
    settings = {"interface": interface, "channel": channel, **options_of(options)}
    given = ["--interface", interface, "--channel", channel]
    given += [word for option in options for word in ("--option", option)]
    given += ["--clock", "machine", "--fmu-dir", args.fmu_dir, "--quiet", "--timeout", "1000"]
    with contextlib.closing(Bench(settings)) as bench:
        times, one_way = bare(settings, args.cycles // BLOCK * BLOCK)
        with gateway(given):
            bench.begin()
            found = latency(bench, args.cycles)
            rate = _highest(bench, args.seconds)
    looped = f"{rate * len(bench.database.frames):,.0f} frames/s ({rate:g} cycles/s)"
    cells = [_in_ms(times), _in_ms(found), f"{one_way:,.0f} frames/s", looped]
    return {"rate": rate, "cells": cells}


def in_guest(bus: list[str], args: argparse.Namespace) -> dict[str, Any]:
    """Return the same for a kernel bus, in user-mode Linux if this kernel has none."""
    command = [sys.executable, str(ROOT / "tests" / "gateway" / "on_vcan.py"), sys.executable]
    command += ["-m", "benchmarks.gateway_latency", "--bus", *bus, "--fmu-dir", args.fmu_dir]
    command += ["--cycles", str(args.cycles), "--seconds", str(args.seconds)]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stdout)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def main() -> int:
    """Measure and print."""
    parser = parser_of(__doc__, "benchmarks.gateway_latency")
    parser.add_argument("--bus", nargs="+", help="interface, channel, options: of this one alone")
    parser.add_argument("--cycles", type=int, default=2000)
    parser.add_argument("--seconds", type=float, default=3.0, help="of each rate tried")
    parser.add_argument("--fmu-dir", default="dist")
    args = parser.parse_args()
    if args.bus:
        print(json.dumps(measured(args.bus, args)))
        return 0
    load = [os.getloadavg()[0]]
    found = [in_guest(KERNEL, args), measured(MULTICAST, args)]
    load.append(os.getloadavg()[0])
    rows = [
        [name, *cells] for name, *cells in zip(ROWS, *(one["cells"] for one in found), strict=True)
    ]
    spent = f"{os.cpu_count()} cores with a load of {min(load):.0f} to {max(load):.0f}."
    tell("gateway_latency", f"{as_table(HEAD, rows)}\n\n{spent}", write=args.write)
    nominal = 1.0 / read_database().closing(MACHINE).cycle_s
    return 0 if all(one["rate"] >= nominal for one in found) else 1


if __name__ == "__main__":
    sys.exit(main())
