"""Builds the FMUs.

Each is first validated and run in a fresh process; on any problem the build stops and the existing
FMU stays. Nothing is written if the content has not changed.
"""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fmu_compensator.native.build import native_compensator
from fmu_compensator.runtime.fmi_slave import MODEL_FILE, status_meanings, taken_name
from fmu_compensator.runtime.modelfile import Model, parse_model
from fmu_packaging.description import Identity
from fmu_packaging.documentation import Page
from fmu_packaging.native.build import Fmi, Native, Part, native_package
from fmu_packaging.native.compilers import Compiler, compilers, compilers_for_all
from fmu_packaging.package import Package, Recipe, build
from fmu_packaging.publish import Reference, publish
from measurement.errors import BadInput
from measurement.files import read_bytes
from plant_model.fmi_slave import MACHINE_FILE, variable_name
from plant_model.machine import Machine
from plant_model.native.build import native_plant
from scenarios.outputs import FMU, OTHERWISE, check_output, is_forced
from scenarios.pages.report import page_text
from scenarios.plugged import effect_files, error_model_files
from scenarios.reference_runs import compensator_reference, plant_reference, with_array
from scenarios.scenario import Settings
from scenarios.unpacking import place_in_python
from scenarios.version import version as installed_version

HERE = Path(__file__).resolve().parent.parent
ASSETS = HERE / "fmu_packaging" / "assets"
DEFAULT_MODEL = HERE / "fmu_compensator" / "library" / "jig_borer.json"
DEFAULT_MACHINE = "jig_borer"
OnBus = Callable[[Recipe, Native, Path | None, bool], Native]
"""Adds a bus terminal to a compensator, low cut or high, with the frames of a DBC file or the
default ones."""
CAN = {"low": "_can", "high": "_can_high"}
"""Ending of the name of an FMU with a terminal of this cut."""
EXPERIMENT = [Settings.model_fields[name].default for name in ("duration_s", "step_s")]
"""Default experiment of an FMU: that of a scenario [s]."""


def version() -> str:
    """Return the project's version: of the checkout, or else as installed."""
    project = HERE / "pyproject.toml"
    if not project.is_file():
        return installed_version()
    with project.open("rb") as file:
        return str(tomllib.load(file)["project"]["version"])


def compensator_recipe(path: Path, name: str, native: bool = False) -> tuple[Recipe, Reference]:
    """Return how to build and test the compensator FMU of a compensator file.

    Parameters
    ----------
    path : Path
        The compensator file.
    name : str
        Name of the FMU.
    native : bool
        Whether it is for the C twin, which reads no other file.

    Returns
    -------
    recipe : Recipe
    reference : Reference
        Inputs for a trial run.

    Raises
    ------
    BadInput, ModelFileError
        If the file cannot be used.
    """
    data = read_bytes(path)
    model = parse_model(data.decode("utf-8", "replace"), str(path))
    if (taken := taken_name(model)) is not None:
        place = [sensor.name for sensor in model.sensors].index(taken)
        problem = f"{taken!r} is not allowed: the FMU has a variable of this name"
        raise BadInput(path, f"sensors.{place}.name", problem)
    identity = Identity(
        name,
        f"Thermal drift compensator: {model.title}",
        "Axis offsets that cancel the thermal drift of a spindle, from temperatures, spindle speed "
        f"and tool length. Compensator file: {model.name}.",
        version(),
        *EXPERIMENT,
    )
    roots = ("fmu_compensator", "fmu_packaging")
    recipe = Recipe(
        identity,
        "fmu_compensator.runtime.fmi_slave",
        "CompensatorSlave",
        roots=roots,
        whole=("fmu_compensator.runtime.error_models",),
        data={MODEL_FILE: data},
        page=_compensator_page(model, data, native),
        icon=(ASSETS / "compensator.png").read_bytes(),
        added=error_model_files(model, roots),
        left_out=("fmu_compensator.plugins",),
    )
    return recipe, compensator_reference(model)


def plant_recipe(machine: Machine, name: str) -> tuple[Recipe, Reference]:
    """Return how to build and test the plant FMU of a machine.

    Parameters
    ----------
    machine : Machine
    name : str
        Name of the FMU.

    Returns
    -------
    recipe : Recipe
    reference : Reference
        Inputs for a trial run.
    """
    identity = Identity(
        name,
        f"Spindle that warms up: {machine.title}",
        "Lumped-thermal model of a machine-tool spindle: temperatures, drift of the tool tip, and "
        f"the error that remains after the offsets. Machine: {machine.name}.",
        version(),
        *EXPERIMENT,
    )
    data = (json.dumps(machine.to_dict(), indent=1) + "\n").encode()
    roots, third_party = ("plant_model", "fmu_packaging"), {"numpy": ">=2.0"}
    recipe = Recipe(
        identity,
        "plant_model.fmi_slave",
        "PlantSlave",
        roots=roots,
        whole=("plant_model.effects",),
        third_party=third_party,
        data={MACHINE_FILE: data},
        page=_plant_page(machine),
        icon=(ASSETS / "plant.png").read_bytes(),
        added=effect_files(machine, roots, third_party),
        left_out=("plant_model.plugins",),
    )
    return recipe, plant_reference(machine)


def _compensator_page(model: Model, data: bytes, native: bool) -> Page:
    body = page_text(
        "fmu/compensator.html",
        model=model,
        used=[model.sensors[index].name for index in model.chosen],
        limits=model.limits,
        codes=status_meanings().items(),
        native=native,
        sha256=hashlib.sha256(data).hexdigest(),
        runs=[(e["name"], e["rows"], e["sha256"]) for e in model.provenance.get("runs", [])],
    )
    lead = "Temperatures, spindle speed and tool length in; axis offsets, a validity flag and a "
    return Page(f"{lead}status that says why out.", body)


def _plant_page(machine: Machine) -> Page:
    origins = [
        (variable_name(name), machine.references.get(entry.source, entry.source))
        for name, entry in machine.parameters.items()
        if entry.calibrate
    ]
    description = " ".join(machine.description.split())
    body = page_text(
        "fmu/plant.html",
        machine=machine,
        description=description,
        axis=machine.axis,
        origins=origins,
    )
    lead = "Spindle speed, boundary temperatures, tool length and offsets in; sensor readings, "
    return Page(f"{lead}drift and the error left at the tool tip out.", body)


@dataclass(frozen=True)
class Form:
    """How FMUs are built.

    Parameters
    ----------
    native : bool
        Build FMUs in C99, without Python.
    fmi : {2, 3}
        FMI version; 3 builds FMUs in C.
    arrays : bool
        With FMI 3.0: the temperatures as one array instead of one variable each.
    all_platforms : bool
        For FMUs in C: binaries for Linux, Windows and macOS, with the package ziglang.
    leave_out : {"sources", "binaries"}, optional
        What to omit from an FMU without Python.
    can : {"low", "high"}, optional
        A compensator as a node of a CAN bus (FMI-LS-BUS), with FMI 3.0: its terminal takes frames
        as bytes (low cut, the usual one) or their signals (high cut).
    dbc : Path, optional
        With a bus: frames to use instead of the gateway's.

    Raises
    ------
    BadInput
        For incompatible options.
    """

    native: bool = False
    fmi: Fmi = 2
    arrays: bool = False
    all_platforms: bool = False
    leave_out: Part | None = None
    can: str | None = None
    dbc: Path | None = None

    def __post_init__(self) -> None:
        """Refuse incompatible options."""
        for option, is_wrong, problem in (
            ("--arrays", self.arrays and self.can, "not with --can"),
            ("--arrays", self.arrays and self.fmi != 3, "add --fmi 3"),
            ("--dbc", self.dbc and not self.can, "add --can"),
            ("--all-platforms", self.all_platforms and not self.in_c, "add --native"),
            ("--leave-out", self.leave_out and not self.in_c, "add --native"),
        ):
            if is_wrong:
                raise BadInput(option, "", problem)

    @property
    def in_c(self) -> bool:
        """Whether the FMUs are in C, which FMI 3.0 requires here."""
        return self.native or self.version == 3

    @property
    def version(self) -> Fmi:
        """FMI version."""
        return 3 if self.can else self.fmi

    def name(self, kind: str) -> str:
        """Return the name of an FMU of a kind."""
        ending = ("_native" if self.fmi == 2 else "_native_fmi3") if self.in_c else ""
        return kind + CAN.get(self.can or "", ending + ("_arrays" if self.arrays else ""))


@dataclass(frozen=True)
class Job:
    """An FMU to build, and its folder."""

    recipe: Recipe
    reference: Reference
    native: Native | None
    compilers: Sequence[Compiler]
    form: Form
    folder: Path

    def run(self) -> tuple[Package, Path, bool]:
        """Build, validate and test the FMU; return its package, its file, and whether it is new.

        Raises
        ------
        PublishError, NativeError, CompileError
            If it cannot be built, or fails.
        """
        if self.native is None:
            package = build(self.recipe)
        else:
            package = native_package(
                *(self.recipe, self.native, self.compilers, self.form.version),
                measured=True,
                leave_out=self.form.leave_out,
                array=self.form.arrays,
            )
        return package, *publish(package, self.folder, self.reference)


def job_for(
    source: Path | Machine,
    folder: Path,
    form: Form,
    *,
    name: str | None = None,
    on_bus: OnBus | None = None,
) -> Job:
    """Return the checked job that builds an FMU.

    Parameters
    ----------
    source : Path or Machine
        A compensator file or a machine.
    folder : Path
        For the FMU and its reference results; created if missing.
    form : Form
    name : str, optional
        Name of the FMU.
    on_bus : callable, optional
        Needed for a compensator with a CAN terminal.

    Raises
    ------
    BadInput, ModelFileError, NativeError
        If the source or the folder cannot be used, or a compiler is missing.
    """
    if name is not None and not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
        problem = f"{name!r} is not allowed: letters, digits and underscores, a letter first"
        raise BadInput("--name", "", problem)
    if isinstance(source, Machine):
        recipe, reference = plant_recipe(source, name or form.name("plant"))
    else:
        recipe, reference = compensator_recipe(source, name or form.name("compensator"), form.in_c)
    if form.can:
        # Its inputs would come from a bus, and there is none in that run.
        reference = replace(reference, profiles={})
    if form.arrays:
        reference = with_array(reference, recipe)
    native, usable = None, list[Compiler]()
    if form.in_c:
        usable = compilers_for_all() if form.all_platforms else compilers()
        native = native_of(recipe, *([] if isinstance(source, Machine) else [source]))
    else:
        place_in_python()  # it is validated there
    if native is not None and form.can:
        if on_bus is None or isinstance(source, Machine):
            raise BadInput("--can", "", "only the compensator of build_fmu.py has a CAN terminal")
        native = on_bus(recipe, native, form.dbc, form.can == "high")
    _check_outputs(folder, recipe.identity.name)
    return Job(recipe, reference, native, usable, form, folder)


def native_of(recipe: Recipe, model: Path = DEFAULT_MODEL, *, twin_of: str | None = None) -> Native:
    """Return what the C twin of an FMU is made from; a compensator's is made from file *model*.

    Parameters
    ----------
    recipe : Recipe
        Recipe of a compensator's or a plant's FMU in Python.
    model : Path
        Compensator file from which the C is made; not used for a plant.
    twin_of : str, optional
        GUID of the FMU in Python; without it that FMU is built to find out.

    Raises
    ------
    NativeError
        If something in it has no counterpart in C.
    BadInput, ModelFileError
        If the compensator file cannot be used.
    """
    is_plant = MACHINE_FILE in recipe.data
    if twin_of is None and is_plant:
        machine = Machine.from_dict(json.loads(recipe.data[MACHINE_FILE]))
        twin_of = build(plant_recipe(machine, "plant")[0]).guid
    elif twin_of is None:
        twin_of = build(compensator_recipe(model, "compensator")[0]).guid
    return (
        native_plant(recipe, twin_of) if is_plant else native_compensator(recipe, twin_of=twin_of)
    )


def _check_outputs(folder: Path, name: str) -> None:
    """Check that an FMU and its reference results may be written.

    The reference results count as this program's if the FMU next to them does.

    Parameters
    ----------
    folder : Path
        Their folder.
    name : str
        Name of the FMU, without ``.fmu``.

    Raises
    ------
    BadInput
        If a file that this program did not make is in the way, or the folder cannot be created.
    """
    target = folder / f"{name}.fmu"
    is_new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise BadInput("--out", "", f"{folder} is not a folder") from None
    except OSError as error:
        raise BadInput("--out", str(folder), f"cannot be made: {error.strerror}") from None
    check_output(target, FMU)
    beside = [folder / f"{name}_{end}" for end in ("in.csv", "ref.csv", "ref.opt")]
    there = [path for path in beside if path.exists()]
    if there and not target.exists() and not is_forced():
        raise BadInput(there[0], "", f"exists without {target.name} beside it: {OTHERWISE}")
    if is_new:
        folder.rmdir()  # made again once there is something to put into it
