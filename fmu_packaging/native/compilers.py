"""The C compilers of this machine, and how to build a shared library with each."""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import fmpy

# Contracted multiply-adds would round once, while the Python twin rounds twice. The headers of FMI
# 3.0 declare two functions without their parameters.
STRICT = (
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Werror",
    "-Wno-strict-prototypes",
    "-ffp-contract=off",
)
OWN = ("gcc", "clang", "cc")
FOR_WINDOWS = "x86_64-w64-mingw32-gcc"
FOR_AARCH64 = "aarch64-linux-gnu-gcc"
# At -O3 gcc 12 makes the compensator's sums four times slower, and the plant no faster.
COMPILED = ("-O2", "-fPIC", "-fvisibility=hidden")
COMPILED_BY_ZIG = (*COMPILED, "-fno-sanitize=undefined")
COMPILED_FOR_WINDOWS = ("-O2", "-fvisibility=hidden", "-D__USE_MINGW_ANSI_STDIO=1")
COMPILED_FOR_WEB = ("-O2", "-fno-sanitize=undefined")
LINKED = ("-shared", "-s")
# Without date and folder of the build, so that the same sources give the same bytes.
LINKED_HERE = (*LINKED, "-Wl,--build-id=none", "-Wl,--no-undefined")
LINKED_FOR_WINDOWS = (*LINKED, "-static-libgcc", "-Wl,--no-insert-timestamp")
# A module without a main, only with FMI functions to be called.
LINKED_FOR_WEB = (
    "-s",
    "-mexec-model=reactor",
    "-Wl,--export-dynamic",
    "-Wl,--export=memory_take",
)
FOR_WEB = "wasm32-wasi"


OLDEST_GLIBC, OLDEST_MACOS = "2.17", "11.0"
MACH_O_ALIGNMENT, FAT_MAGIC = 14, 0xCAFEBABE
"""Given by Apple's format of libraries for several processors."""
BY_ZIG = {
    f"x86_64-linux-gnu.{OLDEST_GLIBC}": ("linux64", "x86_64-linux", ".so"),
    "x86_64-windows-gnu": ("win64", "x86_64-windows", ".dll"),
    f"aarch64-linux-gnu.{OLDEST_GLIBC}": ("aarch64-linux", "aarch64-linux", ".so"),
    f"x86_64-macos.{OLDEST_MACOS}": ("darwin64", "x86_64-darwin", ".dylib"),
    f"aarch64-macos.{OLDEST_MACOS}": ("darwin64", "aarch64-darwin", ".dylib"),
}
"""FMI's platforms by ziglang's. FMI 2.0 has one name for macOS, so both are in one file."""


class NativeError(ValueError):
    """A C twin that cannot be built; the text says what and why in one line."""


class CompileError(RuntimeError):
    """Sources that a compiler refuses; the text is its output."""


@dataclass(frozen=True)
class Compiler:
    """A compiler and its target.

    Attributes
    ----------
    command : tuple of str
        Command to call it.
    platform, platform3 : str
        Name of the target platform in FMI 2.0 and in FMI 3.0.
    suffix : str
        Suffix of a library's file name.
    flags, linked : tuple of str
        Flags to compile a library's sources, and to link them.
    """

    command: tuple[str, ...]
    platform: str
    platform3: str
    suffix: str
    flags: tuple[str, ...]
    linked: tuple[str, ...]

    def library(self, sources: Mapping[str, str]) -> bytes:
        """Return the shared library of C sources, given by path.

        Parameters
        ----------
        sources : dict of str to str
            Text by path; files ending in ``.c`` are compiled.

        Raises
        ------
        CompileError
            For the first error or warning.
        """
        with tempfile.TemporaryDirectory(prefix="native_") as name:
            folder, target = Path(name), f"library{self.suffix}"
            write_sources(folder, sources)

            def compiled(source: str) -> str:
                made = str(Path(source).with_suffix(".o"))
                command = [*self.command, *STRICT, *self.flags, "-I."]
                run_compiler([*command, "-c", source, "-o", made], folder)
                return made

            with ThreadPoolExecutor(os.cpu_count()) as pool:
                objects = [*pool.map(compiled, c_files(sources))]
            run_compiler([*self.command, *self.linked, "-o", target, *objects, "-lm"], folder)
            return (folder / target).read_bytes()

    def printed(self, sources: Mapping[str, str], more: Sequence[str] = ()) -> str:
        """Return the output of a program of C sources; only for a compiler for this machine.

        Parameters
        ----------
        sources : dict of str to str
            Text by path; one has a main.
        more : sequence of str
            Further flags.

        Raises
        ------
        CompileError
            For the first error or warning, or if the program fails.
        """
        with tempfile.TemporaryDirectory(prefix="native_") as name:
            folder = Path(name)
            write_sources(folder, sources)
            strict = [*self.command, *STRICT, *more, "-I."]
            run_compiler([*strict, "-o", "program", *c_files(sources), "-lm"], folder)
            done = subprocess.run(
                [str(folder / "program")], capture_output=True, text=True, check=False
            )
        if done.returncode:
            raise CompileError(f"what it compiled failed: {done.stderr.strip()}")
        return done.stdout


def compilers() -> list[Compiler]:
    """Return a compiler for this machine, then the available ones for other machines.

    Raises
    ------
    NativeError
        If there is none for this machine.
    """
    given = os.environ.get("CC")
    own = shlex.split(given) if given else [name for name in OWN if shutil.which(name)][:1]
    if not own or shutil.which(own[0]) is None:
        missing = f"CC names {given!r}, which cannot" if given else f"of {', '.join(OWN)} none can"
        raise NativeError(f"--native: no C compiler: {missing} be found")
    linked = LINKED_HERE if fmpy.system == "linux" else LINKED
    names = fmpy.platform, fmpy.platform_tuple
    usable = [Compiler(tuple(own), *names, fmpy.sharedLibraryExtension, COMPILED, linked)]
    if fmpy.system == "linux" and shutil.which(FOR_WINDOWS):
        names = "win64", "x86_64-windows"
        flags = COMPILED_FOR_WINDOWS, LINKED_FOR_WINDOWS
        usable.append(Compiler((FOR_WINDOWS,), *names, ".dll", *flags))
    aarch64 = "aarch64-linux"  # FMI 2.0 has no name for it and uses that of FMI 3.0
    if fmpy.system == "linux" and fmpy.platform_tuple != aarch64 and shutil.which(FOR_AARCH64):
        flags = COMPILED, LINKED_HERE
        usable.append(Compiler((FOR_AARCH64,), aarch64, aarch64, ".so", *flags))
    return usable


def compilers_for_all() -> list[Compiler]:
    """Return a compiler for every platform, from the package ziglang.

    Raises
    ------
    NativeError
        If that package is not installed.
    """
    return [
        Compiler(_zig(target, "--all-platforms"), *names, COMPILED_BY_ZIG, LINKED)
        for target, names in BY_ZIG.items()
    ]


def compiler_for_web() -> Compiler:
    """Return the compiler for WebAssembly, from the package ziglang.

    Raises
    ------
    NativeError
        If that package is not installed.
    """
    flags = COMPILED_FOR_WEB, LINKED_FOR_WEB
    return Compiler(_zig(FOR_WEB, "web"), FOR_WEB, FOR_WEB, ".wasm", *flags)


def _zig(target: str, asked: str) -> tuple[str, ...]:
    if importlib.util.find_spec("ziglang") is None:
        raise NativeError(f"{asked}: the package ziglang is missing: pip install ziglang")
    return sys.executable, "-m", "ziglang", "cc", "-target", target


def in_one_file(first: bytes, second: bytes) -> bytes:
    """Return a macOS library for two processors, as Apple's ``lipo`` creates it.

    Parameters
    ----------
    first, second : bytes
        Mach-O files of 64 bits.
    """
    room = 1 << MACH_O_ALIGNMENT
    parts, entries, at = [], [], room
    for library in (first, second):
        processor, kind = struct.unpack_from("<II", library, 4)
        entries.append(struct.pack(">5I", processor, kind, at, len(library), MACH_O_ALIGNMENT))
        parts.append(library.ljust(-(-len(library) // room) * room, b"\0"))
        at += len(parts[-1])
    parts[-1] = second
    head = struct.pack(">2I", FAT_MAGIC, len(entries)) + b"".join(entries)
    return head.ljust(room, b"\0") + b"".join(parts)


def write_sources(folder: Path, sources: Mapping[str, str]) -> None:
    """Write sources into a folder.

    Parameters
    ----------
    folder : Path
    sources : dict of str to str
        Text by path in it.
    """
    for path, text in sources.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8", newline="\n")


def c_files(sources: Mapping[str, str]) -> list[str]:
    """Return the paths of the sources to compile, in order.

    Parameters
    ----------
    sources : dict of str to str
        Text by path.
    """
    return sorted(path for path in sources if path.endswith(".c"))


def run_compiler(command: Sequence[str], folder: Path) -> None:
    """Run a compiler in the folder of the sources.

    Parameters
    ----------
    command : sequence of str
        The compiler and all its arguments.
    folder : Path
        Of the sources.

    Raises
    ------
    CompileError
        If it refuses them.
    """
    # Its temporary files are removed with the folder, even if it is killed.
    environment = {**os.environ, "LC_ALL": "C", "TMPDIR": str(folder)}
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=environment
    )
    if done.returncode:
        raise CompileError((done.stderr + done.stdout).strip())
