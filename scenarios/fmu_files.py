"""Where the FMUs of a scenario come from: a file, the FMU folder, or built on the spot."""

from __future__ import annotations

import contextlib
import difflib
import sys
from pathlib import Path
from typing import Any

from measurement.errors import BadInput

SHIPPED = ("plant", "compensator")


def find_fmu(name: str, fmu_dir: Path, near: Path, work: Path, *, quiet: bool = False) -> Path:
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
        return build_plant(str(found), work) if found.suffix == ".toml" else found
    if Path(name).name == name and Path(name).stem in SHIPPED and name.endswith(".fmu"):
        return build_shipped(Path(name).stem, fmu_dir, quiet=quiet)
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


def _written(recipe: Any, work: Path) -> Path:
    from fmu_packaging.package import build

    package = build(recipe)
    path = work / f"{package.name}.fmu"
    path.write_bytes(package.zipped())
    return path
