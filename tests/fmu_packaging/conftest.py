"""The tiny FMUs of these tests, and the sources of shipped ones."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Literal, get_args

import pytest

import build_fmu
from fmu_packaging.description import Identity
from fmu_packaging.documentation import Page
from fmu_packaging.native.build import Fmi, native_package
from fmu_packaging.package import Package, Recipe, build
from plant_model.machine_file import read_machine
from scenarios.building import native_of

Kind = Literal["plant", "compensator"]
KINDS: tuple[Kind, ...] = get_args(Kind)
PAGE = Page("A test.", "<h2>What it does</h2>\n<p>It adds up.</p>")


def tiny_recipe(scale: float = 1.0, name: str = "tiny") -> Recipe:
    """Return the recipe of the tiny FMU, whose sums are *scale* times the plain ones."""
    return Recipe(
        Identity(name, "Tiny", "A test.", "1.2.3", 10.0, 1.0),
        "tests.fmu_packaging.tiny_slave",
        "TinySlave",
        roots=("tests", "fmu_packaging"),
        page=PAGE,
        icon=b"\x89PNG not looked at",
        data={"scale.txt": str(scale).encode()},
    )


@pytest.fixture(scope="session")
def tiny() -> Package:
    """The tiny FMU."""
    return build(tiny_recipe())


@pytest.fixture
def tiny_fmu(tmp_path: Path) -> Callable[..., str]:
    """Return a function that writes a tiny FMU and returns its path."""

    def write(scale: float = 1.0, name: str = "tiny") -> str:
        path = tmp_path / f"{name}_{scale:g}.fmu"
        path.write_bytes(build(tiny_recipe(scale, name)).zipped())
        return str(path)

    return write


@cache
def sources(kind: Kind, fmi: Fmi) -> dict[str, str]:
    """Return the sources of the shipped compensator, or of a plant in few lumps, by path."""
    if kind == "plant":
        recipe, _ = build_fmu.plant_recipe(read_machine("jig_borer_lumps"), "plant_native")
    else:
        recipe, _ = build_fmu.compensator_recipe(build_fmu.DEFAULT_MODEL, "compensator_native")
    return {
        path.removeprefix("sources/"): data.decode()
        for path, data in native_package(recipe, native_of(recipe), [], fmi).files.items()
        if path.startswith("sources/")
    }
