"""Where the FMUs of a scenario come from: a file, the FMU folder, or built on the spot."""

from __future__ import annotations

import contextlib
import difflib
import json
import re
import sys
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

from measurement.errors import BadInput

SHIPPED = ("plant", "compensator")
PLANT = "plant.fmu"


def find_fmu(
    name: str, fmu_dir: Path, near: Path, work: Path, *, quiet: bool = False, native: bool = False
) -> Path:
    """Return the FMU that a scenario or a command line names.

    Parameters
    ----------
    name : str
        A path (from *near*, or from the working folder), a name in *fmu_dir*, a compensator file
        (``.json``) or a machine file (``.toml``); of the last two an FMU is built.
    fmu_dir : Path
        Where the built FMUs are; ``plant.fmu`` and ``compensator.fmu`` are built when missing.
    near : Path
        The scenario's folder.
    work : Path
        Where an FMU for this run alone may be built.
    quiet : bool
        Say nothing about building.
    native : bool
        Of a machine file, and of ``plant.fmu`` in *fmu_dir*, return the twin in C where it can be
        had: it gives the same results, faster. A path always means that very FMU.

    Raises
    ------
    BadInput
        If there is no such FMU and it cannot be built.
    """
    candidates = [near / Path(name).expanduser(), Path(name).expanduser(), fmu_dir / name]
    try:
        found = next((path for path in candidates if path.is_file()), None)
    except (OSError, ValueError) as error:
        raise BadInput(name, "", f"is not a path: {error}") from None
    if found is not None:
        if found.suffix == ".json":
            return build_compensator(found, work)
        if found.suffix == ".toml":
            python = build_plant(str(found), work)
            return native_twin(python, work, quiet=quiet) if native else python
        if native and found == fmu_dir / PLANT and found not in candidates[:2]:
            return native_twin(found, work, quiet=quiet)
        return found
    if Path(name).name == name and Path(name).stem in SHIPPED and name.endswith(".fmu"):
        built = build_shipped(Path(name).stem, fmu_dir, quiet=quiet)
        return native_twin(built, work, quiet=quiet) if native and name == PLANT else built
    known = [path.name for path in fmu_dir.glob("*.fmu")] if fmu_dir.is_dir() else []
    close = difflib.get_close_matches(name, known, 1)
    hint = f"; did you mean {close[0]}?" if close else ""
    raise BadInput(name, "", f"there is no such file, here or in {fmu_dir}{hint}")


def build_shipped(kind: str, fmu_dir: Path, *, quiet: bool = False) -> Path:
    """Build ``plant.fmu`` or ``compensator.fmu`` into *fmu_dir* and return its path."""
    if not quiet:
        print(f"{fmu_dir / kind}.fmu is missing: building it", file=sys.stderr)
    from scenarios.building import main

    # What the build prints is no result of this command.
    with contextlib.redirect_stdout(sys.stderr):
        code = main(["--only", kind, "--out", str(fmu_dir)])
    if code != 0:
        raise BadInput(fmu_dir / f"{kind}.fmu", "", "could not be built; see python build_fmu.py")
    return fmu_dir / f"{kind}.fmu"


def build_compensator(model: Path, work: Path) -> Path:
    """Build the compensator FMU of a compensator file into *work* and return its path.

    Raises
    ------
    BadInput, ModelFileError
        If the file cannot be used.
    """
    from scenarios.building import compensator_recipe

    recipe, _ = compensator_recipe(model, "compensator")
    return _written(recipe, work)


def build_plant(machine: str, work: Path, name: str = "plant") -> Path:
    """Build the plant FMU of a machine, shipped or in a file, into *work* and return its path.

    Raises
    ------
    BadInput
        If the machine cannot be used.
    """
    from plant_model.machine_file import read_machine
    from scenarios.building import plant_recipe

    recipe, _ = plant_recipe(read_machine(machine), name)
    return _written(recipe, work)


def native_twin(plant: Path, work: Path, *, quiet: bool = False) -> Path:
    """Return the twin in C of a plant FMU, or the FMU itself where there is none.

    Parameters
    ----------
    plant : Path
        Any FMU; the twin is that beside it, ``plant_native.fmu``, if it is one, else it is built.
    work : Path
        Where it may be built.
    quiet : bool
        Do not say why there is none.
    """
    from fmu_packaging.native.build import native_package
    from fmu_packaging.native.compilers import CompileError, NativeError, compilers
    from plant_model.fmi_slave import MACHINE_FILE
    from plant_model.machine import Machine
    from plant_model.native.build import TWIN_OF, native_plant
    from scenarios.building import plant_recipe

    machine, guid = _read(plant, f"resources/{MACHINE_FILE}"), _guid(plant)
    if machine is None or guid is None:
        return plant
    name = f"{plant.stem}_native"
    for known in (plant.with_name(f"{name}.fmu"), work / f"{name}.fmu"):
        if _read(known, f"documentation/{TWIN_OF}") == guid:
            return known
    try:
        recipe, _ = plant_recipe(Machine.from_dict(json.loads(machine)), name)
        native = native_plant(recipe, guid.decode())
        package = native_package(recipe, native, compilers()[:1])
    except (CompileError, NativeError) as error:
        if not quiet:
            why = str(error).splitlines()[0].removeprefix("--native: ")
            _say_once(f"{plant}: simulated in Python: {why}")
        return plant
    path = work / f"{package.name}.fmu"
    path.write_bytes(package.zipped())
    return path


@cache
def _say_once(line: str) -> None:
    print(line, file=sys.stderr)


def _read(fmu: Path, member: str) -> bytes | None:
    """Return a file in an FMU, None if there is none."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            return archive.read(member)
    except (OSError, KeyError, zipfile.BadZipFile):
        return None


def _guid(fmu: Path) -> bytes | None:
    text = _read(fmu, "modelDescription.xml")
    found = re.search(rb'guid="([^"]+)"', text or b"")
    return found[1] if found else None


def _written(recipe: Any, work: Path) -> Path:
    from fmu_packaging.package import build

    package = build(recipe)
    path = work / f"{package.name}.fmu"
    path.write_bytes(package.zipped())
    return path
