"""Sources of several FMUs in one program: the standard's prefix is on everything they define."""

import pytest

from fmu_packaging.native.compilers import STRICT, c_files, run_compiler, write_sources
from tests.fmu_packaging.conftest import KINDS, sources
from tests.running import output_of


@pytest.mark.long
@pytest.mark.parametrize("version", [2, pytest.param(3, marks=pytest.mark.long)])
def test_two_fmus_link_into_one_program(version, compiler, tmp_path):
    for kind in KINDS:
        folder, texts = tmp_path / kind, sources(kind, version)
        folder.mkdir()
        write_sources(folder, texts)
        prefix = f"-DFMI{version}_FUNCTION_PREFIX={kind}_"
        flags = [*STRICT, "-O0", "-fno-pie", "-c", prefix]
        run_compiler([*compiler, *flags, *c_files(texts)], folder)
        objects = sorted(path.name for path in folder.glob("*.o"))
        run_compiler(["ld", "-r", "-o", f"../{kind}.o", *objects], folder)
        listed = output_of("nm", "--defined-only", "-g", tmp_path / f"{kind}.o")
        names = [line.split()[-1] for line in listed.splitlines() if line]
        assert len(names) > 50
        assert [name for name in names if not name.startswith(f"{kind}_")] == []
    main = tmp_path / "main.c"
    main.write_text(
        f"const char *plant_fmi{version}GetVersion(void);\n"
        f"const char *compensator_fmi{version}GetVersion(void);\n"
        "int main(void)\n{\n"
        f"    return plant_fmi{version}GetVersion()[0] != "
        f"compensator_fmi{version}GetVersion()[0];\n}}\n"
    )
    linked = ["-no-pie", "-o", "both", "main.c", "plant.o", "compensator.o", "-lm"]
    run_compiler([*compiler, *linked], tmp_path)
    output_of(tmp_path / "both")
