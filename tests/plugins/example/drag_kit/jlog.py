"""Logs with one JSON object a line."""

from __future__ import annotations

from pathlib import Path

import pandas as pd


def read(path: Path) -> dict[str, pd.DataFrame]:
    """Return the one table of a log."""
    return {"": pd.read_json(path, lines=True)}
