"""Splits headers as people write them into a column's name and unit."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from measurement.importing.quantities import conversion_of
from measurement.units import split_column

_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[\(\{<](?P<unit>[^\[\]\(\)\{\}<>]*)[\]\)\}>]\s*$")
_DEGREES = r"(?:(?i:deg\.?|degrees?|grad) )?"
_SEPARATED = re.compile(
    rf"^(?P<name>.+?)\s*(?:,|;|\bin\b|\s/|/(?=°)|:)\s*(?P<unit>{_DEGREES}\S{{1,10}})$"
)
_QUOTIENT = re.compile(r"^(?P<name>[^\s/]+)/(?P<unit>\S{1,10})$")
_LAST_WORD = re.compile(rf"^(?P<name>.+?)[\s_](?P<unit>{_DEGREES}[^\s_]{{1,8}})$")
_TIME = re.compile(
    r"^(?:elapsed|rel\w*|abs\w*|local|log|mess|sample)?[\s_]*"
    r"(?:time|zeit|timestamp|zeitstempel|date|datum|datetime|uhrzeit|date[\s_/&+]*time|"
    r"datum[\s_/&+]*(?:uhr)?zeit|time[\s_]*stamp|t)$",
    re.IGNORECASE,
)
_TRANSLITERATED = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "Ä": "Ae"}) | (
    str.maketrans({"Ö": "Oe", "Ü": "Ue", "µ": "u", "°": "deg", "ø": "o", "Δ": "delta"})
)


@dataclass(frozen=True)
class Heading:
    """A header split into name and unit.

    Attributes
    ----------
    text : str
        As in the file; a unit from a second header line is added in brackets.
    name : str
        What is measured, as in the file.
    unit : str
        The unit as in the file; empty if it has no known unit.
    said : str
        The text in place of a unit, whether or not it is a known unit.
    """

    text: str
    name: str
    unit: str
    said: str = ""

    @property
    def is_time(self) -> bool:
        """Whether the name means time."""
        return bool(_TIME.match(self.name.strip()))


def _heading(text: str, second: str) -> Heading:
    """Split one header, regardless of the others."""
    text = " ".join(text.split())
    second = " ".join(second.split())
    if second:
        said = second.strip("[](){}<> ")
        unit = said if conversion_of(said) else ""
        return Heading(f"{text} [{said}]", text, unit, said)
    try:
        name, suffix = split_column(text)
    except ValueError:
        pass
    else:
        return Heading(text, name, suffix, suffix)
    bracketed = _BRACKETS.match(text)
    if bracketed and bracketed["name"]:
        said = bracketed["unit"].strip()
        return Heading(text, bracketed["name"], said if conversion_of(said) else "", said)
    for pattern in (_SEPARATED, _QUOTIENT, _LAST_WORD):
        match = pattern.match(text)
        if pattern is _QUOTIENT and match and any(map(conversion_of, (text, match["name"]))):
            continue  # "mm/min" is a unit, and "m/s" is not a name and a unit
        word = _LAST_WORD.match(text)
        if pattern is _QUOTIENT and match and word and conversion_of(word["unit"]):
            continue  # "speed_1/s" is in 1/s, and no "speed_1" in s
        # "Temp C" and "Temp K" have a unit; "Spindle 1" and "Bearing s" have none.
        if match and _is_surely_a_unit(match["unit"], pattern is not _LAST_WORD):
            return Heading(text, match["name"], match["unit"], match["unit"])
    word = re.search(r"\b(rpm|krpm)\b", text, re.IGNORECASE)
    return Heading(text, text, word[1] if word else "", word[1] if word else "")


def headings(texts: Sequence[str], seconds: Sequence[str]) -> list[Heading]:
    """Split the headers of a table, with units from a second line or the file.

    A C or F at the end may be a name ("Sensor C"); if several columns end with it, it is a unit.

    Examples
    --------
    >>> headings(["Temp. Lager vorn [°C]"], [""])
    [Heading(text='Temp. Lager vorn [°C]', name='Temp. Lager vorn', unit='°C', said='°C')]
    >>> texts = ["T1", "disp_z_um", "Spindle speed rpm", "T2, K", "t/s", "v/mm/min", "mm/min"]
    >>> [entry.unit for entry in headings([*texts, "n_1/s"], ["(degC)", *7 * [""]])]
    ['degC', 'um', 'rpm', 'K', 's', 'mm/min', '', '1/s']
    >>> [entry.unit for entry in headings(["front_C", "rear_C", "z_um"], ["", "", ""])]
    ['C', 'C', 'um']
    >>> [entry.unit for entry in headings(["Sensor B", "Sensor C"], ["", ""])]
    ['', '']
    """
    parts = [_heading(text, second) for text, second in zip(texts, seconds, strict=True)]
    ends = [
        re.fullmatch(r"(.+)[\s_]([CF])", entry.text) if not entry.unit else None for entry in parts
    ]
    shared = Counter(end[2] for end in ends if end)
    return [
        replace(entry, name=end[1], unit=end[2], said=end[2])
        if end and shared[end[2]] > 1
        else entry
        for entry, end in zip(parts, ends, strict=True)
    ]


def _is_surely_a_unit(text: str, after_a_mark: bool) -> bool:
    if conversion_of(text) is None:
        return False
    plain = text.casefold()
    if plain in ("c", "f", "m", "d"):
        return after_a_mark
    if plain in ("1", "-", "in", "my", "grad", "hp", "ipm", "code", "flag", "status"):
        return False
    return after_a_mark or len(plain) > 1 or plain in ("k", "s", "h", "w")


def is_unit_line(cells: list[str]) -> bool:
    """Return whether a header line holds units: most cells do, and none is a long text."""
    filled = [cell.strip() for cell in cells if cell.strip()]
    known = [cell for cell in filled if conversion_of(cell.strip("[](){}<> ")) is not None]
    if not filled or any(len(cell) > 14 for cell in filled):
        return False
    return len(known) >= 0.5 * len(filled) or all(cell.startswith(("[", "(")) for cell in filled)


def signal_name(text: str) -> str:
    """Return a name that is allowed in a run file.

    >>> signal_name("Temp. Lager hinten (außen)")
    'Temp_Lager_hinten_aussen'
    """
    plain = text.translate(_TRANSLITERATED)
    plain = unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^0-9A-Za-z]+", "_", plain).strip("_")
    return plain or "column"
