"""Reads logs of measuring systems, TDMS (LabVIEW) and MDF (ASAM), with optional libraries."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.importing.cells import Cell, Sheet
from measurement.importing.headers import headings
from measurement.resampling import FloatArray

Channel = tuple[str, str, list[Cell]]
"""Name, unit and values; the unit is empty if the name may contain it."""


def clock(times: FloatArray) -> Channel:
    """Return times [s] as the time channel of a sheet."""
    return "time", "s", times.tolist()


def read_log(path: Path) -> list[Sheet]:
    """Read a TDMS or MDF log; each group of channels with its own clock is a sheet.

    Raises
    ------
    BadInput
        If the library is not installed, or the file cannot be read.
    """
    tdms = path.suffix.lower() == ".tdms"
    library, extra = ("nptdms", "tdms") if tdms else ("asammdf", "mdf")
    try:
        return list(_tdms(path) if tdms else _mdf(path))
    except ImportError:
        raise BadInput(path, "", f"needs {library}: pip install 'spindle-drift[{extra}]'") from None
    except BadInput:
        raise
    except Exception as error:  # a damaged log makes these libraries raise anything
        raise BadInput(path, "", f"cannot be read by {library}: {error}") from None


def _tdms(path: Path) -> Iterable[Sheet]:
    from nptdms import TdmsFile

    for group in TdmsFile.read(path).groups():
        channels = [channel for channel in group.channels() if len(channel)]
        with_clock = [channel for channel in channels if "wf_increment" in channel.properties]
        if not channels:
            continue
        columns = [clock(_waveform(with_clock[0]))] if with_clock else []
        for channel in with_clock or channels:
            unit = str(channel.properties.get("unit_string", ""))
            columns.append((channel.name, unit, cells_of_values(channel[:])))
        lengths = {len(cells) for _, _, cells in columns}
        if len(lengths) > 1:
            problem = f"has channels of {min(lengths)} and of {max(lengths)} values"
            raise BadInput(path, group.name, problem)
        yield sheet_of(path, group.name, columns)


def _waveform(channel: Any) -> FloatArray:
    """Return the times of a waveform's samples [s], since 1970 if its start is known."""
    properties = channel.properties
    start = properties.get("wf_start_time")
    zero = 0.0 if start is None else pd.Timestamp(start).timestamp()
    step = float(properties["wf_increment"])
    offset = float(properties.get("wf_start_offset", 0.0))
    return np.asarray(zero + offset + step * np.arange(len(channel)))


def _mdf(path: Path) -> Iterable[Sheet]:
    from asammdf import MDF

    with MDF(path) as log:
        start = log.header.start_time
        zero = 0.0 if start is None else pd.Timestamp(start).timestamp()
        by_clock: dict[bytes, list[Channel]] = {}
        for group in log.virtual_groups:
            for signal in log.select(_places(log, group)):
                if not len(signal.samples) or signal.samples.ndim != 1:
                    continue
                times = np.asarray(signal.timestamps, dtype=np.float64)
                columns = by_clock.setdefault(times.tobytes(), [clock(zero + times)])
                cells = cells_of_values(signal.samples)
                columns.append((signal.name, signal.unit or "", cells))
    for number, columns in enumerate(by_clock.values(), 1):
        yield sheet_of(path, f"group {number}", columns)


def _places(log: Any, group: int) -> list[tuple[None, int, int]]:
    """Return the places of a group's channels, except its clock."""
    by_part = log.included_channels(group)[group]
    return [(None, part, channel) for part, channels in by_part.items() for channel in channels]


def cells_of_values(values: Any) -> list[Any]:
    """Return the values of a channel as cells: times, numbers or texts."""
    cells = np.asarray(values)
    if cells.dtype.kind == "M":
        return [pd.Timestamp(stamp).to_pydatetime() for stamp in cells]
    return cells.tolist() if cells.dtype.kind in "biuf" else [str(cell) for cell in cells]


def sheet_of(path: Path, title: str, channels: Sequence[Channel]) -> Sheet:
    """Return channels of equal length as a sheet."""
    names, units, columns = (list(part) for part in zip(*channels, strict=True))
    rows = list(range(1, len(columns[0]) + 1))
    return Sheet(path, title, tuple(headings(names, units)), columns, rows)
