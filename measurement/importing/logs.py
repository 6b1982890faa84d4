"""Logs of measuring systems: TDMS (LabVIEW) and MDF (ASAM), where their libraries are installed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.importing.headers import Heading, heading
from measurement.importing.sheets import Sheet
from measurement.resampling import FloatArray

CLOCK = Heading("time [s]", "time", "s", "s")


def read_log(path: Path) -> list[Sheet]:
    """Read a TDMS or MDF log; each group of channels with a clock of its own is a sheet.

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
        problem = f"needs {library}: pip install 'spindle-drift[{extra}]'"
        raise BadInput(path, "", problem) from None
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
        columns: dict[Heading, list[Any]] = {}
        if with_clock:
            channels = with_clock
            columns[CLOCK] = _waveform(with_clock[0]).tolist()
        for channel in channels:
            unit = str(channel.properties.get("unit_string", ""))
            columns[heading(channel.name, unit)] = cells_of_values(channel[:])
        lengths = {len(cells) for cells in columns.values()}
        if len(lengths) > 1:
            problem = f"has channels of {min(lengths)} and of {max(lengths)} values"
            raise BadInput(path, group.name, problem)
        yield sheet_of(path, group.name, columns)


def _waveform(channel: Any) -> FloatArray:
    """Return the times of a waveform's samples, since 1970 where its start is known [s]."""
    told = channel.properties
    start = told.get("wf_start_time")
    zero = 0.0 if start is None else pd.Timestamp(start).timestamp()
    step = float(told["wf_increment"])
    offset = float(told.get("wf_start_offset", 0.0))
    return np.asarray(zero + offset + step * np.arange(len(channel)))


def _mdf(path: Path) -> Iterable[Sheet]:
    from asammdf import MDF

    with MDF(path) as log:
        start = log.header.start_time
        zero = 0.0 if start is None else pd.Timestamp(start).timestamp()
        by_clock: dict[bytes, dict[Heading, list[Any]]] = {}
        for group in log.virtual_groups:
            for signal in log.select(_places(log, group)):
                if not len(signal.samples) or signal.samples.ndim != 1:
                    continue
                times = np.asarray(signal.timestamps, dtype=np.float64)
                columns = by_clock.setdefault(times.tobytes(), {CLOCK: (zero + times).tolist()})
                columns[heading(signal.name, signal.unit or "")] = cells_of_values(signal.samples)
    for number, columns in enumerate(by_clock.values(), 1):
        yield sheet_of(path, f"group {number}", columns)


def _places(log: Any, group: int) -> list[tuple[None, int, int]]:
    """Return where the channels of a group are, its clock left out."""
    found = log.included_channels(group)[group]
    return [(None, part, channel) for part, channels in found.items() for channel in channels]


def cells_of_values(values: Any) -> list[Any]:
    """Return the values of a channel as cells: times, numbers or texts."""
    cells = np.asarray(values)
    if cells.dtype.kind == "M":
        return [pd.Timestamp(stamp).to_pydatetime() for stamp in cells]
    return cells.tolist() if cells.dtype.kind in "biuf" else [str(cell) for cell in cells]


def sheet_of(path: Path, title: str, columns: dict[Heading, list[Any]]) -> Sheet:
    """Return columns of cells as a sheet."""
    rows = list(range(1, len(next(iter(columns.values()))) + 1))
    return Sheet(path, title, tuple(columns), list(columns.values()), rows)
