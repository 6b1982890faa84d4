"""An FMU as a file: its description, and the folder into which it is unpacked."""

from __future__ import annotations

import contextlib
import zipfile
from collections.abc import Collection
from pathlib import Path
from typing import Any

import fmpy

from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from measurement.errors import BadInput, one_line
from measurement.files import sha256_of
from scenarios.unpacking import Unpacked

MODELS = (f"resources/{MODEL_FILE}", f"documentation/{MODEL_FILE}")
"""Places of the compensator file in an FMU: in Python, and in C (which also has it compiled in)."""


class FmuFile(Unpacked):
    """An FMU file, read and unpacked once for any number of instances.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    description : object
        The model description as fmpy reads it.
    sha256 : str
    folder : Path
        Folder of the unpacked FMU.

    Raises
    ------
    BadInput
        If the file is not an FMU for co-simulation with FMI 2.0.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.description = read_description(path)
        self.sha256 = sha256_of(path)
        super().__init__(path, in_python=self.description.coSimulation.needsExecutionTool)


class Shelf(contextlib.ExitStack):
    """FMU files opened once for consecutive runs; use it in a ``with``."""

    def __init__(self) -> None:
        super().__init__()
        self._files: dict[Path, FmuFile] = {}

    def file(self, path: Path) -> FmuFile:
        """Return the file of a path, as it was at the first call.

        Parameters
        ----------
        path : Path
            Read at the first call only.
        """
        if path not in self._files:
            self._files[path] = FmuFile(path)
            self.callback(self._files[path].remove)
        return self._files[path]


def member(fmu: Path, *names: str) -> bytes | None:
    """Return the first of these files in an FMU; None if it has none, or is not an FMU.

    Parameters
    ----------
    fmu : Path
    *names : str
        Paths inside it.
    """
    try:
        with zipfile.ZipFile(fmu) as archive:
            there = set(archive.namelist())
            return next((archive.read(name) for name in names if name in there), None)
    except (OSError, zipfile.BadZipFile):
        return None


def compensator_file(fmu: Path) -> str | None:
    """Return the text of the compensator file in an FMU; None if it has no readable one.

    Parameters
    ----------
    fmu : Path
        In Python or in C.
    """
    data = member(fmu, *MODELS)
    try:
        return None if data is None else data.decode("utf-8")
    except UnicodeDecodeError:
        return None


def read_description(path: Path, versions: Collection[str] = ("2.0",)) -> Any:
    """Return the model description of an FMU.

    Parameters
    ----------
    path : Path
    versions : collection of str
        Accepted FMI versions.

    Returns
    -------
    ModelDescription
        As fmpy reads it.

    Raises
    ------
    BadInput
        If the file is not an FMU for co-simulation with one of them.
    """
    if not path.is_file():
        raise BadInput(path, "", "there is no such file")
    try:
        description = fmpy.read_model_description(str(path), validate=False)
    except Exception as error:  # fmpy raises whatever its zip and XML readers raise
        raise BadInput(path, "", f"is not an FMU: {one_line(error)[:200]}") from None
    if description.fmiVersion not in versions or description.coSimulation is None:
        problem = f"is not an FMU for co-simulation by FMI {' or '.join(versions)}"
        if description.fmiVersion == "3.0":
            problem += "; use what it was built from (.json, .toml), or build it without --fmi 3"
        raise BadInput(path, "", problem)
    return description
