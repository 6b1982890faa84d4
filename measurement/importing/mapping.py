"""The mapping file: the decisions of a first import, for a person to correct and reuse."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import tomlkit
from pydantic import BaseModel, ConfigDict, Field

from measurement.errors import BadInput, checked
from measurement.files import read_toml

KIND = "spindle-drift import"
HEAD = """\
How this log becomes run files; the next import into this folder follows it.
A column without a unit, or with keep = false, is left out. Known units are those of the header or
degC, K, degF, um, mm, rpm, mm/min, Nm, W, kW, l/min, s, min, h and 1 (a flag).
"""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class TimeRule(_Strict):
    """How the time of a table is read.

    Attributes
    ----------
    columns : list of str
        Header of the time column, or headers of date and time of day.
    unit : str
        Unit of a number: s, ms, min, h or d.
    day_first : bool, optional
        Whether 03/04 is the 3rd of April.
    timezone : str
        IANA name, if the clock follows summer time.
    every_row_s : float
        For tables without a time: time from row to row; else 0 [s].
    """

    columns: list[str] = Field(default_factory=list)
    unit: str = ""
    day_first: bool | None = None
    timezone: str = ""
    every_row_s: float = Field(default=0.0, ge=0.0, le=86400.0)


class ColumnRule(_Strict):
    """What a column of a log is.

    Attributes
    ----------
    name : str
        The signal's name in the run file, without its unit.
    unit : str
        Unit of the log's numbers; empty if unknown.
    keep : bool
        Whether to keep the column.
    sign : int
        -1 reverses the sign.
    """

    name: str
    unit: str = ""
    keep: bool = True
    sign: Literal[1, -1] = 1


class Mapping(_Strict):
    """A mapping file.

    Attributes
    ----------
    format : int
    kind : str
    split : str
        ``pauses``, ``days`` or ``none``: where a log is cut into runs.
    pause_s : float
        A longer pause ends a run [s].
    cold_after_s : float
        A machine is cold after a rest of this length [s].
    every_s : float
        Step of an even grid for the runs; 0 leaves the rows as they are [s].
    time : TimeRule
    columns : dict of str to ColumnRule
        By header.
    """

    format: Literal[1] = 1
    kind: Literal["spindle-drift import"] = "spindle-drift import"
    split: Literal["pauses", "days", "none"] = "pauses"
    pause_s: float = Field(default=1800.0, gt=0.0, le=1e9)
    cold_after_s: float = Field(default=28800.0, gt=0.0, le=1e9)
    every_s: float = Field(default=0.0, ge=0.0, le=86400.0)
    time: TimeRule = Field(default_factory=TimeRule)
    columns: dict[str, ColumnRule] = Field(default_factory=dict)


def adjusted(mapping: Mapping, source: str, **rules: object) -> Mapping:
    """Return a mapping with some rules, including those of its time, replaced.

    Parameters
    ----------
    mapping : Mapping
    source : str
        Where the rules come from, for the refusal.
    **rules
        None leaves a rule unchanged; ``time`` may be the header of the time column.

    Raises
    ------
    BadInput
        For a rule that is unknown or not allowed.
    """
    table = mapping.model_dump(exclude_none=True)
    for name, value in rules.items():
        if value is None:
            continue
        if name == "time" and isinstance(value, str):
            table["time"]["columns"] = [value]
        elif name in TimeRule.model_fields:
            table["time"][name] = value
        else:
            table[name] = value
    return checked(Mapping, table, source)


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Mapping
        Decisions of an earlier import.

    Raises
    ------
    BadInput
        If it is not a mapping file, or something in it is not allowed.
    """
    table = read_toml(path)
    if table.get("kind") != KIND:
        raise BadInput(path, "kind", f'is not "{KIND}": no mapping file')
    return checked(Mapping, table, path)


def mapping_text(mapping: Mapping, remarks: dict[str, str]) -> str:
    """Return a mapping file's text.

    Parameters
    ----------
    mapping : Mapping
    remarks : dict of str to str
        Comment after each column.
    """
    document = tomlkit.document()
    for line in HEAD.splitlines():
        document.add(tomlkit.comment(line))
    for key, value in mapping.model_dump(exclude_none=True, exclude={"columns"}).items():
        document[key] = value
    place = tomlkit.table()
    for header, rule in mapping.columns.items():
        entry = tomlkit.inline_table()
        more = rule.model_dump(include={"keep", "sign"}, exclude_defaults=True)
        entry.update({"name": rule.name, "unit": rule.unit, **more})
        place[header] = entry
        if header in remarks:
            place[header].comment(remarks[header])
    document["columns"] = place
    return tomlkit.dumps(document)
