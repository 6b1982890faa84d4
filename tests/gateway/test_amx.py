"""The library that lets user-mode-linux boot on processors with AMX. On such a processor the tests
on a real bus are its test; here is what happens where it is not needed or cannot be built."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.gateway.amx import CannotBuildError, preload


def cpuinfo(folder: Path, flags: str) -> Path:
    path = folder / "cpuinfo"
    path.write_text(f"processor\t: 0\nmodel name\t: a processor\nflags\t\t: fpu {flags} sse2\n")
    return path


def test_nothing_is_built_without_amx(tmp_path: Path) -> None:
    assert preload(tmp_path, cpuinfo(tmp_path, "avx512f"), "no-such-compiler") == {}


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_the_library_is_built_with_amx(tmp_path: Path) -> None:
    environment = preload(tmp_path, cpuinfo(tmp_path, "amx_bf16 amx_tile"))
    assert Path(environment["LD_PRELOAD"]).read_bytes()[:4] == b"\x7fELF"


@pytest.mark.parametrize("compiler", ["no-such-compiler", "false"])
def test_a_library_that_cannot_be_built_is_said(tmp_path: Path, compiler: str) -> None:
    with pytest.raises(CannotBuildError, match=f"{compiler} (cannot be run|fails)"):
        preload(tmp_path, cpuinfo(tmp_path, "amx_tile"), compiler)
