"""Binaries for every platform, made by the package ziglang on this one."""

import importlib.util
import re
import struct
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

import build_fmu
from fmu_packaging.native.build import Fmi, Part, native_package
from fmu_packaging.native.compilers import (
    FAT_MAGIC,
    OLDEST_GLIBC,
    Compiler,
    compilers,
    compilers_for_all,
    in_one_file,
)
from fmu_packaging.package import Package
from scenarios.building import native_of
from tests.fmu_packaging.apart import apart
from tests.fmus.models import RUN, five_point_text
from tests.running import need_ziglang, output_of

SOURCES = {"one.c": '__attribute__((visibility("default"))) double one(void) { return 1.0; }\n'}
KINDS = {
    "x86_64-linux": (b"\x7fELF\x02\x01", "<H", 18, 62),
    "aarch64-linux": (b"\x7fELF\x02\x01", "<H", 18, 183),
    "x86_64-windows": (b"MZ", "", 0, 0),
    "x86_64-darwin": (b"\xcf\xfa\xed\xfe", "<I", 4, 0x01000007),
    "aarch64-darwin": (b"\xcf\xfa\xed\xfe", "<I", 4, 0x0100000C),
}
"""How a library begins, and where its processor stands: System V ABI, PE and Mach-O."""


@pytest.fixture(scope="module")
def for_all() -> dict[str, Compiler]:
    """A compiler for each platform, by FMI 3.0's name."""
    need_ziglang()
    return {compiler.platform3: compiler for compiler in compilers_for_all()}


def package(
    folder: Path, made_with: list[Compiler], fmi: Fmi = 2, leave_out: Part | None = None
) -> Package:
    model = folder / "by_hand.json"
    model.write_text(five_point_text())
    recipe, _ = build_fmu.compensator_recipe(model, "compensator_native", True)
    return native_package(recipe, native_of(recipe, model), made_with, fmi, leave_out=leave_out)


@pytest.mark.long
def test_every_platform_gets_a_library_of_its_own_kind(for_all):
    assert set(for_all) == set(KINDS)
    made = {platform: compiler.library(SOURCES) for platform, compiler in for_all.items()}
    for platform, (magic, form, place, processor) in KINDS.items():
        assert made[platform].startswith(magic), platform
        if form:
            assert struct.unpack_from(form, made[platform], place) == (processor,), platform
    parts = made["x86_64-darwin"], made["aarch64-darwin"]
    both = in_one_file(*parts)
    magic_number, count = struct.unpack_from(">2I", both)
    assert (magic_number, count) == (FAT_MAGIC, 2)
    for number, part in enumerate(parts):
        processor, _, at, size, _ = struct.unpack_from(">5I", both, 8 + 20 * number)
        assert both[at : at + size] == part
        assert struct.unpack_from("<I", part, 4) == (processor,)


@pytest.mark.long
@pytest.mark.skipif(fmpy.platform_tuple != "x86_64-linux", reason="runs what it makes for x86-64")
def test_the_library_for_linux_runs_with_an_old_c_library(for_all, tmp_path):
    path = tmp_path / "compensator_native.fmu"
    code = RUN + "show(steps(started(opened(sys.argv[1])), 0, 200))"
    found = []
    for made_with in ([for_all["x86_64-linux"]], compilers()[:1]):
        path.write_bytes(package(tmp_path, made_with).zipped())
        found.append(apart(code, path))
        if len(found) == 1:
            with zipfile.ZipFile(path) as archive:
                library = archive.extract("binaries/linux64/compensator_native.so", tmp_path)
            listed = re.findall(r"GLIBC_([\d.]+)", output_of("objdump", "-T", library))
            needed = {tuple(map(int, version.split("."))) for version in listed}
            assert max(needed) <= tuple(map(int, OLDEST_GLIBC.split(".")))
    for one, other in zip(*found, strict=True):
        assert one[9:] == other[9:]
        assert one[:9] == pytest.approx(other[:9], rel=1e-12, abs=1e-12)


@pytest.mark.long
def test_ziglang_takes_the_headers_of_fmi_3(for_all, tmp_path):
    made = package(tmp_path, [for_all["x86_64-linux"]], 3)
    assert [name for name in made.files if name.startswith("binaries/x86_64-linux/")]


@pytest.mark.long
@pytest.mark.parametrize("fmi", [2, 3])
def test_what_is_left_out_is_not_there(tmp_path, fmi):
    here = compilers()[:1]
    whole = set(package(tmp_path, here, fmi).files)
    sources = {name for name in whole if name.startswith("sources/")}
    binaries = {name for name in whole if name.startswith("binaries/")}
    assert sources
    assert len(binaries) == 1
    for part, gone in (
        ("sources", sources | {"documentation/compensator.json"}),
        ("binaries", binaries),
    ):
        without = package(tmp_path, here, fmi, part)
        assert whole - set(without.files) == gone
        path = tmp_path / f"without_{part}.fmu"
        path.write_bytes(without.zipped())
        assert validate_fmu(str(path)) == []
        with zipfile.ZipFile(path) as archive:
            assert set(archive.namelist()) == whole - gone
    # It was tried out with what it goes without.
    assert set(without.tried_with) == binaries


def test_without_ziglang_one_line_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    arguments = ["--native", "--all-platforms", "--only", "compensator", "--out", str(tmp_path)]
    assert build_fmu.main(arguments) == 2
    said = capsys.readouterr().err
    assert said == "--all-platforms: the package ziglang is missing: pip install ziglang\n"
