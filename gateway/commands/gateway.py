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
    from gateway.options import add_bus_arguments, add_number
    from gateway.protocols import adapters

    add = parser.add_argument
    add_bus_arguments(parser)
    text = "an FMU or a compensator file (compensator.fmu)"
    add("--compensator", default="compensator.fmu", metavar="FILE", help=text)
    text = "step by this computer's clock, or by the machine's time as its frames tell it"
    add("--clock", choices=("own", "machine"), default="own", help=text)
    text = "seconds of the compensator in a second of this computer's clock"
    add_number(parser, "--speed-up", "N", text, 1.0)
    text = "time for the interface to appear and the machine to be heard"
    add_number(parser, "--startup-timeout", "S", text, 10.0, zero=True)
    text = "the machine is cold now: count the drift from its first readings"
    add("--cold-start", action="store_true", help=text)
    text = "ambient temperature input: a machine whose temperatures stay near it is cold"
    add("--ambient", metavar="NAME", help=text)
    text = "how near: largest difference between them, and largest change [K]"
    add_number(parser, "--together-band", "K", text, 1.0)
    text = "how long they must stay so, in the compensator's time [s]"
    add_number(parser, "--together-time", "S", text, 1800.0)
    for adapter in adapters():
        adapter.add_arguments(parser)
    add_number(parser, "--duration", "S", "end after this time [s] (when interrupted)")
    add("--until-off", action="store_true", help="end when the machine is off")
    text = "print the frames and the bus load, check a map, and end"
    add("--frames", action="store_true", help=text)


def run(args: argparse.Namespace) -> int:
    """Serve the bus until told to stop."""
    from gateway.mapcheck import problems_of
    from gateway.options import as_served, report
    from gateway.page import frames_text
    from gateway.protocols import adapters
    from gateway.protocols.frames import frames_of
    from scenarios.fmu_files import find_fmu

    protocols = [adapter(args) for adapter in adapters()]
    for protocol in protocols:
        protocol.check()
    if args.frames and args.map is None and args.canopen is None:
        mapping = frames_of(None, args.dbc)
        mapping.database = as_served(args, mapping.database)
        print(frames_text(mapping))
        return 0
    with contextlib.ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="spindle-drift-")))
        fmu = find_fmu(args.compensator, args.fmu_dir, Path(), work, quiet=args.quiet)
        for text in filter(None, (protocol.printed(fmu) for protocol in protocols)):
            print(text, end="")
            return 0
        mappings = (protocol.mapping(fmu) for protocol in protocols)
        mapping = next(mapping for mapping in mappings if mapping is not None)
        mapping.database = as_served(args, mapping.database)
        problems = problems_of(mapping, fmu, machine_clock=args.clock == "machine")
        if args.frames:
            print(frames_text(mapping))
        if args.frames or problems:
            return report(problems)
        summary = _serve(args, mapping.database, fmu, mapping.unprotected(), protocols)
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
    from gateway.options import on_bus, on_signals
    from gateway.proof import read_key
    from gateway.reference import Proof
    from gateway.serving import Service
    from gateway.unit import CompensatorUnit

    printed = io.StringIO()
    with contextlib.ExitStack() as stack:
        cold: list[bool] = []
        stack.enter_context(on_signals(["SIGUSR1"], lambda *_: cold.append(True)))
        bus = on_bus("gateway", args, database, MACHINE, args.startup_timeout)
        say, link, stopped = stack.enter_context(bus)
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
