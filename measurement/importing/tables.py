"""A sheet as signals: every column named, in the units of a run file, on the sheet's own clock."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping as Mapped
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.importing.clock import Clock, clock_of
from measurement.importing.headers import Heading, signal_name
from measurement.importing.mapping import ColumnRule, Mapping
from measurement.importing.quantities import KNOWN_UNITS, checked_conversion, conversion_of
from measurement.importing.sheets import Sheet, is_missing
from measurement.importing.values import is_numeric, numbers_of
from measurement.units import UNITS, column


@dataclass(frozen=True)
class Table:
    """Signals of a sheet.

    Attributes
    ----------
    sheet : Sheet
    clock : Clock
    frame : DataFrame
        A column for each signal, named as in a run file; a row for each of the clock's.
    sources : dict of str to str
        For each column the header that it came from.
    rules : dict of str to ColumnRule
        By header: what was decided, what could not be placed included.
    hints : dict of str to str
        By header: why a column was left out, and what to do.
    """

    sheet: Sheet
    clock: Clock
    frame: pd.DataFrame
    sources: dict[str, str]
    rules: dict[str, ColumnRule] = field(default_factory=dict)
    hints: dict[str, str] = field(default_factory=dict)

    @property
    def where(self) -> str:
        """How a message names it."""
        return self.sheet.where


def table_of(sheet: Sheet, mapping: Mapping, units: Mapped[str, str]) -> Table:
    """Read a sheet's signals.

    Parameters
    ----------
    sheet : Sheet
    mapping : Mapping
        What it says of a header is done.
    units : mapping of str to str
        Units by header, ``*`` and ``?`` allowed; they win.

    Raises
    ------
    BadInput
        If there is no time, a cell is no number, a value is outside the unit's range, or two
        columns would have one name.
    """
    time = mapping.time
    given = [unit for pattern, unit in units.items() if _timefits(sheet, pattern)]
    if given:
        time = time.model_copy(update={"unit": given[-1]})
    clock = clock_of(sheet, time)
    rules, hints = _rules(sheet, clock, mapping, units)
    _name_the_speed(rules)
    columns: dict[str, np.ndarray] = {}
    sources: dict[str, str] = {}
    for at, entry in enumerate(sheet.headings):
        rule = rules.get(entry.text)
        if rule is None or not rule.keep or not rule.unit:
            continue
        name, values = _signal(sheet, at, rule)
        if name in columns:
            problem = f"would be {name}, as {sources[name]!r} is: give it another name"
            raise BadInput(sheet.where, f"column {entry.text}", problem)
        columns[name], sources[name] = values, entry.text
    return Table(sheet, clock, pd.DataFrame(columns), sources, rules, hints)


def _timefits(sheet: Sheet, pattern: str) -> bool:
    return any(entry.is_time and fits(entry.text, pattern) for entry in sheet.headings)


def fits(header: str, pattern: str) -> bool:
    """Return whether a header is the one meant; brackets are brackets, not classes."""
    return header == pattern or fnmatch.fnmatchcase(header, pattern.replace("[", "[[]"))


def _rules(
    sheet: Sheet, clock: Clock, mapping: Mapping, units: Mapped[str, str]
) -> tuple[dict[str, ColumnRule], dict[str, str]]:
    """Return what to do with each column but time, and a hint for each that is left out."""
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
            unit for pattern, unit in units.items() if fnmatch.fnmatchcase(entry.text, pattern)
        ]
        if asked:
            rule = rule.model_copy(update={"unit": asked[-1], "keep": True})
        rules[entry.text] = rule
        hint = _hint(sheet, at, entry, rule)
        if hint and rule.keep:
            hints[entry.text] = hint
            rules[entry.text] = rule.model_copy(update={"unit": ""})
    return rules, hints


def _hint(sheet: Sheet, at: int, entry: Heading, rule: ColumnRule) -> str:
    """Return why a column cannot be placed, and what would place it; empty if it can."""
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
    """Return a unit that a column may be in; empty without an idea."""
    values = numbers_of(sheet, at)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    plain = name.casefold()
    if "temp" in plain or (plain[:1] == "t" and plain[1:].strip("_ ").isdigit()):
        return "K" if low > 200.0 else "degC" if low > -20.0 and high < 120.0 else ""
    if any(word in plain for word in ("speed", "drehzahl", "spindle", "rpm")) and low >= 0.0:
        return "rpm" if high > 100.0 else ""
    if any(word in plain for word in ("disp", "drift", "growth", "elong", "weg")):
        return "um" if high - low > 1.0 else "mm"
    return ""


def _signal(sheet: Sheet, at: int, rule: ColumnRule) -> tuple[str, np.ndarray]:
    """Return a signal's column name and its values in the run file's unit."""
    place = f"column {sheet.headings[at].text}"

    def refuse(problem: str) -> BadInput:
        return BadInput(sheet.where, place, problem)

    kind = checked_conversion(rule.unit, f"{rule.name} {sheet.headings[at].text}", refuse)
    read = numbers_of(sheet, at)
    values = rule.sign * kind(read)
    unit = UNITS[kind.suffix]
    wrong = np.flatnonzero((values < unit.low) | (values > unit.high))
    if wrong.size:
        row = int(wrong[0])
        converted = (
            "" if kind.factor == 1.0 and not kind.offset else f" ({values[row]:g} {unit.suffix})"
        )
        problem = (
            f"{read[row]:g} {rule.unit}{converted} is outside {unit.low:g}..{unit.high:g} "
            f"{unit.suffix}: is {rule.unit} its unit?"
        )
        raise BadInput(sheet.where, f"row {sheet.rows[row]}, {place}", problem)
    return column(signal_name(rule.name), kind.suffix), values


def _name_the_speed(rules: dict[str, ColumnRule]) -> None:
    """Call the only rotational speed ``speed``, and the only feed ``feed``: commands look there."""
    for suffix, name in (("rpm", "speed"), ("mm_min", "feed")):
        found = [
            header
            for header, rule in rules.items()
            if rule.unit and (kind := conversion_of(rule.unit)) and kind.suffix == suffix
        ]
        if len(found) == 1:
            rules[found[0]] = rules[found[0]].model_copy(update={"name": name})
