"""What a column is called and what its unit is, from a header as people write it."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from measurement.importing.quantities import conversion_of
from measurement.units import split_column

_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[\(\{<](?P<unit>[^\[\]\(\)\{\}<>]*)[\]\)\}>]\s*$")
_SEPARATED = re.compile(r"^(?P<name>.+?)\s*(?:,|;|\bin\b|\s/|/(?=°)|:)\s*(?P<unit>\S{1,10})$")
_QUOTIENT = re.compile(r"^(?P<name>[^\s/]+)/(?P<unit>\S{1,10})$")
_LAST_WORD = re.compile(r"^(?P<name>.+)[\s_](?P<unit>\S{1,8})$")
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
    """A header taken apart.

    Attributes
    ----------
    text : str
        As the file has it; with a unit from a second header line in brackets.
    name : str
        What is measured, as the file calls it.
    unit : str
        The unit as the file writes it; empty if it says none that is known.
    said : str
        What stands where a unit would; it may be no unit that is known.
    """

    text: str
    name: str
    unit: str
    said: str = ""

    @property
    def is_time(self) -> bool:
        """Whether the name is one of time."""
        return bool(_TIME.match(self.name.strip()))


def _heading(text: str, second: str) -> Heading:
    """Take one header apart, whatever the others are."""
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
        found = pattern.match(text)
        if pattern is _QUOTIENT and found and any(map(conversion_of, (text, found["name"]))):
            continue  # "mm/min" is a unit, and "m/s" no name and unit
        # "Temp C" and "Temp K" have a unit; "Spindle 1" and "Bearing s" have none.
        if found and _is_surely_a_unit(found["unit"], pattern is not _LAST_WORD):
            return Heading(text, found["name"], found["unit"], found["unit"])
    word = re.search(r"\b(rpm|krpm)\b", text, re.IGNORECASE)
    return Heading(text, text, word[1] if word else "", word[1] if word else "")


def headings(texts: Sequence[str], seconds: Sequence[str]) -> list[Heading]:
    """Take the headers of a table apart, and the units that a second line or the file gives.

    A C or F at the end may be a name ("Sensor C"); where several columns end so, it is their unit.

    Examples
    --------
    >>> headings(["Temp. Lager vorn [°C]"], [""])
    [Heading(text='Temp. Lager vorn [°C]', name='Temp. Lager vorn', unit='°C', said='°C')]
    >>> texts = ["T1", "disp_z_um", "Spindle speed rpm", "T2, K", "t/s", "v/mm/min", "mm/min"]
    >>> [entry.unit for entry in headings(texts, ["(degC)", *6 * [""]])]
    ['degC', 'um', 'rpm', 'K', 's', 'mm/min', '']
    >>> [entry.unit for entry in headings(["front_C", "rear_C", "z_um"], ["", "", ""])]
    ['C', 'C', 'um']
    >>> [entry.unit for entry in headings(["Sensor B", "Sensor C"], ["", ""])]
    ['', '']
    """
    found = [_heading(text, second) for text, second in zip(texts, seconds, strict=True)]
    ends = [
        re.fullmatch(r"(.+)[\s_]([CF])", entry.text) if not entry.unit else None for entry in found
    ]
    shared = Counter(end[2] for end in ends if end)
    return [
        replace(entry, name=end[1], unit=end[2], said=end[2])
        if end and shared[end[2]] > 1
        else entry
        for entry, end in zip(found, ends, strict=True)
    ]


def _is_surely_a_unit(text: str, after_a_mark: bool) -> bool:
    if conversion_of(text) is None:
        return False
    plain = text.casefold()
    if plain in ("1", "-", "d", "m", "in", "my", "grad", "c", "f", "code", "flag", "status"):
        return after_a_mark and plain in ("c", "f", "m", "d")
    return after_a_mark or len(plain) > 1 or plain in ("k", "s", "h", "w")


def is_unit_line(cells: list[str]) -> bool:
    """Return whether a header line holds units: most of its cells are, and none is a long text."""
    filled = [cell.strip() for cell in cells if cell.strip()]
    known = [cell for cell in filled if conversion_of(cell.strip("[](){}<> ")) is not None]
    if not filled or any(len(cell) > 14 for cell in filled):
        return False
    return len(known) >= 0.5 * len(filled) or all(cell.startswith(("[", "(")) for cell in filled)


def signal_name(text: str) -> str:
    """Return a name that a run file may hold.

    >>> signal_name("Temp. Lager hinten (außen)")
    'Temp_Lager_hinten_aussen'
    """
    plain = text.translate(_TRANSLITERATED)
    plain = unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^0-9A-Za-z]+", "_", plain).strip("_")
    return plain or "column"
