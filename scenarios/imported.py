"""Writes the folder of an import: run files, their mapping, and a manifest of the files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from measurement.errors import BadInput
from measurement.files import holding, read_bytes, sha256_of, write_together
from measurement.importing.log import Imported
from measurement.importing.splitting import Piece
from measurement.runs import Run, run_text
from scenarios.outputs import OTHERWISE, is_forced, is_input

KIND = "spindle-drift imported runs"
MAPPING, MANIFEST = "import.toml", "imported.json"


def write_imported(
    imported: Imported,
    paths: Sequence[Path],
    folder: Path,
    *,
    with_mapping: bool,
    followed: bytes | None = None,
) -> list[Path]:
    """Write runs, the manifest and, if asked, the mapping file into a folder.

    A run file that an earlier import wrote from the same log is replaced if it is unchanged; any
    other file of that name is replaced only with ``--force``. Imports into one folder wait for each
    other.

    Parameters
    ----------
    imported : Imported
    paths : sequence of Path
        The imported files.
    folder : Path
        Created if missing; other files in it stay.
    with_mapping : bool
        Whether to write the mapping file.
    followed : bytes, optional
        The folder's mapping file when the import read it; None if there was none.

    Returns
    -------
    list of Path
        The run files.

    Raises
    ------
    BadInput
        If a file is in the way, or the mapping file has changed; nothing is written then.
    """
    targets = [folder / f"{run.name}.csv" for run in imported.runs]
    sources = [{"file": path.name, "sha256": sha256_of(path)} for path in paths]
    with holding(folder):
        listed = _manifest(folder)
        files: dict[Path, str | bytes] = {}
        for piece, target in zip(imported.pieces, targets, strict=True):
            data = run_text(piece.run).encode()
            sha256 = hashlib.sha256(data).hexdigest()
            # What an import that was cut off has left is not in the way of its repetition.
            if not (target.is_file() and not is_input(target) and sha256_of(target) == sha256):
                _check(target, listed, piece, sources)
            files[target] = data
            listed[target.name] = {
                "sha256": sha256,
                "starts": piece.starts,
                "warm_start": piece.warm,
                "sources": sources,
            }
        table = {"kind": KIND, "format": 1, "runs": listed}
        files[folder / MANIFEST] = json.dumps(table, indent=1, sort_keys=True) + "\n"
        if with_mapping:
            mapping = folder / MAPPING
            if not is_forced() and mapping_in(folder) != followed:
                raise BadInput(mapping, "", "has changed since this import began: import again")
            files[mapping] = imported.mapping_text()
        write_together(files)
    return targets


def mapping_in(folder: Path) -> bytes | None:
    """Return the content of a folder's mapping file; None if there is none."""
    path = folder / MAPPING
    return read_bytes(path) if path.exists() else None


def _check(
    target: Path, listed: dict[str, Any], piece: Piece, sources: Sequence[dict[str, str]]
) -> None:
    if is_forced() or not target.exists():
        return
    if is_input(target):
        raise BadInput(target, "", f"is an input of this command: {OTHERWISE}")
    entry = listed.get(target.name)
    if not isinstance(entry, dict) or entry.get("sha256") != sha256_of(target):
        why = "and was changed since it was imported" if entry else "and was not imported"
        raise BadInput(target, "", f"exists {why}: {OTHERWISE}")
    # A run with a date is named after its start, so log.csv of another day is another run.
    if not piece.starts[:1].isdigit() and not any(entry in sources for entry in entry["sources"]):
        why = "and was imported from another log: import both at once, choose another folder"
        raise BadInput(target, "", f"exists {why}, or let --force replace it")


def _manifest(folder: Path) -> dict[str, Any]:
    """Return the folder's manifest, by file; empty if there is none."""
    if not (folder / MANIFEST).exists():
        return {}
    try:
        table = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        runs = table["runs"] if table["kind"] == KIND else None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        runs = None
    if not isinstance(runs, dict):
        raise BadInput(folder / MANIFEST, "", "is no list of imported runs: choose another folder")
    return dict(runs)


def table_text(imported: Imported, files: Sequence[Path]) -> str:
    """Return the imported runs as a table for a terminal.

    Parameters
    ----------
    imported : Imported
    files : sequence of Path
        The files written, in the order of the runs.
    """
    began = {True: "began warm", False: "began cold", None: ""}
    lines = []
    for piece, file in zip(imported.pieces, files, strict=True):
        run: Run = piece.run
        hours = (run.time_s[-1] - run.time_s[0]) / 3600.0
        rest = "" if piece.rested_s != piece.rested_s else f"after {piece.rested_s / 3600.0:.1f} h"
        cells = [str(file), piece.starts, f"{hours:.2f} h", f"{len(run.frame)} rows"]
        lines.append("  ".join([*cells, rest, began[piece.warm]]).rstrip())
    return "\n".join(lines)
