"""Reads a sheet's signals: named columns in the units of a run file, on the sheet's own clock."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping as Mapped
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.importing.cells import Sheet, is_missing
from measurement.importing.clock import Clock, clock_of
from measurement.importing.headers import Heading, signal_name
from measurement.importing.mapping import ColumnRule, Mapping
from measurement.importing.quantities import (
    KNOWN_UNITS,
    Conversion,
    checked_conversion,
    conversion_of,
)
from measurement.importing.values import is_numeric, numbers_of
from measurement.rig import PLACES, FivePointRig, axis_of
from measurement.units import UNITS, column

DISPLACEMENT = {1.0: "1000 um", 1e3: "1000000 um", 25.4: "1000 mil"}
"""The same displacement by a unit's size in millimetres, whatever its column is called."""


@dataclass(frozen=True)
class Table:
    """Signals of a sheet.

    Attributes
    ----------
    sheet : Sheet
    clock : Clock
    frame : DataFrame
        One column per signal, named as in a run file; one row per row of the clock.
    sources : dict of str to str
        Header that each column came from.
    rules : dict of str to ColumnRule
        By header: the decisions, including those on unidentified columns.
    hints : dict of str to str
        By header: why a column was left out, and what to do.
    notes : tuple of str
        Values treated as missing.
    """

    sheet: Sheet
    clock: Clock
    frame: pd.DataFrame
    sources: dict[str, str]
    rules: dict[str, ColumnRule] = field(default_factory=dict)
    hints: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def where(self) -> str:
        """Its name in messages."""
        return self.sheet.where


def table_of(
    sheet: Sheet, mapping: Mapping, units: Mapped[str, str], axes: Mapped[str, str]
) -> Table:
    """Read a sheet's signals.

    Parameters
    ----------
    sheet : Sheet
    mapping : Mapping
        Its rules for headers are applied.
    units : mapping of str to str
        Units by header, ``*`` and ``?`` allowed; they take precedence. With ``*`` or ``?`` only
        over another unit of the same quantity, or if the header has none.
    axes : mapping of str to str
        Axes of displacements by header, such as ``X`` or ``-Z``, ``*`` and ``?`` allowed.

    Raises
    ------
    BadInput
        If there is no time, a cell is not a number, values are outside the unit's range, or two
        columns would have the same name.
    """
    time = mapping.time
    given = [unit for pattern, unit in units.items() if _times(sheet, time.columns, pattern, unit)]
    if given:
        time = time.model_copy(update={"unit": given[-1]})
    clock = clock_of(sheet, time)
    notes = ["rows are newest first: turned round"] if clock.newest_first else []
    sheet = sheet.turned() if clock.newest_first else sheet
    rules, hints = _rules(sheet, clock, mapping, units)
    _name_the_speed(rules, hints)
    _name_the_axes(rules, axes)
    columns: dict[str, np.ndarray] = {}
    sources: dict[str, str] = {}
    for at, entry in enumerate(sheet.headings):
        rule = rules.get(entry.text)
        if rule is None or not rule.keep or entry.text in hints:
            continue
        name, values = _signal(sheet, at, rule, notes)
        if name in columns:
            problem = f"would be {name}, as {sources[name]!r} is: give it another name"
            raise BadInput(sheet.where, f"column {entry.text}", problem)
        columns[name], sources[name] = values, entry.text
    return Table(sheet, clock, pd.DataFrame(columns), sources, rules, hints, tuple(notes))


def _times(sheet: Sheet, clocks: Sequence[str], pattern: str, unit: str) -> bool:
    """Return whether a unit is meant for the time column: ``*=degC`` is not."""
    kind = conversion_of(unit)
    of_time = kind is not None and kind.suffix == "s"
    return any(
        entry.text == pattern or (of_time and fits(entry.text, pattern))
        for entry in sheet.headings
        if entry.is_time or entry.text in clocks
    )


def fits(header: str, pattern: str) -> bool:
    """Return whether a header matches; brackets are literal, not character classes.

    A column's name in the run files also matches.
    """
    plain = pattern.replace("[", "[[]")
    return header == pattern or any(
        fnmatch.fnmatchcase(name, plain) for name in (header, signal_name(header))
    )


def _rules(
    sheet: Sheet, clock: Clock, mapping: Mapping, units: Mapped[str, str]
) -> tuple[dict[str, ColumnRule], dict[str, str]]:
    """Return the rule for each column except time, and a hint for each one left out."""
    rules: dict[str, ColumnRule] = {}
    hints: dict[str, str] = {}
    for at, entry in enumerate(sheet.headings):
        if at in clock.columns:
            continue
        if entry.text in rules:
            place = f"column {at + 1}"
            raise BadInput(sheet.where, place, f"{entry.text!r} is the name of an earlier column")
        rule = mapping.columns.get(entry.text) or ColumnRule(
            name=signal_name(entry.name), unit=entry.unit
        )
        asked = [
            unit
            for pattern, unit in units.items()
            if fits(entry.text, pattern) and (entry.text == pattern or _may_be(rule, unit))
        ]
        if asked:
            rule = rule.model_copy(update={"unit": asked[-1], "keep": True})
        rules[entry.text] = rule
        hint = _hint(sheet, at, entry, rule)
        if hint and rule.keep:
            hints[entry.text] = hint
    return rules, hints


def _may_be(rule: ColumnRule, unit: str) -> bool:
    """Return whether a unit for many columns applies to this one: same or unknown quantity."""
    given, asked = conversion_of(rule.unit, rule.name), conversion_of(unit, rule.name)
    return given is None or (asked is not None and asked.suffix == given.suffix)


def _hint(sheet: Sheet, at: int, entry: Heading, rule: ColumnRule) -> str:
    """Return why a column cannot be identified, and how to include it; empty if it can."""
    if all(is_missing(cell) for cell in sheet.columns[at]):
        return "holds no value"
    if rule.unit:
        return ""
    if not is_numeric(sheet, at):
        return "holds no numbers"
    said = f"its unit {entry.said!r} is not known" if entry.said else "it has no unit"
    likely = _likely(entry.name, sheet, at)
    example = f"--unit '{entry.text}={likely or 'UNIT'}'"
    guess = f"; by its name and values perhaps {likely}" if likely else f" (known: {KNOWN_UNITS})"
    return f"{said}{guess}: {example}, or keep = false in the mapping file"


def _likely(name: str, sheet: Sheet, at: int) -> str:
    """Return a likely unit of a column; empty if there is none."""
    values = numbers_of(sheet, at)
    values = values[np.isfinite(values)]
    low, high = float(values.min()), float(values.max())
    plain = name.casefold()
    if "temp" in plain or (plain[:1] == "t" and plain[1:].strip("_ ").isdigit()):
        return "K" if low > 200.0 else "degC" if low > -20.0 and high < 120.0 else ""
    if any(word in plain for word in ("speed", "drehzahl", "spindle", "rpm")) and low >= 0.0:
        return "rpm" if high > 100.0 else ""
    if any(word in plain for word in ("disp", "drift", "growth", "elong", "weg")):
        return "um" if high - low > 1.0 else "mm"
    return ""


def _signal(sheet: Sheet, at: int, rule: ColumnRule, notes: list[str]) -> tuple[str, np.ndarray]:
    """Return a signal's column name and its values in the run file's unit.

    If all values outside the unit's range are the same number, such as -999, it is a recorder's
    mark for a broken wire, and they become missing, as infinite ones do.
    """
    place = f"column {sheet.headings[at].text}"
    named = f"{rule.name} {sheet.headings[at].text}"
    kind = checked_conversion(rule.unit, named, sheet.where, place)
    read = numbers_of(sheet, at)
    values = rule.sign * kind(read)
    unit = UNITS[kind.suffix]
    infinite = np.isinf(values)
    outside = ((values < unit.low) | (values > unit.high)) & ~infinite
    for wrong in (infinite, outside):
        if not wrong.any():
            continue
        row = int(np.argmax(wrong))
        converted = (
            "" if kind.factor == 1.0 and not kind.offset else f" ({values[row]:g} {unit.suffix})"
        )
        problem = (
            f"{read[row]:g} {rule.unit}{converted} is outside {unit.low:g}..{unit.high:g} "
            f"{unit.suffix}"
        )
        where = f"row {sheet.rows[row]}, {place}"
        alike = len(set(read[wrong])) == 1 and wrong.sum() < np.isfinite(values).sum()
        if wrong is outside and not alike:
            raise BadInput(sheet.where, where, f"{problem}: is {rule.unit} its unit?")
        values[wrong] = np.nan
        count = f"it and {wrong.sum() - 1} more are" if wrong.sum() > 1 else "it is"
        notes.append(f"{where}: {problem}: {count} taken for missing")
    return column(signal_name(rule.name), kind.suffix), values


def _name_the_speed(rules: dict[str, ColumnRule], hints: Mapped[str, str]) -> None:
    """Rename the only rotational speed ``speed`` and the only feed ``feed``, as commands expect."""
    for suffix, name in (("rpm", "speed"), ("mm_min", "feed")):
        unnamed = [
            header
            for header, rule in rules.items()
            if header not in hints and (kind := conversion_of(rule.unit)) and kind.suffix == suffix
        ]
        if len(unnamed) == 1:
            rules[unnamed[0]] = rules[unnamed[0]].model_copy(update={"name": name})


def _name_the_axes(rules: dict[str, ColumnRule], axes: Mapped[str, str]) -> None:
    """Put the given axes into the names of displacements, where commands read them."""
    for header, rule in rules.items():
        # If given for exactly this column, an axis also makes a length a displacement.
        kind = _conversion(rule)
        moved = DISPLACEMENT.get(kind.factor) if kind and kind.suffix == "mm" else None
        given = [
            axis
            for pattern, axis in axes.items()
            if (header == pattern and moved) or (fits(header, pattern) and is_displacement(rule))
        ]
        if not given:
            continue
        if moved:
            rule = rule.model_copy(update={"unit": moved})
        axis = given[-1].lstrip("+-").lower()
        named = axis_of(rule.name)
        name = rule.name if named == (axis.upper(), 1) else f"{rule.name}_{axis}"
        if axis_of(name) != (axis.upper(), 1):  # the name has another axis
            name = f"disp_{axis}"
        sign = -1 if given[-1].startswith("-") else 1
        rules[header] = rule.model_copy(update={"name": name, "sign": sign})


def is_displacement(rule: ColumnRule) -> bool:
    """Return whether a column is kept and is a displacement."""
    kind = _conversion(rule)
    return kind is not None and kind.suffix == "um"


def _conversion(rule: ColumnRule) -> Conversion | None:
    """Return a column's conversion; None if it is not kept or has no unit."""
    return conversion_of(rule.unit, rule.name) if rule.unit and rule.keep else None


def axes_to_ask(rules: Mapped[str, ColumnRule]) -> list[str]:
    """Return the headers of displacements whose axis is unknown.

    Five sensors named like those of the usual five-point rig need no axis.
    """
    moved = {header: rule.name for header, rule in rules.items() if is_displacement(rule)}
    if {FivePointRig.model_fields[place].default for place in PLACES} <= set(moved.values()):
        return []
    return [header for header, name in moved.items() if axis_of(name) is None]
