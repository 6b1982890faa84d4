"""The other end of the bus: a control with the plant FMU behind it, or a recorded log."""

from __future__ import annotations

import argparse
import contextlib
import io
import tempfile
import time
from pathlib import Path
from typing import Any

from gateway.database import COMPENSATOR, MACHINE
from gateway.machine import AnswerReceiver, MachineNode, Pace
from gateway.options import AT_LEAST_ZERO, above_zero, add_bus_arguments, as_served, on_bus, report
from gateway.plant import MachinePlant
from gateway.proof import read_key
from gateway.protocols.frames import frames_of
from gateway.replay import recorded, replay
from measurement.errors import BadInput
from measurement.runs import write_run
from scenarios.arguments import add_parameters, tell
from scenarios.assignments import assignment
from scenarios.fmu_files import find_fmu
from scenarios.outputs import LOG, RUN_FILE, STATE
from scenarios.scenario import read_scenario

NAME = "machine"
HELP = "put a simulated machine, or a recorded log, on a CAN bus"
READS = ("scenario", "dbc", "map", "key", "replay", "plant")
WRITES = {"log": LOG, "state": STATE, "out": RUN_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add = parser.add_argument
    text = "a name from 'list', or a TOML file (step_speed); its first variant is run"
    add("scenario", nargs="?", default="step_speed", metavar="SCENARIO", help=text)
    add_bus_arguments(parser)
    text = "send the machine's frames of this log instead"
    add("--replay", type=Path, metavar="LOG", help=text)
    text = (
        "times as fast as real time (1); 'max': by the scenario's step, as fast as the gateway "
        "answers"
    )
    add("--speed-up", type=_speed_up, default=1.0, metavar="N", help=text)
    add("--plant", metavar="FILE", help="another plant: an FMU, a machine file or a machine")
    text = "set a key of the scenario, for example duration_s=60"
    add("--set", action="append", default=[], metavar="KEY=VALUE", help=text)
    add_parameters(parser, Pace, wait_s=AT_LEAST_ZERO, hold_s=AT_LEAST_ZERO)
    add("--out", type=Path, metavar="FILE", help="write the run as a table (CSV)")


def _speed_up(text: str) -> float | None:
    return None if text == "max" else above_zero(text)


def run(args: argparse.Namespace) -> int:
    """Run the machine to the end of its scenario or log."""
    mapping = frames_of(args.map, args.dbc)
    if mapping.problems:
        return report(mapping.problems)
    database = as_served(args, mapping.database)
    if args.speed_up is None and database.every_s is not None:
        raise BadInput("--speed-up", "max", "sampled frames do not say what they answer: a number")
    if args.replay is not None:
        for name, value in (("--out", args.out), ("--state", args.state), ("--plant", args.plant)):
            if value is not None:
                raise BadInput(name, "", "has no meaning with --replay")
        summary = _replay(args, database)
        text = f"{summary['frames']} frames sent"
    else:
        summary = _simulate(args, database)
        text = "{steps} steps, {answered} answered, {simulated_s:g} s in {seconds:.1f} s"
        text = text.format(**summary)
    return tell(args, summary, text)


def _replay(args: argparse.Namespace, database: Any) -> dict[str, Any]:
    messages = recorded(args.replay, database)
    with on_bus("machine", args, database, COMPENSATOR, args.wait_s) as (say, link, stopped):
        say(f"{args.replay.name}, {len(messages)} frames, on {link.name}")
        sent = replay(
            messages,
            database,
            link,
            AnswerReceiver(database, time.monotonic, args.timeout and args.timeout / 1e3),
            speed_up=args.speed_up,
            wait_s=args.wait_s,
            stopped=stopped,
            clock=time.monotonic,
        )
    return {"frames": sent}


def _simulate(args: argparse.Namespace, database: Any) -> dict[str, Any]:
    case, near = _case(args, database)
    printed = io.StringIO()
    with contextlib.ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="spindle-drift-")))
        name = args.plant or case.settings.plant.fmu
        fmu = find_fmu(name, args.fmu_dir, near, work, quiet=args.quiet)
        bus = on_bus("machine", args, database, COMPENSATOR, args.wait_s)
        say, link, stopped = stack.enter_context(bus)
        # A Python FMU shares this process's standard error; its messages come through its log.
        stack.enter_context(contextlib.redirect_stderr(printed))
        plant = MachinePlant(fmu, case, say, printed, recorded=args.out is not None)
        stack.push(lambda kind, error, trace: plant.close(error))
        say(f"{Path(name).name}, scenario {case.settings.name}, on {link.name}")
        key = args.key and read_key(args.key)
        store, saved = plant.slave.kept(args.state, say)
        plant.start(saved)
        if saved is not None:
            say(f"goes on at {plant.time_s:g} s from the state of {saved.age_s:.0f} s ago")
        first, begun = plant.point, time.monotonic()
        saved_at = begun

        def save() -> None:
            nonlocal saved_at
            if store is not None and time.monotonic() - saved_at >= args.state_every:
                store.write(store.now(), plant.time_s, plant.time_s, plant.slave.saved())
                saved_at = time.monotonic()

        timeout_s = args.timeout and args.timeout / 1e3
        pace = Pace(args.speed_up is None, args.wait_s, args.hold_s, timeout_s)
        node = MachineNode(database, plant, link, pace, save, stopped, key=key)
        if lacking := node.unread():
            problem = f"has no {', '.join(lacking)}, and its frames cannot say so"
            raise BadInput(name, "", f"{problem}: another --plant, or a missing_raw in the map")
        node.run()
        summary = {
            "steps": plant.point - first,
            "answered": node.answered,
            "simulated_s": (plant.point - first) * plant.step_s,
            "seconds": time.monotonic() - begun,
            "frames": dict(node.answers.reception.counts),
        }
        if args.out is not None:
            write_run(plant.frame(), args.out)
    return summary


def _case(args: argparse.Namespace, database: Any) -> tuple[Any, Path]:
    overrides = [assignment(text) for text in args.set]
    if args.speed_up is not None:
        step_s = (database.every_s or database.closing(MACHINE).cycle_s) * args.speed_up
        # The table from --out holds every step, however often the scenario records.
        overrides += [("step_s", step_s), ("record_s", step_s)]
    scenario = read_scenario(args.scenario, overrides)
    if not scenario.cases:
        raise BadInput(scenario.path, "replay", "nothing is simulated; see --replay for a log")
    case = scenario.cases[0]
    if not database.has("machine_step"):
        return case, scenario.path.resolve().parent
    signal = database.signal("machine_step")
    step_s, raw = case.settings.step_s, case.settings.step_s / signal.scale
    if abs(raw - round(raw)) > 1e-6 or not 0.0 < step_s <= signal.high:
        problem = (
            f"{step_s:g} is not allowed: a multiple of {signal.scale:g} s, "
            f"at most {signal.high:g} s"
        )
        raise BadInput(scenario.path, "step_s", problem)
    return case, scenario.path.resolve().parent
