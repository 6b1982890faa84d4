"""The command line of ``python build_fmu.py``."""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from fmu_compensator.runtime.modelfile import ModelFileError
from fmu_packaging.native.compilers import CompileError, NativeError
from fmu_packaging.package import Package
from fmu_packaging.publish import PublishError, UnwritableError
from measurement.errors import BadInput
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from scenarios.arguments import add_parameters, parameters_of
from scenarios.building import DEFAULT_MACHINE, DEFAULT_MODEL, Form, Job, OnBus, job_for
from scenarios.outputs import guarding


def _summary(package: Package, path: Path, written: bool) -> dict[str, Any]:
    data = path.read_bytes()
    return {
        "name": package.name,
        "file": str(path),
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "guid": package.guid,
        "variables": len(package.slave.variables),
        "validation": "clean",
        "written": written,
        "note": package.note,
    }


def _line(entry: dict[str, Any]) -> str:
    state = "validated, reference run passed" if entry["written"] else "up to date"
    line = f"{entry['file']}: {state}, {entry['bytes'] / 1024:.0f} KiB, GUID {entry['guid']}"
    return f"{line}. {entry['note']}" if entry["note"] else line


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def _arguments(given: Sequence[str] | None) -> argparse.Namespace:
    parser = _Parser("build_fmu.py", description="Build the FMUs, validate them, try them out.")
    add = parser.add_argument
    add("--model", type=Path, default=DEFAULT_MODEL, help="compensator file (JSON)")
    text = "shipped machine's name or machine file (TOML)"
    add("--machine", default=DEFAULT_MACHINE, help=text)
    add("--only", choices=("compensator", "plant"), help="build one of them")
    add_parameters(
        parser, Form, *("native", "fmi", "arrays", "all_platforms", "leave_out", "dbc"),
        can={"nargs": "?", "const": "low"},
    )  # fmt: skip
    # In the working folder, where every command looks for FMUs.
    add("--out", type=Path, default=Path("dist"), help="folder (dist)")
    add("--name", help="name of the FMU, with --only")
    add("--force", action="store_true", help="write over FMUs that this program did not make")
    add("--json", action="store_true", help="print the summary as JSON")
    return parser.parse_args(given)


def _jobs(arguments: argparse.Namespace, on_bus: OnBus | None) -> list[Job]:
    form = Form(**parameters_of(arguments, Form))
    only = arguments.only or ("compensator" if form.can else None)
    if arguments.name is not None and only is None:
        raise BadInput("--name", "", "say which FMU it names, with --only")
    sources: list[Path | Machine] = []
    if only != "plant":
        sources.append(arguments.model)
    if only != "compensator":
        sources.append(read_machine(arguments.machine))
    with guarding("build_fmu", [arguments.model, arguments.machine], arguments.force):
        return [
            job_for(source, arguments.out, form, name=arguments.name, on_bus=on_bus)
            for source in sources
        ]


def main(given: Sequence[str] | None = None, on_bus: OnBus | None = None) -> int:
    """Build what the command line asks for; return the exit code.

    Parameters
    ----------
    given : sequence of str, optional
        The command line; by default that of the process.
    on_bus : callable, optional
        Adds the bus terminal for ``--can``.
    """
    arguments = _arguments(given)
    try:
        jobs = _jobs(arguments, on_bus)
    except (BadInput, ModelFileError, NativeError) as error:
        print(error, file=sys.stderr)
        return 2
    entries = []
    for job in jobs:
        try:
            entries.append(_summary(*job.run()))
        except UnwritableError as error:
            print(error, file=sys.stderr)
            return 2
        except (PublishError, NativeError, CompileError) as error:
            print(f"{job.recipe.identity.name}.fmu is not built:\n{error}", file=sys.stderr)
            return 1
        if not arguments.json:
            print(_line(entries[-1]))
    if arguments.json:
        print(json.dumps(entries, indent=1))
    return 0
