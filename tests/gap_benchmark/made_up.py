"""Made-up records, and the plan's cases."""

import json
from pathlib import Path
from typing import Any

from benchmarks.gap.plan import KINDS, Planned, trials
from benchmarks.gap.truths import USUAL
from measurement.files import write_atomically

THERMOMETER = "sensor_offset:T3"


def plan(
    split: str, count: int, kinds: tuple[str, ...] = KINDS, truth: str = USUAL
) -> list[Planned]:
    """Return the first cases of a split."""
    return [one for (one,) in trials(split, count, kinds=kinds, truth=truth)]


def hidden(key: str, size: str = "strong", amplitude: float = 1.0) -> dict[str, Any]:
    name, _, channel = key.partition(":")
    return {"name": name, "channel": channel, "size": size, "amplitude": amplitude, "more": {}}


def added(key: str, **parameters: tuple[float, float, float]) -> dict[str, Any]:
    name, _, channel = key.partition(":")
    entry: dict[str, Any] = {"name": name, "parameters": {}}
    for parameter, (low, value, high) in parameters.items():
        entry["parameters"][parameter] = {"value": value, "low": low, "high": high}
    return entry | ({"channel": channel} if channel else {})


def answer(
    *effects: dict[str, Any],
    one_of: tuple[str, ...] = (),
    verdict: str = "none_missing",
    gap: tuple[float, float] = (4.0, 4.0),
    in_doubt: bool = False,
) -> dict[str, Any]:
    holdout = {"before": gap[0], "after": gap[1], "floor": 0.5}
    return {
        "verdict": "effect" if effects else verdict,
        "effects": list(effects),
        "one_of": list(one_of),
        "gap": {"holdout": holdout},
        "in_doubt": in_doubt,
    }


class Folder:
    """A folder of records."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.written = 0

    def put(
        self,
        kind: str,
        truth: list[dict[str, Any]],
        told: dict[str, Any],
        *,
        empty: float | None = None,
    ) -> None:
        """Add a record, and that of the same machine and runs with nothing hidden."""
        self.written += 1
        self._write(kind, truth, told, f"{self.written:04d}")
        if empty is not None:
            gap = answer(gap=(empty, empty))
            self._write("empty", [], gap, f"{self.written:04d}_empty")

    def _write(self, kind: str, truth: Any, told: Any, name: str) -> None:
        table = {
            "name": name,
            "number": self.written,
            "split": "development",
            "kind": kind,
            "without": [],
            "truth": truth,
            "finder": "0123456789ab",
            "seconds": {"cpu": 10.0 * self.written, "wall": 20.0},
            "answer": told,
        }
        write_atomically(self.folder / f"{name}.json", json.dumps(table))
