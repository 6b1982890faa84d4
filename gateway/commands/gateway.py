"""The compensator FMU as a node of a CAN bus: readings in, offsets out."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from gateway.database import MACHINE
from gateway.mapcheck import problems_of
from gateway.node import GatewaySettings
from gateway.options import ABOVE_ZERO, AT_LEAST_ZERO, add_bus_arguments, as_served, on_bus, report
from gateway.page import frames_text
from gateway.proof import read_key
from gateway.protocols import adapters
from gateway.protocols.frames import frames_of
from gateway.reference import Proof
from gateway.serving import Service
from gateway.unit import CompensatorUnit
from measurement.stops import on_signals
from scenarios.arguments import add_parameters, parameters_of
from scenarios.fmu_files import find_fmu
from scenarios.outputs import LOG, STATE

NAME = "gateway"
HELP = "put the compensator FMU on a CAN bus"
COMPENSATOR = "compensator.fmu"
READS = ("dbc", "map", "key", "compensator", "opcua_cert", "opcua_key", "opcua_trust")
WRITES = {"log": LOG, "state": STATE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add = parser.add_argument
    add_bus_arguments(parser)
    text = f"an FMU or a compensator file ({COMPENSATOR})"
    add("--compensator", metavar="FILE", help=text)
    text = "step by this computer's clock, or by the machine's time as its frames tell it"
    add("--clock", choices=("own", "machine"), default="own", help=text)
    add_parameters(
        parser,
        GatewaySettings,
        speed_up=ABOVE_ZERO | {"metavar": "N"},
        startup_s=AT_LEAST_ZERO | {"flag": "--startup-timeout"},
    )
    add_parameters(
        parser,
        Proof,
        said={"flag": "--cold-start"},
        ambient={"metavar": "NAME"},
        band_k=ABOVE_ZERO | {"flag": "--together-band"},
        time_s=ABOVE_ZERO | {"flag": "--together-time"},
    )
    for adapter in adapters():
        adapter.add_arguments(parser)
    add_parameters(parser, Service, "until_off", duration_s=ABOVE_ZERO)
    text = "print the frames and the bus load, check whether they suit --compensator, and end"
    add("--frames", action="store_true", help=text)


def run(args: argparse.Namespace) -> int:
    """Serve the bus until told to stop."""
    protocols = [adapter(args) for adapter in adapters()]
    for protocol in protocols:
        protocol.check()
    if args.frames and args.map is None and args.canopen is None and args.compensator is None:
        mapping = frames_of(None, args.dbc)
        mapping.database = as_served(args, mapping.database)
        print(frames_text(mapping))
        return 0
    with contextlib.ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="spindle-drift-")))
        named = args.compensator or COMPENSATOR
        fmu = find_fmu(named, args.fmu_dir, Path(), work, quiet=args.quiet)
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
        line = f"{summary['steps']} steps in {summary['seconds']:.1f} s; frames: {frames or 'none'}"
        print(line, file=sys.stderr)  # where the other lines for people go: registers are read
    return 0


def _serve(
    args: argparse.Namespace, database: Any, fmu: Path, unprotected: list[str], protocols: list[Any]
) -> dict[str, Any]:
    printed = io.StringIO()
    with contextlib.ExitStack() as stack:
        cold: list[bool] = []
        stack.enter_context(on_signals(["SIGUSR1"], lambda *_: cold.append(True)))
        bus = on_bus("gateway", args, database, MACHINE, args.startup_s)
        say, link, stopped = stack.enter_context(bus)
        # A Python FMU shares this process's standard error; its messages come through its log.
        stack.enter_context(contextlib.redirect_stderr(printed))
        unit = CompensatorUnit(fmu, say, printed)
        stack.push(lambda kind, error, trace: unit.close(error))
        say(f"{Path(args.compensator or fmu).name} on {link.name}")
        for line in unprotected:
            say(line)
        joined = [protocol.join(database, fmu, unit, say) for protocol in protocols]
        participants = [participant for participant in joined if participant is not None]
        for participant in participants:
            stack.callback(participant.close)
        settings = GatewaySettings(
            args.clock == "machine",
            args.speed_up,
            args.startup_s,
            args.timeout and args.timeout / 1e3,
            Proof(**parameters_of(args, Proof)),
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
            **parameters_of(args, Service, "until_off", "duration_s"),
            stopped=stopped,
            renewed=lambda: bool(cold) and cold.pop(),
            say=say,
            participants=participants,
        )
        return service.run()
