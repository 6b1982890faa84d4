"""What the FMUs in C ask of a controller: memory, stack, time a step, and MISRA's findings.

Both shipped FMUs, compiled from their sources with NO_HEAP: for this machine, and for a Cortex-M7
and aarch64 where these compilers are. Time is measured on this machine, and beside it that of a
chain of a thousand multiplications and additions of doubles, each waiting for the one before.
``python -m benchmarks.controller [--write]``
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import build_fmu
from benchmarks.controller.stack import Stack
from benchmarks.results_page import as_table, parser_of, tell
from fmu_packaging.native.build import memory_size, native_package
from fmu_packaging.native.compilers import STRICT, c_files, compilers, run_compiler, write_sources
from plant_model.machine_file import read_machine
from scenarios.building import native_of

HOST = Path(__file__).with_name("host.c")
CORTEX = ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-mthumb")
PLAIN = ("-fno-pie", "-no-pie")
TARGETS = {
    "Cortex-M7": ("arm-none-eabi-gcc", (*CORTEX, "--specs=nosys.specs", "-DCONTROLLER")),
    "aarch64": ("aarch64-linux-gnu-gcc", PLAIN),
    "here": ("", PLAIN),
}
LINKED = ("-O2", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections")
ENTRIES = ("fmi2DoStep", "fmi2SetReal", "fmi2GetReal")
SIZES = (
    "",
    "sources, read only",
    "linked with newlib",
    "static",
    "stack of a step",
    "of the start",
)
TIMES = ("", "median", "longest", "longest, in chains")
RULES = ("Rule", "compensator", "plant", "Why")
WHY = {
    ("5.5",): ("names of macros and others", "`names.h` can put a prefix before every name"),
    ("12.1", "12.3"): ("brackets, commas", "style"),
    ("10.4",): ("types of operands", "sizes and counts beside plain constants"),
    ("2.5",): ("macros that are not used", "the same file of constants for all models"),
    ("15.5",): ("one return a function", "a refusal returns at once"),
    ("11.3", "11.5", "11.8"): (
        "pointer casts",
        "FMI hands an instance over as `void *`; a row of numbers is read as the structures in it",
    ),
    ("18.4",): ("pointer arithmetic", "parts of a row of numbers"),
    ("21.3", "21.6"): (
        "heap, standard output functions",
        "`memory.c` without `NO_HEAP`; `snprintf` for texts",
    ),
}
"""Rules of MISRA C:2012 that are not kept: what they ask for, and why they are not."""
LAG_S, STEP_S, LEVEL = 7200.0, 1.0, 20.0


def sources_of(kind: str) -> dict[str, str]:
    """Return the sources of a shipped FMU, with the memory that it takes."""
    if kind == "plant":
        recipe, _ = build_fmu.plant_recipe(read_machine(build_fmu.DEFAULT_MACHINE), "plant_native")
    else:
        recipe, _ = build_fmu.compensator_recipe(build_fmu.DEFAULT_MODEL, "compensator_native")
    found = {
        path.removeprefix("sources/"): data.decode()
        for path, data in native_package(recipe, native_of(recipe), []).files.items()
        if path.startswith("sources/")
    }
    return {**found, "memory_size.h": memory_size(found, compilers()[0], 2)}


def linked(command: str, flags: tuple[str, ...], sources: dict[str, str], folder: Path) -> Path:
    """Compile and link the sources with the host, and return the program."""
    write_sources(folder, {**sources, HOST.name: HOST.read_text("utf-8")})
    tool = [command] if command else list(compilers()[0].command)
    strict = [flag for flag in STRICT if flag != "-Werror"] if "nosys" in "".join(flags) else STRICT
    files = c_files(sources)
    common = [*tool, *strict, *LINKED, *flags, "-DNO_HEAP", "-I."]
    run_compiler([*common, "-fcallgraph-info=su", "-c", *files], folder)
    run_compiler([*common, "-c", HOST.name], folder)
    objects = [f"{Path(path).stem}.o" for path in (*files, HOST.name)]
    run_compiler([*common, "-o", "program", *objects, "-lm"], folder)
    return folder / "program"


def sizes(files: Iterable[Path], command: str) -> tuple[int, int]:
    """Return what files take of memory that is read and of memory that is written [bytes]."""
    tool = [command.removesuffix("gcc") + "size", *map(str, files)]
    done = subprocess.run(tool, capture_output=True, text=True, check=True)
    rows = [map(int, line.split()[:3]) for line in done.stdout.splitlines()[1:]]
    text, data, bss = map(sum, zip(*rows, strict=True))
    return text + data, data + bss


def misra(sources: dict[str, str], folder: Path) -> Counter[str]:
    """Return how often cppcheck finds which rule of MISRA C:2012 not kept, in what is not data."""
    write_sources(folder, sources)
    command = ["cppcheck", "--addon=misra", "--std=c99", "--quiet", "--suppress=*:fmi2*.h", "."]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return Counter(re.findall(r"misra-c2012-([\d.]+)\]", done.stderr))


def followed(kind: type[np.floating]) -> float:
    """Return the smallest difference that a lag still follows at a level [K]."""
    return float(np.finfo(kind).eps) / 2.0 * LEVEL / -np.expm1(-STEP_S / LAG_S)


def main() -> int:
    """Measure and print."""
    parser = parser_of(__doc__, "benchmarks.controller")
    parser.add_argument("--steps", type=int, default=4000, help="a run (4000)")
    parser.add_argument("--runs", type=int, default=25, help="of which the shortest counts (25)")
    given = parser.parse_args()
    found = {kind: sources_of(kind) for kind in ("compensator", "plant")}
    size: list[list[str]] = []
    time: list[list[str]] = []
    rule: list[list[str]] = []
    with tempfile.TemporaryDirectory(prefix="controller_") as name:
        programs = {}
        for kind, sources in found.items():
            for target, (command, flags) in TARGETS.items():
                if command and shutil.which(command) is None:
                    size.append([f"{kind}, {target}", f"{command} is not there"])
                    continue
                folder = Path(name) / kind / target
                programs[kind] = linked(command, flags, sources, folder)
                if not command:
                    continue  # for its time alone
                objects = sorted(set(folder.glob("*.o")) - {folder / "host.o"})
                constant, written = sizes(objects, command)
                # With the C library, where that is linked in.
                whole = f"{sizes([programs[kind]], command)[0]:,}" if "nosys" in str(flags) else ""
                stack = Stack(folder.glob("*.ci"))
                step, start = max(map(stack.deepest, ENTRIES)), stack.deepest("fmi2Instantiate")
                numbers = [f"{number:,}" for number in (constant, written, step, start)]
                size.append([f"{kind}, {target}", numbers[0], whole, *numbers[1:]])
        for kind, program in programs.items():
            command = [str(program), str(given.steps), str(given.runs)]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            median, longest, chain = map(float, done.stdout.split())
            shown = (f"{median / 1e3:.1f} us", f"{longest / 1e3:.1f} us", f"{longest / chain:.1f}")
            time.append([kind, *shown])
        if shutil.which("cppcheck") is None:
            rule.append(["cppcheck is not there", "", "", ""])
        else:
            counts = [misra(found[kind], Path(name) / "misra" / kind) for kind in found]
            for rules, (what, why) in WHY.items():
                sums = [str(sum(count.pop(one, 0) for one in rules)) for count in counts]
                rule.append([f"{', '.join(rules)} ({what})", *sums, why])
            rule.append(["others", *(str(count.total()) for count in counts), ""])
    single, double = followed(np.float32), followed(np.float64)
    lag = (
        f"A lag of {LAG_S:g} s at {LEVEL:g} degC, stepped by {STEP_S:g} s, stands still within "
        f"{single:.1g} K of its input in float32, {double:.1g} K in double."
    )
    found_tables = ((SIZES, size), (TIMES, time), (RULES, rule))
    text = "\n\n".join([*(as_table(head, rows) for head, rows in found_tables), lag])
    tell("controller", text, write=given.write)
    return 0


if __name__ == "__main__":
    sys.exit(main())
