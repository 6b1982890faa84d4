"""The folder of a sweep: its identity, and one file for each finished case.

A case's file is written whole or not at all and depends only on the case. So a killed sweep can be
resumed, and a case that ran twice is stored once.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from measurement.errors import BadInput
from measurement.files import write_atomically
from scenarios.sweep.plan import Plan

KIND = "spindle-drift sweep"
HEAD, CASES = "sweep.json", "cases"
OTHERWISE = "choose another folder with --out"


class Store:
    """The folder of one sweep.

    Parameters
    ----------
    folder : Path
        New, empty, or of the same sweep.
    plan : Plan

    Raises
    ------
    BadInput
        If the folder contains another sweep or other files, or cannot be used.
    """

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder = folder
        self._count = len(plan.jobs)
        text = json.dumps(plan.identity, sort_keys=True)
        self.digest = hashlib.sha256(text.encode()).hexdigest()
        try:
            begun = folder.is_dir() and any(folder.iterdir())
            if folder.exists() and not folder.is_dir():
                raise BadInput(folder, "", "is a file; a folder for the results is needed")
        except OSError as error:
            raise BadInput(folder, "", f"cannot be used: {error.strerror}") from None
        if begun:
            self._check_same(plan.identity)
            return
        head = {"kind": KIND, "format": 1, "digest": self.digest, "identity": plan.identity}
        write_atomically(folder / HEAD, json.dumps(head, indent=1, ensure_ascii=False) + "\n")

    def _check_same(self, identity: dict[str, Any]) -> None:
        try:
            head = json.loads((self.folder / HEAD).read_text(encoding="utf-8"))
            there = head["identity"] if head["kind"] == KIND else None
        except (OSError, ValueError, RecursionError, KeyError, TypeError):
            there = None
        if not isinstance(there, dict):
            raise BadInput(self.folder, "", f"holds files and no sweep: {OTHERWISE}")
        if there == identity:
            return
        key = next(key for key in identity if there.get(key) != identity[key])
        was, now = (json.dumps(entry.get(key)) for entry in (there, identity))
        other = f"{key} is {was}, not {now}"
        if max(len(was), len(now)) > 80 or key in ("text", "FMUs"):
            other = {"text": "the scenario's text differs", "FMUs": "its FMUs differ"}.get(
                key, f"{key} differs"
            )
        raise BadInput(self.folder, "", f"holds another sweep ({other}): {OTHERWISE}")

    def _path(self, number: int) -> Path:
        return self.folder / CASES / f"{number:06d}.json"

    def record(self, outcome: dict[str, Any]) -> None:
        """Store the outcome of one case."""
        entry = {"sweep": self.digest, **outcome}
        write_atomically(self._path(outcome["number"]), json.dumps(entry, allow_nan=False) + "\n")

    def outcomes(self) -> dict[int, dict[str, Any]]:
        """Return the outcomes so far, by number; unreadable ones count as missing."""
        by_number = {}
        for number in range(self._count):
            try:
                entry = json.loads(self._path(number).read_text(encoding="utf-8"))
                if entry["sweep"] == self.digest and entry["number"] == number:
                    by_number[number] = entry
            except (OSError, ValueError, KeyError, TypeError):
                continue
        return by_number
