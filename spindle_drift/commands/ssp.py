"""Write a scenario with its FMUs as one .ssp file, which other co-simulation tools can run.

The file contains both FMUs, a third that plays the scenario's signals, and SystemStructure.ssd with
the connections by equal names, the plant's parameters and the step. If a C compiler is available,
all FMUs are in C, and with --ssp 2 of FMI 3.0.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import tempfile
from pathlib import Path
from typing import Any

from fmu_packaging.native.build import Fmi
from fmu_packaging.native.compilers import Compiler, NativeError, compilers
from measurement.files import write_atomically
from scenarios.arguments import add_json, add_parameters
from scenarios.assignments import assignment
from scenarios.fmu_files import check_fmus, find_fmu, fmus_of, needs_no_host
from scenarios.outputs import SSP, check_output
from scenarios.scenario import Settings, read_scenario
from scenarios.ssp.package import case_of, ssp_bytes
from spindle_drift._options import add_scenario

NAME = "ssp"
HELP = "write a scenario with its FMUs as one .ssp file for other tools"
READS = ("scenario", "plant", "compensator", "settings")
WRITES = {"out": SSP}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_scenario(parser)
    parser.add_argument(
        "-o", "--out", type=Path, metavar="FILE", help="the .ssp file (dist/<scenario>.ssp)"
    )
    add_parameters(parser, case_of, variant={"metavar": "NAME"})
    add_parameters(parser, ssp_bytes, "ssp")
    add_json(parser, "say what was written as JSON")


def run(args: argparse.Namespace) -> int:
    """Build missing FMUs, write the file, and print what is in it."""
    scenario = read_scenario(args.scenario, [assignment(text) for text in args.settings])
    case = case_of(scenario, args.variant)
    settings = case.settings
    near = scenario.path.resolve().parent
    out = args.out
    if out is None:
        args.fmu_dir.mkdir(parents=True, exist_ok=True)
        out = args.fmu_dir / f"{settings.name}.ssp"
        check_output(out, SSP)
    with tempfile.TemporaryDirectory(prefix="spindle-drift-built-") as work:
        fmi: Fmi = 2 if args.ssp == 1 else 3
        names = fmus_of(case, args.plant, args.compensator)
        check_fmus(names[:1], names[1:], args.fmu_dir, near, ("2.0", "3.0")[: args.ssp])
        fmus = [
            find_fmu(name, args.fmu_dir, near, Path(work), native=True, everywhere=True, fmi=fmi)
            for name in names
        ]
        # The FMU that plays the signals should need no Python if the others do not.
        made = _compilers() if all(map(needs_no_host, fmus)) else []
        data = ssp_bytes(case, fmus[0], fmus[1] if len(fmus) > 1 else None, made, args.ssp)
    write_atomically(out, data)
    if args.json:
        print(json.dumps(_facts(out, case.name, settings, data)))
    else:
        print(
            f"{out}: {settings.name}, variant {case.name}, {settings.duration_s:g} s in steps of "
            f"{settings.step_s:g} s, {len(data) / 1024:.0f} KiB"
        )
    return 0


def _compilers() -> list[Compiler]:
    try:
        return compilers()
    except NativeError:  # no compiler, but the FMUs already exist
        return []


def _facts(out: Path, variant: str, settings: Settings, data: bytes) -> dict[str, Any]:
    return {
        "file": str(out),
        "scenario": settings.name,
        "variant": variant,
        "duration_s": settings.duration_s,
        "step_s": settings.step_s,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
    }
