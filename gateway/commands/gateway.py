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
    from gateway.opcua import DEFAULT_URL
    from gateway.options import add_bus_arguments

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
    parser.add_argument(
        "--canopen", type=int, metavar="ID", help="be the CANopen node of this number (1 to 127)"
    )
    parser.add_argument(
        "--eds", action="store_true", help="print the CANopen node's data sheet, and end"
    )
    parser.add_argument(
        "--opcua",
        nargs="?",
        const=DEFAULT_URL,
        metavar="URL",
        help=f"show inputs, outputs and status by OPC UA, read-only ({DEFAULT_URL})",
    )
    parser.add_argument(
        "--opcua-cert", type=Path, metavar="FILE", help="the OPC UA server's certificate"
    )
    parser.add_argument(
        "--opcua-key", type=Path, metavar="FILE", help="key of the OPC UA server's certificate"
    )
    parser.add_argument(
        "--opcua-trust",
        type=Path,
        metavar="DIR",
        help="certificates of the clients that may read, or of those who signed them",
    )
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
    from gateway.mapcheck import node_eds, node_mapping, problems_of
    from gateway.mappage import map_text
    from gateway.options import check_bus_arguments, check_positive, read_frames, told
    from gateway.page import frames_text
    from scenarios.fmu_files import find_fmu

    database, mapping = read_frames(args)
    if args.frames and mapping is None and args.canopen is None:
        print(frames_text(database))
        return 0
    check_bus_arguments(args)
    check_positive("--speed-up", args.speed_up)
    check_positive("--startup-timeout", args.startup_timeout, zero=True)
    check_positive("--duration", args.duration)
    check_positive("--together-band", args.together_band)
    check_positive("--together-time", args.together_time)
    security = _security(args)
    with contextlib.ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="spindle-drift-")))
        fmu = find_fmu(args.compensator, args.fmu_dir, Path(), work, quiet=args.quiet)
        if args.eds:
            print(node_eds(args.canopen, fmu), end="")
            return 0
        if args.canopen is not None:
            mapping = node_mapping(args.canopen, fmu)
            database = mapping.database
        if mapping is not None:
            problems = problems_of(mapping, fmu, machine_clock=args.clock == "machine")
            if args.frames:
                print(map_text(mapping))
            if args.frames or problems:
                return told(problems)
        summary = _serve(args, database, fmu, mapping.unprotected() if mapping else [], security)
    if args.json:
        print(json.dumps(summary, indent=1))
    elif not args.quiet:
        frames = ", ".join(f"{count} {name}" for name, count in summary["frames"].items())
        print(f"{summary['steps']} steps in {summary['seconds']:.1f} s; frames: {frames or 'none'}")
    return 0


def _security(args: argparse.Namespace) -> Any:
    """Return what an OPC UA server is secured with; refuse one that is open to others."""
    from gateway.opcua import checked_url, security_of
    from measurement.errors import BadInput

    security = security_of((args.opcua_cert, args.opcua_key, args.opcua_trust))
    if args.opcua is not None:
        checked_url(args.opcua, security)
    elif security is not None:
        raise BadInput("--opcua-cert", "", "has no meaning without --opcua")
    if args.canopen is not None and (args.map is not None or args.dbc is not None):
        raise BadInput("--canopen", "", "has PDOs for frames: no --map, no --dbc")
    return security


def _serve(
    args: argparse.Namespace, database: Any, fmu: Path, unprotected: list[str], security: Any
) -> dict[str, Any]:
    from gateway.database import MACHINE
    from gateway.mapcheck import node_dictionary
    from gateway.node import GatewaySettings
    from gateway.opcua import hall_status
    from gateway.options import new_link, on_signal, stop_flag, teller
    from gateway.proof import read_key
    from gateway.reference import Proof
    from gateway.serving import Service
    from gateway.unit import CompensatorUnit, options_of

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
        hall = None
        if args.opcua is not None:
            hall = hall_status(args.opcua, security, unit, say)
            stack.callback(hall.close)
        node = None
        if args.canopen is not None:
            from gateway.canopen_node import CanOpenNode

            bus = {"interface": args.interface, "channel": args.channel}
            node = CanOpenNode(
                *(args.canopen, node_dictionary(args.canopen, fmu), database),
                bus | options_of(args.option),
                say,
            )
            stack.callback(node.close)
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
            say=say if hall is None else hall.also(say),
            hall=hall,
            canopen=node,
        )
        return service.run()
