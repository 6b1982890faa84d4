"""Finds the FMUs of a scenario: a file, one in the FMU folder, or built when needed."""

from __future__ import annotations

import contextlib
import json
import re
import sys
from collections.abc import Collection, Iterable
from functools import cache
from pathlib import Path

from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from fmu_packaging.native.build import TWIN_OF, Fmi, Native, native_package
from fmu_packaging.native.compilers import CompileError, NativeError, compilers
from fmu_packaging.package import Recipe, build
from measurement.errors import BadInput
from measurement.errors import near as offered
from plant_model.fmi_slave import MACHINE_FILE
from plant_model.machine import Machine
from plant_model.machine_file import machine_path, read_machine, shipped_machines
from scenarios import build_command
from scenarios.building import compensator_recipe, native_of, plant_recipe
from scenarios.fmu_file import member, read_description
from scenarios.scenario import Case

SHIPPED = ("plant", "compensator")


def find_fmu(
    name: str,
    fmu_dir: Path,
    near: Path,
    work: Path,
    *,
    quiet: bool = False,
    native: bool = False,
    everywhere: bool = False,
    fmi: Fmi = 2,
) -> Path:
    """Return the FMU that a scenario or a command line names.

    Parameters
    ----------
    name : str
        A path (relative to *near* or to the working folder), a name in *fmu_dir*, a compensator
        file (``.json``), a machine file (``.toml``) or a shipped machine; from the last three an
        FMU is built.
    fmu_dir : Path
        Folder of built FMUs; ``plant.fmu`` and ``compensator.fmu`` are built if missing.
    near : Path
        The scenario's folder.
    work : Path
        Folder in which an FMU for this run only may be built.
    quiet : bool
        Do not report on building.
    native : bool
        For a machine file, a compensator file, and ``plant.fmu`` and ``compensator.fmu`` in
        *fmu_dir*, return the twin in C if available: it gives the same results, faster. A path
        always means that very FMU.
    everywhere : bool
        If the twin must be built, build it for all platforms with a compiler.
    fmi : {2, 3}
        FMI version of the twin.

    Raises
    ------
    BadInput
        If there is no such FMU and it cannot be built.
    """
    file, means_itself = _file_of(name, fmu_dir, near)
    if file is None:
        file = build_shipped(Path(name).stem, fmu_dir, quiet=quiet)
    elif file.suffix == ".json":
        file = build_compensator(file, work)
    elif file.suffix == ".toml":
        file = build_plant(str(file), work)
    if not native or means_itself:
        return file
    return native_twin(file, work, quiet=quiet, everywhere=everywhere, fmi=fmi)


def fmus_of(case: Case, plant: str | None = None, compensator: str | None = None) -> list[str]:
    """Return the names of a case's plant FMU and, if it enables one, compensator FMU.

    Parameters
    ----------
    case : Case
    plant, compensator : str, optional
        FMUs to use instead of the scenario's.
    """
    settings = case.settings
    names = [plant or settings.plant.fmu]
    if settings.compensator.enabled:
        names.append(compensator or settings.compensator.fmu)
    return names


def check_fmus(
    plants: Iterable[str],
    compensators: Iterable[str],
    fmu_dir: Path,
    near: Path,
    versions: Collection[str] = ("2.0",),
) -> None:
    """Refuse files that `find_fmu` could not use, before it builds any FMU.

    Parameters
    ----------
    plants, compensators : iterable of str
    fmu_dir, near : Path
        As for `find_fmu`.
    versions : collection of str
        Accepted FMI versions.

    Raises
    ------
    BadInput, ModelFileError
        For the first that is missing, or is neither an FMU nor the file that its role is made from.
    """
    for name, other, kind in (
        *((name, ".json", "compensator file, not a plant") for name in plants),
        *((name, ".toml", "machine file, not a compensator") for name in compensators),
    ):
        file, _ = _file_of(name, fmu_dir, near)
        if file is None:
            continue
        if file.suffix == other:
            raise BadInput(name, "", f"is a {kind}")
        if file.suffix == ".json":
            compensator_recipe(file, "compensator")
        elif file.suffix == ".toml":
            read_machine(str(file))
        else:
            read_description(file, versions)


def _file_of(name: str, fmu_dir: Path, near: Path) -> tuple[Path | None, bool]:
    """Return the file that a name means, None if it must be built; and whether it means an FMU."""
    candidates = [near / Path(name).expanduser(), Path(name).expanduser(), fmu_dir / name]
    try:
        file = next((path for path in candidates if path.is_file()), None)
    except (OSError, ValueError) as error:
        raise BadInput(name, "", f"is not a path: {error}") from None
    if file is None and name in shipped_machines():
        file = machine_path(name)
    is_shipped = Path(name).name == name and Path(name).stem in SHIPPED and name.endswith(".fmu")
    if file is None and not is_shipped:
        names = [path.name for path in fmu_dir.glob("*.fmu")] if fmu_dir.is_dir() else []
        problem = f"there is no such file, here or in {fmu_dir}{offered(name, names)}"
        raise BadInput(name, "", problem)
    is_recipe = file is not None and file.suffix in (".json", ".toml")
    return file, not is_recipe and (file in candidates[:2] or not is_shipped)


def build_shipped(kind: str, fmu_dir: Path, *, quiet: bool = False) -> Path:
    """Build ``plant.fmu`` or ``compensator.fmu`` into *fmu_dir* and return its path."""
    if not quiet:
        print(f"{fmu_dir / kind}.fmu is missing: building it", file=sys.stderr)
    # The build's output is not a result of this command.
    with contextlib.redirect_stdout(sys.stderr):
        code = build_command.main(["--only", kind, "--out", str(fmu_dir)])
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
    recipe, _ = compensator_recipe(model, "compensator")
    return _written(recipe, work)


def build_plant(machine: str, work: Path, name: str = "plant") -> Path:
    """Build the plant FMU of a machine, shipped or in a file, into *work* and return its path.

    Raises
    ------
    BadInput
        If the machine cannot be used.
    """
    recipe, _ = plant_recipe(read_machine(machine), name)
    return _written(recipe, work)


def native_twin(
    fmu: Path, work: Path, *, quiet: bool = False, everywhere: bool = False, fmi: Fmi = 2
) -> Path:
    """Return the twin in C of a plant or a compensator FMU, or the FMU itself if there is none.

    Parameters
    ----------
    fmu : Path
        Any FMU; the twin is the one next to it, for example ``plant_native.fmu``, if that is its
        twin, else it is built.
    work : Path
        Folder in which it may be built.
    quiet : bool
        Do not report why there is none.
    everywhere : bool
        Build it for all platforms with a compiler.
    fmi : {2, 3}
        FMI version of the twin.
    """
    guid, name = _guid(fmu), f"{fmu.stem}_native{'_fmi3' if fmi == 3 else ''}"
    for twin in (fmu.with_name(f"{name}.fmu"), work / f"{name}.fmu"):
        if guid is not None and member(twin, f"documentation/{TWIN_OF}") == guid:
            return twin
    try:
        made = _native_parts(fmu, name, (guid or b"").decode(), work)
        if made is None:
            return fmu
        package = native_package(*made, compilers()[: None if everywhere else 1], fmi)
    except (CompileError, NativeError) as error:
        if not quiet:
            why = str(error).splitlines()[0].removeprefix("--native: ")
            _say_once(f"{fmu}: taken in Python: {why}")
        return fmu
    path = work / f"{package.name}.fmu"
    path.write_bytes(package.zipped())
    return path


def _native_parts(fmu: Path, name: str, guid: str, work: Path) -> tuple[Recipe, Native] | None:
    """Return what the twin of an FMU of this project is made from; None for any other FMU."""
    if (machine := member(fmu, f"resources/{MACHINE_FILE}")) is not None:
        recipe, _ = plant_recipe(Machine.from_dict(json.loads(machine)), name)
    elif (model := member(fmu, f"resources/{MODEL_FILE}")) is not None:
        path = work / MODEL_FILE
        path.write_bytes(model)
        recipe, _ = compensator_recipe(path, name, native=True)
    else:
        return None
    return recipe, native_of(recipe, twin_of=guid)


def needs_no_host(fmu: Path) -> bool:
    """Return whether an FMU is one of this project's in C.

    Parameters
    ----------
    fmu : Path
    """
    return member(fmu, "sources/instance.c") is not None


@cache
def _say_once(line: str) -> None:
    print(line, file=sys.stderr)


def _guid(fmu: Path) -> bytes | None:
    text = member(fmu, "modelDescription.xml")
    match = re.search(rb'guid="([^"]+)"', text or b"")
    return match[1] if match else None


def _written(recipe: Recipe, work: Path) -> Path:
    package = build(recipe)
    path = work / f"{package.name}.fmu"
    path.write_bytes(package.zipped())
    return path
