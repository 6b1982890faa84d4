"""Lets user-mode-linux boot on processors with AMX; ``amx_ptrace.c`` says what is in the way."""

import subprocess
from pathlib import Path

SOURCE = Path(__file__).with_name("amx_ptrace.c")
CPUINFO = Path("/proc/cpuinfo")


class CannotBuildError(Exception):
    """The library that such a processor needs cannot be had; says why."""


def has_amx(cpuinfo: Path = CPUINFO) -> bool:
    """Return whether a processor here has AMX."""
    try:
        text = cpuinfo.read_text(errors="replace")
    except OSError:
        return False
    return any("amx_tile" in line.split() for line in text.splitlines() if line.startswith("flags"))


def preload(folder: Path, cpuinfo: Path = CPUINFO, compiler: str = "gcc") -> dict[str, str]:
    """Return what the guest's environment needs; nothing on a processor without AMX.

    Parameters
    ----------
    folder : Path
        Where the library is built.
    cpuinfo : Path, optional
        What the kernel says of the processors.
    compiler : str, optional
        A C compiler.

    Raises
    ------
    CannotBuildError
        If the library is needed and the compiler is missing or fails.
    """
    if not has_amx(cpuinfo):
        return {}
    library = folder / "amx_ptrace.so"
    command = [compiler, "-O2", "-shared", "-fPIC", "-o", str(library), str(SOURCE)]
    why = "a processor with AMX needs a small library to boot user-mode-linux, and"
    try:
        built = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise CannotBuildError(f"{why} {compiler} cannot be run: {error.strerror}") from None
    if built.returncode:
        raise CannotBuildError(f"{why} {compiler} fails: {' '.join(built.stderr.split())[:300]}")
    return {"LD_PRELOAD": str(library)}
