"""The compensator FMU as a node of a CAN bus: readings in, offsets out."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import tempfile
from pathlib import Path
from typing import Any

from scenarios.outputs import LOG, STATE

NAME = "gateway"
HELP = "put the compensator FMU on a CAN bus"
READS = ("dbc", "map", "key", "compensator", "opcua_cert", "opcua_key", "opcua_trust")
WRITES = {"log": LOG, "state": STATE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    from gateway.options import add_bus_arguments
    from gateway.protocols import adapters

    add_bus_arguments(parser)
    parser.add_argument(
        "--compensator",
        default="compensator.fmu",
        metavar="FILE",
        help="an FMU or a compensator file (compensator.fmu)",
    )
    parser.add_argument(
        "--clock",
        choices=("own", "machine"),
        default="own",
        help="step by this computer's clock, or by the machine's time as its frames tell it",
    )
    parser.add_argument(
        "--speed-up",
        type=float,
        default=1.0,
        metavar="N",
        help="seconds of the compensator in a second of this computer's clock (1)",
    )
    parser.add_argument(
        "--startup-timeout",
        type=float,
        default=10.0,
        metavar="S",
        help="time for the interface to appear and the machine to be heard (10)",
    )
    parser.add_argument(
        "--cold-start",
        action="store_true",
        help="the machine is cold now: count the drift from its first readings",
    )
    parser.add_argument(
        "--ambient",
        metavar="NAME",
        help="ambient temperature input: a machine whose temperatures stay near it is cold",
    )
    parser.add_argument(
        "--together-band",
        type=float,
        default=1.0,
        metavar="K",
        help="how near: largest difference between them, and largest change [K] (1)",
    )
    parser.add_argument(
        "--together-time",
        type=float,
        default=1800.0,
        metavar="S",
        help="how long they must stay so, in the compensator's time [s] (1800)",
    )
    for adapter in adapters():
        adapter.add_arguments(parser)
    parser.add_argument(
        "--duration", type=float, metavar="S", help="end after this time [s] (when interrupted)"
    )
    parser.add_argument("--until-off", action="store_true", help="end when the machine is off")
    parser.add_argument(
        "--frames",
        action="store_true",
        help="print the frames and the bus load, check a map, and end",
    )


def run(args: argparse.Namespace) -> int:
    """Serve the bus until told to stop."""
    from gateway.database import DBC, read_database
    from gateway.mapcheck import problems_of
    from gateway.mappage import map_text
    from gateway.options import check_bus_arguments, check_positive, served, told
    from gateway.page import frames_text
    from gateway.protocols import adapters
    from scenarios.fmu_files import find_fmu

    protocols = [adapter(args) for adapter in adapters()]
    for protocol in protocols:
        protocol.check()
    if args.frames and args.map is None and args.canopen is None:
        print(frames_text(served(args, read_database(args.dbc or DBC))))
        return 0
    check_bus_arguments(args)
    check_positive("--speed-up", args.speed_up)
    check_positive("--startup-timeout", args.startup_timeout, zero=True)
    check_positive("--duration", args.duration)
    check_positive("--together-band", args.together_band)
    check_positive("--together-time", args.together_time)
    with contextlib.ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="spindle-drift-")))
        fmu = find_fmu(args.compensator, args.fmu_dir, Path(), work, quiet=args.quiet)
        for text in filter(None, (protocol.printed(fmu) for protocol in protocols)):
            print(text, end="")
            return 0
        found = (protocol.mapping(fmu) for protocol in protocols)
        mapping = next((one for one in found if one is not None), None)
        database = served(args, mapping.database if mapping else read_database(args.dbc or DBC))
        if mapping is not None:
            problems = problems_of(mapping, fmu, machine_clock=args.clock == "machine")
            if args.frames:
                print(map_text(mapping))
            if args.frames or problems:
                return told(problems)
        summary = _serve(args, database, fmu, mapping.unprotected() if mapping else [], protocols)
    if args.json:
        print(json.dumps(summary, indent=1))
    elif not args.quiet:
        frames = ", ".join(f"{count} {name}" for name, count in summary["frames"].items())
        print(f"{summary['steps']} steps in {summary['seconds']:.1f} s; frames: {frames or 'none'}")
    return 0


def _serve(
    args: argparse.Namespace, database: Any, fmu: Path, unprotected: list[str], protocols: list[Any]
) -> dict[str, Any]:
    from gateway.database import MACHINE
    from gateway.node import GatewaySettings
    from gateway.options import new_link, on_signal, stop_flag, teller
    from gateway.proof import read_key
    from gateway.reference import Proof
    from gateway.serving import Service
    from gateway.unit import CompensatorUnit

    printed = io.StringIO()
    with contextlib.ExitStack() as stack:
        say = stack.enter_context(teller("gateway", args))
        link = new_link(args, database, MACHINE, say)
        stack.callback(link.close)
        stopped = stack.enter_context(stop_flag(link.reopen_log))
        cold: list[bool] = []
        stack.enter_context(on_signal("SIGUSR1", lambda: cold.append(True)))
        link.open(args.startup_timeout)
        # A Python FMU shares this process's standard error; its complaints come through its log.
        stack.enter_context(contextlib.redirect_stderr(printed))
        unit = CompensatorUnit(fmu, say, printed)
        stack.push(lambda kind, error, trace: unit.close(error))
        say(f"{fmu.name} on {link.name}")
        for line in unprotected:
            say(line)
        joined = [protocol.join(database, fmu, unit, say) for protocol in protocols]
        participants = [participant for participant in joined if participant is not None]
        for participant in participants:
            stack.callback(participant.close)
        settings = GatewaySettings(
            args.clock == "machine",
            args.speed_up,
            args.startup_timeout,
            args.timeout and args.timeout / 1e3,
            Proof(args.cold_start, args.ambient or "", args.together_band, args.together_time),
            args.key and read_key(args.key),
        )
        service = Service(
            database,
            fmu,
            unit,
            link,
            settings,
            state_file=args.state,
            save_every_s=args.state_every,
            until_off=args.until_off,
            duration_s=args.duration,
            stopped=stopped,
            renewed=lambda: bool(cold) and cold.pop(),
            say=say,
            participants=participants,
        )
        return service.run()
