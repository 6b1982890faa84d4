"""The sources with NO_HEAP: nothing of the heap is in them, and they give the same numbers."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from fmu_packaging.native.build import MEASURE, front, memory_size
from fmu_packaging.native.compilers import STRICT, Compiler, c_files, run_compiler, write_sources
from tests.fmu_packaging.conftest import KINDS, sources
from tests.running import output_of

HOST = Path(__file__).resolve().with_name("no_heap_host.c")
HEAP = {"malloc", "calloc", "realloc", "free", "strdup", "aligned_alloc", "posix_memalign"}


def symbols_of(
    folder: Path, files: Sequence[str], compiler: Compiler, *more: str
) -> dict[str, set[str]]:
    """Compile files and return the kinds of their symbols, as nm has them, by file and name."""
    run_compiler(
        [*compiler.command, *STRICT, "-O0", "-I.", "-fno-pie", "-c", *more, *files], folder
    )
    listed = output_of("nm", "-A", *(f"{Path(file).stem}.o" for file in files), folder=folder)
    kinds: dict[str, set[str]] = {}
    for line in listed.splitlines():
        *place, kind, name = line.split()
        kinds.setdefault(f"{place[0].partition(':')[0]} {name}", set()).add(kind)
    return kinds


def asked_of_the_heap(symbols: dict[str, set[str]]) -> set[str]:
    return HEAP & {key.partition(" ")[2] for key, kinds in symbols.items() if kinds == {"U"}}


def changed_for_all(symbols: dict[str, set[str]]) -> list[str]:
    """Return what is data that can be written, zeroed or not, or common."""
    return sorted(key for key, kinds in symbols.items() if kinds & set("dDbBcC"))


@pytest.mark.parametrize("kind", ["plant", "compensator", "front of FMI 3.0"])
def test_neither_heap_nor_global_state_is_in_the_objects(kind, c_compiler, tmp_path):
    if kind.startswith("front"):
        texts = front(3)
        files = [name for name in c_files(texts) if name.startswith("fmi")]
    else:
        texts = sources("plant" if kind == "plant" else "compensator", 2)
        files = c_files(texts)
    write_sources(tmp_path, texts)
    defines = ["-DNO_HEAP", "-DMEMORY_OF_INSTANCE=100000", "-DMEMORY_OF_STATE=10000"]
    found = symbols_of(tmp_path, files, c_compiler, *defines)
    assert not asked_of_the_heap(found)
    assert {"T", "U"} <= set().union(*found.values())
    # Without a heap the memory of all instances is there from the beginning, and nothing else.
    assert {key.partition(" ")[0] for key in changed_for_all(found)} <= {"memory.o"}
    # The same look finds both where they are.
    assert bool(changed_for_all(found)) == ("memory.c" in files)
    usual = symbols_of(tmp_path, ["memory.c"], c_compiler)
    assert asked_of_the_heap(usual) == {"calloc", "free"}
    assert not changed_for_all(usual)


COUNTING = """
#include <stdlib.h>
#include "memory.h"
static size_t taken;
void *memory_take(size_t count, size_t size)
{
    taken += count * size;
    return calloc(count, size);
}
void memory_give(void *memory) { free(memory); }
size_t memory_most(void) { return taken; }
"""


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_the_same_numbers_without_a_heap(kind, c_compiler, tmp_path):
    texts = {**sources(kind, 2), HOST.name: HOST.read_text(), MEASURE.name: MEASURE.read_text()}
    write_sources(tmp_path, texts)
    command = [*c_compiler.command, *STRICT, "-O0", "-I."]
    run_compiler([*command, "-c", *c_files(texts)], tmp_path)
    mains = {f"{Path(name).stem}.o" for name in (HOST.name, MEASURE.name)}
    objects = [path.name for path in tmp_path.glob("*.o")]
    objects = sorted({*objects} - mains - {"memory.o"})

    def run(main: str, *defines: str) -> list[str]:
        """Only memory.c depends on what is defined."""
        flags = [f"-D{define}" for define in defines]
        files = ["memory.c", f"{Path(main).stem}.o", *objects]
        run_compiler([*command, *flags, "-o", "program", *files, "-lm"], tmp_path)
        return output_of(tmp_path / "program").splitlines()

    enough = (f"MEMORY_OF_INSTANCE={1 << 24}", f"MEMORY_OF_STATE={1 << 16}", "NO_HEAP_STATES=1")
    instance, state = map(int, run(MEASURE.name, "NO_HEAP", *enough)[0].split())
    sizes = ("NO_HEAP", f"MEMORY_OF_INSTANCE={instance}", f"MEMORY_OF_STATE={state}")
    *expected, last = run(HOST.name)
    assert len(expected) == 200
    assert len(set(expected)) > 100
    assert {row.split()[0] for row in expected} == {"0"}
    assert last == "1 1 1"
    # One instance fits, exactly, and a state only where room for one is asked for.
    assert run(HOST.name, *sizes) == [*expected, "0 0 1"]
    more = ("NO_HEAP_INSTANCES=2", "NO_HEAP_STATES=1")
    assert run(HOST.name, *sizes, *more) == [*expected, "1 1 1"]
    less = ("NO_HEAP", f"MEMORY_OF_INSTANCE={instance - 8}", f"MEMORY_OF_STATE={state}")
    assert run(HOST.name, *less) == ["0 0 0"]
    told = memory_size(sources(kind, 2), c_compiler, 2)
    assert f"MEMORY_OF_INSTANCE {instance}\n" in told
    assert f"MEMORY_OF_STATE {state}\n" in told
    # What only derivatives need, which a controller lacks, is taken when they are asked for.
    (tmp_path / "memory.c").write_text(COUNTING)
    assert instance / 2 < int(run(MEASURE.name)[0].split()[0]) <= instance
