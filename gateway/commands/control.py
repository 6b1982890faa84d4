"""A working day at LinuxCNC: axes that compensate the spindle's drift, tool changes and faults."""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
from pathlib import Path
from typing import Any

from scenarios.outputs import FOLDER, PROGRAM

NAME = "control"
HELP = "run a simulated day on LinuxCNC, which moves its axes against the drift"
READS = ("compensator", "plant")
WRITES = {"out": FOLDER, "build": PROGRAM}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    from gateway.options import add_number

    add = parser.add_argument
    text = "a compensator file (the one that ships)"
    add("--compensator", type=Path, metavar="FILE", help=text)
    text = "an FMU or a machine file (plant.fmu)"
    add("--plant", default="plant.fmu", metavar="FILE", help=text)
    text = "the gateway beside the control, the component in C inside it, or both at once (both)"
    add("--by", choices=("both", "gateway", "component"), default="both", help=text)
    text = "the way in: LinuxCNC's external offsets, or 'offset' with 'limit2' (external)"
    add("--offsets", choices=("external", "own"), default="external", help=text)
    add("--parts", type=int, default=8, help="parts of the day (8)")
    add_number(parser, "--part", "S", "length of a part, on the wall", 60.0)
    add_number(parser, "--speed-up", "N", "thermal time is faster", 60.0)
    text = "only build the component in C of the compensator file"
    add("--build", type=Path, metavar="PROGRAM", help=text)
    add("--out", type=Path, default=Path("results/control"), metavar="DIR", help="results")
    add("--fmu-dir", type=Path, default=Path("dist"), metavar="DIR", help="where FMUs are (dist)")
    add("--json", action="store_true", help="print a summary as JSON")
    add("--quiet", action="store_true", help="say nothing")


def run(args: argparse.Namespace) -> int:
    """Run the day, or build the component."""
    from gateway.linuxcnc.native_component import build_component
    from measurement.errors import BadInput
    from scenarios.building import DEFAULT_MODEL

    if args.parts < 1:
        raise BadInput("--parts", "", f"{args.parts} is not allowed: 1 or more")
    compensator = args.compensator or DEFAULT_MODEL
    if args.build is not None:
        build_component(compensator, args.build)
        return 0
    summary = _run_days(args, compensator)
    if args.json:
        print(json.dumps(summary, indent=1))
    elif not args.quiet:
        for kind, figures in summary.items():
            print(
                f"{kind}: {figures['hours']:.1f} h, drift to {figures['drift_um']:.1f} um, nose "
                f"within {figures['error_um']:.2f} um, no jump above {figures['jump_um']:.2f} um, "
                f"{figures['left_after_clear_um']:.4f} um left after a clear"
            )
            if "blind_error_um" in figures:
                print(f"  {figures['blind_error_um']:.2f} um while held without a gateway")
        print(f"{args.out / 'nose.png'}")
    return 0


def _run_days(args: argparse.Namespace, compensator: Path) -> dict[str, Any]:
    from gateway.linuxcnc.picture import draw_days
    from gateway.linuxcnc.study import COMPONENT, GATEWAY, KINDS, Plan, run_days
    from scenarios.fmu_files import find_fmu
    from scenarios.results import results_folder, write_table

    plan = Plan(args.parts, args.part, args.speed_up, args.offsets)
    with (
        tempfile.TemporaryDirectory(prefix="spindle-drift-") as name,
        results_folder(args.out) as folder,
    ):
        work = Path(name)
        found = (
            find_fmu(str(fmu), args.fmu_dir, Path(), work, quiet=args.quiet, native=True)
            for fmu in (args.plant, compensator)
        )
        plant, fmu = found
        sources = {GATEWAY: fmu, COMPONENT: compensator}
        kinds = {kind: sources[kind] for kind in KINDS if args.by in ("both", kind)}
        noses = run_days(work, kinds, plant, plan)
        for kind in noses:
            shutil.copy(work / kind / "run.csv", folder / f"{kind}.csv")
            shutil.copy(work / kind / "events.json", folder / f"{kind}_events.json")
        draw_days(noses, folder / "nose.png")
        summary = {kind: nose.summary for kind, nose in noses.items()}
        write_table([], {"control": summary}, folder)
    return summary
