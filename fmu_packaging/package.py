"""A complete FMU as files, and as a zip whose bytes depend only on its content."""

from __future__ import annotations

import hashlib
import importlib
import io
import tempfile
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import pythonfmu

from fmu_packaging.bundle import collect
from fmu_packaging.description import Identity, model_description
from fmu_packaging.documentation import Page, in_python, index_page
from fmu_packaging.slave import DriftSlave

PINNED_TIME = (1980, 1, 1, 0, 0, 0)
"""Pinned so that the same content gives the same bytes: given by ZIP as the earliest time."""
LICENCE = Path(__file__).resolve().parent / "assets" / "LICENSE.txt"

OLDEST_PYTHON = (3, 11)
"""Given by ``requires-python`` of pyproject.toml."""
SCRIPT = """\
import ctypes
import sys

if sys.version_info < {oldest}:
    _said = "this FMU needs Python %d.%d or newer" % {oldest}
    _said += "; the host has loaded Python %d.%d" % sys.version_info[:2]
    print(_said, file=sys.stderr, flush=True)
    raise ImportError(_said)

from {module} import {slave}

__all__ = ["{slave}"]

# pythonfmu's binary runs this file for every instance and then gives up a reference to its globals
# that it never had. Without one more each time, the globals are freed while they are in use.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
"""


@dataclass(frozen=True)
class Recipe:
    """The ingredients of an FMU.

    Attributes
    ----------
    identity : Identity
    module, slave : str
        Dotted name of the module that defines the slave, and the class's name.
    roots : tuple of str
        Top-level packages that may be bundled.
    whole : tuple of str
        Packages found by walking a folder, bundled in full.
    third_party : dict of str to str
        Packages that the host's Python must have, with a version for ``requirements.txt``.
    data : dict of str to bytes
        Files in the resources folder, by name.
    page : Page
        The documentation.
    icon : bytes
        Icon of the FMU, PNG.
    added : dict of str to str
        Files of plug-ins, by their dotted name in the FMU.
    left_out : tuple of str
        Modules that search for plug-ins; an FMU bundles its own.
    """

    identity: Identity
    module: str
    slave: str
    roots: tuple[str, ...]
    page: Page
    icon: bytes
    whole: tuple[str, ...] = ()
    third_party: Mapping[str, str] = field(default_factory=dict)
    data: Mapping[str, bytes] = field(default_factory=dict)
    added: Mapping[str, str] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Package:
    """A built FMU: its files by path, its GUID, its bytes and an instance of its slave.

    Attributes
    ----------
    tried_with : dict of str to bytes
        Binaries, by path, used for its trial run but not included.
    note : str
        A sentence on what it can or cannot be used for, or empty.
    """

    name: str
    guid: str
    files: Mapping[str, bytes]
    slave: DriftSlave
    tried_with: Mapping[str, bytes] = field(default_factory=dict)
    note: str = ""

    def zipped(self, *, on_trial: bool = False) -> bytes:
        """Return the FMU; the same files give the same bytes.

        Parameters
        ----------
        on_trial : bool
            Whether to add the binaries for the trial run.
        """
        files = {**self.files, **self.tried_with} if on_trial else self.files
        return archived({path: files[path] for path in sorted(files)})


def archived(files: Mapping[str, bytes]) -> bytes:
    """Return a zip archive of files in their order; the same files give the same bytes.

    Parameters
    ----------
    files : mapping of str to bytes
        By path; FMUs are stored as they are, since they are compressed already.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, PINNED_TIME)
            packed = zipfile.ZIP_STORED if path.endswith(".fmu") else zipfile.ZIP_DEFLATED
            entry.compress_type = packed
            entry.create_system = 3  # the same on every system
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return stream.getvalue()


def build(recipe: Recipe) -> Package:
    """Return the FMU of a recipe.

    Parameters
    ----------
    recipe : Recipe
        The same recipe gives the same bytes, and so the same GUID.

    Raises
    ------
    BundleError
        For a module whose imports cannot be bundled.
    UnitError
        For a variable with an unknown unit.
    """
    name = recipe.identity.name
    bundle = collect(
        recipe.module,
        recipe.roots,
        recipe.whole,
        recipe.third_party,
        added=recipe.added,
        left_out=recipe.left_out,
    )
    content = hashlib.sha256(f"{bundle.digest()}\0{recipe.slave}\0{name}".encode())
    for path in sorted(recipe.data):
        content.update(path.encode() + b"\0" + hashlib.sha256(recipe.data[path]).digest())
    root = f"drift_{name}_{content.hexdigest()[:16]}"
    script = f"{root}_slave"

    files = {f"resources/{path}": text.encode() for path, text in bundle.files(root).items()}
    files |= {f"resources/{path}": data for path, data in recipe.data.items()}
    files["resources/slavemodule.txt"] = script.encode()
    files[f"resources/{script}.py"] = SCRIPT.format(
        module=f"{root}.{recipe.module}", slave=recipe.slave, oldest=OLDEST_PYTHON
    ).encode()
    needed = sorted(bundle.third_party)
    if needed:
        lines = [f"{package}{recipe.third_party[package]}\n" for package in needed]
        files["resources/requirements.txt"] = "".join(lines).encode()
    files |= _binaries(name)
    files["model.png"] = recipe.icon
    files["documentation/licenses/license.txt"] = LICENCE.read_bytes()
    files["documentation/licenses/pythonfmu.txt"] = _pythonfmu_licence()

    slave = slave_of(recipe)
    page = index_page(recipe.page, recipe.identity, slave.variables, in_python(needed))
    files["documentation/index.html"] = page.encode()
    files["modelDescription.xml"] = model_description(slave, recipe.identity, guid="")
    guid = guid_of(files)
    files["modelDescription.xml"] = model_description(slave, recipe.identity, guid)
    return Package(name, guid, files, slave)


def slave_of(recipe: Recipe) -> DriftSlave:
    """Return an instance of the project's slave, unbundled, with the recipe's data.

    Parameters
    ----------
    recipe : Recipe
    """
    kind: Any = getattr(importlib.import_module(recipe.module), recipe.slave)
    with tempfile.TemporaryDirectory(prefix="fmu_") as folder:
        for path, data in recipe.data.items():
            (Path(folder) / path).write_bytes(data)
        slave: DriftSlave = kind(instance_name=recipe.identity.name, resources=folder)
    return slave


def _binaries(name: str) -> dict[str, bytes]:
    folder = Path(pythonfmu.__file__).parent / "resources" / "binaries"
    return {
        f"binaries/{path.parent.name}/{name}{path.suffix}": path.read_bytes()
        for path in sorted(folder.glob("*/*"))
        if path.suffix in {".so", ".dll", ".dylib"}
    }


def _pythonfmu_licence() -> bytes:
    """Return the licence of the binaries and the base class that every FMU contains."""
    for entry in metadata.files("pythonfmu") or ():
        if entry.name.upper().startswith("LICEN"):
            return entry.locate().read_bytes()  # type: ignore[attr-defined, no-any-return]
    raise FileNotFoundError("the installed pythonfmu has no licence file")


def guid_of(files: Mapping[str, bytes]) -> str:
    """Return a GUID for this content.

    Parameters
    ----------
    files : dict of str to bytes
        Content by path; the order does not matter.
    """
    state = hashlib.sha256()
    for path in sorted(files):
        state.update(path.encode() + b"\0" + hashlib.sha256(files[path]).digest())
    return "{" + str(uuid.UUID(bytes=state.digest()[:16], version=5)) + "}"
