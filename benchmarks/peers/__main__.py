"""FMUs side by side: a linear regression by several tools, and this project's; step, loading, size.

The regression takes eleven temperatures and gives three offsets. Beside the compensator and the
plant stand FMUs of the same variables whose step is empty, on this project's base class and as
pythonfmu alone would have them. All are driven by the same loop (inputs set, step, outputs got, by
ctypes) and take turns; a ratio is the median over the turns. Times are the processor's.
``python -m benchmarks.peers``; pythonfmu3 comes with ``pip install .[benchmarks]``.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
import zipfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

import build_fmu
from benchmarks.peers.empty_slave import VARIABLES_FILE
from benchmarks.peers.in_pythonfmu import INPUTS, OUTPUTS
from benchmarks.results_page import as_table, parser_of, put
from fmu_compensator.native.build import native_compensator
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import compilers
from fmu_packaging.package import Package, Recipe, build
from plant_model.machine_file import read_machine

HERE = Path(__file__).resolve().parent
BASELINE = "by hand, in C"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Regression" guid="regression">
<CoSimulation modelIdentifier="regression" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>{variables}</ModelVariables>
<ModelStructure><Outputs>{outputs}</Outputs></ModelStructure>
</fmiModelDescription>
"""


@dataclass(frozen=True)
class Peer:
    """One tool's FMU.

    Attributes
    ----------
    title : str
    path : Path
    changing : str
        The input that is another in every step; the others stay.
    regression : bool
        Whether it is the regression and nothing else, so that its outputs are known.
    """

    title: str
    path: Path
    changing: str = "T1"
    regression: bool = False


def by_hand(folder: Path) -> Path:
    """Return the regression that a C programmer writes, compiled here."""
    library = folder / f"regression{fmpy.sharedLibraryExtension}"
    sources = [str(HERE / name) for name in ("regression.c", "refused.c")]
    flags = ["-O2", "-shared", "-fPIC", f"-I{HEADERS}"]
    subprocess.run(["gcc", *flags, *sources, "-o", str(library)], check=True)
    real = '<ScalarVariable name="{}" valueReference="{}" causality="{}"><Real{}/></ScalarVariable>'
    given = [real.format(f"T{i}", i, "input", ' start="0.0"') for i in range(INPUTS)]
    shown = [real.format(f"y{k}", INPUTS + k, "output", "") for k in range(OUTPUTS)]
    places = [f'<Unknown index="{INPUTS + k + 1}"/>' for k in range(OUTPUTS)]
    path = folder / "by_hand.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        text = DESCRIPTION.format(variables="".join(given + shown), outputs="".join(places))
        file.writestr("modelDescription.xml", text)
        file.write(library, f"binaries/{fmpy.platform}/{library.name}")
    return path


def built_by(module: str, script: str, folder: Path, variables: bytes = b"[]") -> Path:
    """Return what the builder of pythonfmu or of pythonfmu3 makes of a script and *variables*.

    A script is written for the former; the latter calls the same things otherwise.
    """
    builder = importlib.import_module(f"{module}.builder").FmuBuilder
    made = getattr(builder, "build_FMU")  # noqa: B009 - two packages, one name
    name = f"{module}_{Path(script).stem}"
    work = folder / name
    work.mkdir()
    text = (HERE / script).read_text("utf-8")
    if module == "pythonfmu3":
        text = text.replace("pythonfmu", module).replace("Fmi2", "Fmi3").replace("Real", "Float64")
    copied = work / f"{name}.py"
    copied.write_text(text, "utf-8")
    (work / VARIABLES_FILE).write_bytes(variables)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(made(copied, dest=work, project_files=[work / VARIABLES_FILE]))
    return path.rename(folder / f"{name}.fmu")  # both call theirs after the class


def written(package: Package, path: Path) -> Path:
    """Write an FMU."""
    path.write_bytes(package.zipped())
    return path


def emptied(recipe: Recipe, variables: bytes) -> Package:
    """Return an FMU with the same variables on this project's base class, and an empty step."""
    return build(
        replace(
            recipe,
            module="benchmarks.peers.empty_slave",
            slave="EmptySlave",
            roots=("benchmarks", "fmu_packaging"),
            whole=(),
            third_party={},
            data={VARIABLES_FILE: variables},
        )
    )


def peers(folder: Path, model: Path) -> tuple[list[Peer], list[str]]:
    """Return the FMUs that can be made here, and what cannot."""
    found, missing = [Peer(BASELINE, by_hand(folder), regression=True)], []
    for module, fmi in (("pythonfmu", "2.0"), ("pythonfmu3", "3.0")):
        if importlib.util.find_spec(module) is None:
            missing.append(f"{module} is not installed: pip install .[benchmarks]")
            continue
        title = f"{module} {version(module)}, FMI {fmi}"
        found.append(Peer(title, built_by(module, "in_pythonfmu.py", folder), regression=True))
    recipe, _ = build_fmu.compensator_recipe(model, "compensator_native", native=True)
    native = native_package(recipe, native_compensator(recipe), compilers()[:1])
    found.append(Peer("this compensator, in C", written(native, folder / "in_c.fmu")))
    compensator, _ = build_fmu.compensator_recipe(model, "compensator")
    plant, _ = build_fmu.plant_recipe(read_machine(build_fmu.DEFAULT_MACHINE), "plant")
    for label, recipe, changing in (
        ("compensator", compensator, "T1"),
        ("plant", plant, "ambient"),
    ):
        package = build(recipe)
        variables = json.dumps([asdict(one) for one in package.slave.variables]).encode()
        empty = emptied(recipe, variables)
        made = {
            "in Python": written(package, folder / f"{label}.fmu"),
            "its variables, empty": written(empty, folder / f"empty_{label}.fmu"),
        }
        if label == "compensator":
            plain = built_by("pythonfmu", "plain_slave.py", folder, variables)
            made["its variables, empty, by pythonfmu"] = plain
        found += [Peer(f"this {label}, {how}", path, changing) for how, path in made.items()]
    return found, missing


def loaded(peer: Peer, folder: Path) -> tuple[Callable[[int], None], Callable[[], list[float]]]:
    """Return what makes a step of an FMU, unpacked and initialised, and what reads its outputs."""
    description = fmpy.read_model_description(str(peer.path), validate=False)
    fmi = int(description.fmiVersion[0])
    unpacked = fmpy.extract(str(peer.path), unzipdir=str(folder))
    kind = FMU2Slave if fmi == 2 else FMU3Slave
    fmu: Any = kind(
        guid=description.guid,
        unzipDirectory=unpacked,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="peer",
    )
    fmu.instantiate()
    if fmi == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    reals = [v for v in description.modelVariables if v.type in ("Real", "Float64")]
    given, shown = ([v for v in reals if v.causality == way] for way in ("input", "output"))
    place = [v.name for v in given].index(peer.changing)
    blocks = []
    for some in (given, shown):
        refs = (ctypes.c_uint * len(some))(*(v.valueReference for v in some))
        start = (float(v.start or 0.0) for v in some)
        blocks.append((refs, len(some), (ctypes.c_double * len(some))(*start)))
    (inputs, count, sent), (outputs, many, got) = blocks
    if fmi == 2:
        send = (fmu.fmi2SetReal, (fmu.component, inputs, count, sent))
        read = (fmu.fmi2GetReal, (fmu.component, outputs, many, got))
        do_step, tail = fmu.fmi2DoStep, (1,)
    else:
        send = (fmu.fmi3SetFloat64, (fmu.component, inputs, count, sent, count))
        read = (fmu.fmi3GetFloat64, (fmu.component, outputs, many, got, many))
        flags = [ctypes.c_bool() for _ in range(3)]
        last = ctypes.c_double()
        pointers = [ctypes.byref(one) for one in (*flags, last)]
        do_step, tail = fmu.fmi3DoStep, (True, *pointers)
    send[0](*send[1])
    fmu.exitInitializationMode()

    def step(k: int) -> None:
        sent[place] = 21.0 + 1e-6 * k
        send[0](*send[1])
        do_step(fmu.component, float(k), 1.0, *tail)
        read[0](*read[1])

    return step, lambda: list(got)


def timed(peer: Peer, folder: Path, steps: int) -> tuple[float, float]:
    """Return what loading an FMU takes, and a step of it [s]."""
    begun = time.process_time()
    step, outputs = loaded(peer, folder)
    between = time.process_time()
    for k in range(steps):
        step(k)
    took = (time.process_time() - between) / steps
    if peer.regression:
        check(outputs(), steps)
    return between - begun, took


def measure(steps: int, repeats: int, model: Path) -> tuple[str, list[str]]:
    """Return the table, and what could not be measured."""
    with tempfile.TemporaryDirectory(prefix="peers_") as name:
        folder = Path(name)
        found, missing = peers(folder, model)
        turns: dict[str, list[tuple[float, float]]] = {peer.title: [] for peer in found}
        for turn in range(repeats):
            for peer in found:
                work = folder / f"{peer.path.stem}_{turn}"
                # A process for each: the libraries of pythonfmu and pythonfmu3 have equal names
                # inside, and the second one to be loaded takes the process down.
                alone = ProcessPoolExecutor(1, mp_context=get_context("fork"))
                with alone as pool:
                    turns[peer.title].append(pool.submit(timed, peer, work, steps).result())
        rows = []
        for peer in found:
            loads, costs = zip(*turns[peer.title], strict=True)
            ratios = [a / b for a, (_, b) in zip(costs, turns[BASELINE], strict=True)]
            rows.append(
                [
                    peer.title,
                    f"{1e6 * statistics.median(costs):.1f}",
                    f"{statistics.median(ratios):.1f}",
                    f"{1e3 * statistics.median(loads):.0f}",
                    f"{peer.path.stat().st_size / 1024:.0f}",
                ]
            )
    head = ["FMU", "step [us]", f"of that {BASELINE}", "loading [ms]", "KiB"]
    return as_table(head, rows), missing


def check(outputs: list[float], steps: int) -> None:
    """Raise ValueError unless the outputs are those of the regression."""
    changed = 21.0 + 1e-6 * (steps - 1)
    for k, value in enumerate(outputs):
        wanted = (0.1 * (k + 1) + 0.01) * changed
        if abs(value - wanted) > 1e-9:
            raise ValueError(f"y{k} is {value}, not {wanted}")


def main() -> int:
    """Measure and print."""
    parser = parser_of(__doc__, "benchmarks.peers")
    parser.add_argument("--steps", type=int, default=20_000, help="steps a turn (20000)")
    parser.add_argument("--repeats", type=int, default=5, help="turns (5)")
    parser.add_argument("--model", type=Path, default=build_fmu.DEFAULT_MODEL)
    arguments = parser.parse_args()
    table, missing = measure(arguments.steps, arguments.repeats, arguments.model)
    print("\n".join([table, *missing]))
    if arguments.write and not missing:
        put("peers", table)
    return 2 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
