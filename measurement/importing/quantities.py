"""Units as people write them, and their conversion to the units of a run file."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace

import numpy as np

from measurement.errors import BadInput
from measurement.resampling import FloatArray
from measurement.units import UNITS


@dataclass(frozen=True)
class Conversion:
    """How numbers in one unit become numbers in a run file's unit.

    Attributes
    ----------
    suffix : str
        The run file's unit; see ``measurement.units``.
    factor, offset : float
        Value in the run file = factor * value + offset.
    """

    suffix: str
    factor: float = 1.0
    offset: float = 0.0

    def __call__(self, values: FloatArray) -> FloatArray:
        """Return values in the run file's unit."""
        # Rounded, so that 294.15 K is 21 degC and no digits are added to the measured ones.
        with np.errstate(over="ignore"):  # what is so large is out of every range
            return np.asarray(np.round(values * self.factor + self.offset, 9))


_SPELLINGS: tuple[tuple[Conversion, str], ...] = (
    (Conversion("s"), "s sec secs second seconds sek sekunden"),
    (Conversion("s", 1e-3), "ms millisecond milliseconds"),
    (Conversion("s", 1e-6), "us µs microsecond microseconds"),
    (Conversion("s", 1e-9), "ns nanosecond nanoseconds"),
    (Conversion("s", 60.0), "min minute minutes minuten mins"),
    (Conversion("s", 3600.0), "h hr hrs hour hours std stunden"),
    (Conversion("s", 86400.0), "d day days tage"),
    (
        Conversion("degC"),
        "degc °c c cel celsius deg_c grdc gradc gradcelsius grad oc c° degreec °celsius "
        "degreecelsius",
    ),
    (Conversion("degC", 1.0, -273.15), "k kelvin degk °k"),
    (Conversion("degC", 5.0 / 9.0, -160.0 / 9.0), "f °f degf fahrenheit degreef °fahrenheit"),
    (Conversion("um"), "um µm µ micron microns micrometer micrometre mikrometer my"),
    (Conversion("um", 1e-3), "nanometer nanometre"),
    (Conversion("mm", 25.4), 'in inch inches "'),
    (Conversion("um", 25.4), "mil mils thou"),
    (Conversion("um", 0.0254), "µin uin microin microinch microinches"),
    (Conversion("mm"), "mm millimeter millimetre"),
    (Conversion("mm", 1e3), "m meter metre"),
    (Conversion("rpm"), "rpm 1/min min-1 min^-1 min^(-1) u/min r/min rev/min upm /min"),
    (Conversion("rpm", 60.0), "hz 1/s rps r/s rev/s u/s"),
    (Conversion("rpm", 1000.0), "krpm 1000rpm 1000/min"),
    (Conversion("rpm", 30.0 / np.pi), "rad/s"),
    (Conversion("mm_min"), "mm/min mm_min mmpm"),
    (Conversion("mm_min", 1000.0), "m/min"),
    (Conversion("mm_min", 60.0), "mm/s"),
    (Conversion("mm_min", 25.4), "in/min inch/min inches/min ipm"),
    (Conversion("Nm"), "newtonmeter n*m n.m n-m nm"),
    (
        Conversion("Nm", 1.3558179483314),
        "ft-lb ft-lbf ft*lb ft*lbf ftlb ftlbf lb-ft lbf-ft lb*ft lbf*ft lbft lbfft",
    ),
    (
        Conversion("Nm", 0.1129848290276),
        "in-lb in-lbf in*lb in*lbf inlb inlbf lb-in lbf-in lb*in lbf*in lbin lbfin",
    ),
    (Conversion("W"), "w watt"),
    (Conversion("W", 1e3), "kw kilowatt"),
    (Conversion("W", 745.69987158), "hp"),
    (Conversion("lpm"), "l/min lpm liter/min slpm"),
    (Conversion("lpm", 1000.0 / 60.0), "m3/h m^3/h cbm/h"),
    (Conversion("lpm", 1.0 / 60.0), "l/h"),
    (Conversion("lpm", 3.785411784), "gpm gal/min usgpm"),
    (Conversion("urad"), "urad µrad"),
    (Conversion("urad", 1e3), "mrad"),
    (Conversion("urad", 1e6), "rad"),
    (Conversion("1"), "1 - bool boolean flag on/off status code -/-"),
)
_EXACT = {"nm": Conversion("um", 1e-3)}
"""Units that differ from another only in case: only these letters are nanometres, not ``NM``."""
_BY_SPELLING = {word: kind for kind, words in _SPELLINGS for word in words.split()}
KNOWN_UNITS = (
    "s, min, h, degC, K, degF, um, mm, rpm, Hz, mm/min, Nm, W, kW, l/min, urad, 1 (a flag)"
)
"""The usual units, for a message."""
_MULTIPLE = re.compile(
    r"(?:1 ?/ ?(?P<over>10+)|(?P<count>0[.,]\d+|1(?:000)+)) ?[*x·]? ?(?P<unit>[^\W\d].*|[°%\"].*)"
)
"""Multiples of a unit, such as 0.1 °C, 1/10 K and 1000 µm; 10K may be a type of thermistor."""
LENGTH = re.compile(r"tool|length|laenge|länge|position|pos(?![a-z])|abstand", re.IGNORECASE)
"""Names of lengths in units such as millimetres; other columns in these are displacements."""


def conversion_of(unit: str, name: str = "") -> Conversion | None:
    """Return the conversion from a unit; None if the unit is unknown.

    Parameters
    ----------
    unit : str
        As written in a header.
    name : str
        What is measured: decides whether such units as millimetres are of a length or a
        displacement.

    Examples
    --------
    >>> conversion_of("°F")(np.array([68.0])).round(3).tolist()
    [20.0]
    >>> conversion_of("mm", "disp_z")(np.array([0.012])).tolist()
    [12.0]
    >>> conversion_of("mm", "tool_length")(np.array([100.0])).tolist()
    [100.0]
    >>> conversion_of("m", "tool_length")(np.array([0.15])).tolist()
    [150.0]
    >>> conversion_of("inch", "tool_length")(np.array([5.0])).tolist()
    [127.0]
    >>> conversion_of("NM").suffix, conversion_of("nm").suffix
    ('Nm', 'um')
    >>> conversion_of("1/10 K")(np.array([2940.0])).round(3).tolist()
    [20.85]
    """
    text = unit.replace("º", "°").replace("˚", "°")  # NFKC would turn them into letters
    text = unicodedata.normalize("NFKC", text).replace("μ", "µ").replace("−", "-")
    text = text.strip().strip("[]").strip()
    text = text[1:-1] if text.startswith("(") else text
    if text in _EXACT:
        return _EXACT[text]
    if text in UNITS:
        conversion: Conversion | None = Conversion(text)
    else:
        plain = text.casefold().replace("μ", "µ").replace(" ", "").replace("·", "*").rstrip(".")
        plain = plain.replace("deg.", "deg").replace("degrees", "degree")
        conversion = _BY_SPELLING.get(plain)
        many = _MULTIPLE.fullmatch(text) if conversion is None else None
        if many and (inner := conversion_of(many["unit"], name)):
            count = float(many["over"] or many["count"].replace(",", "."))
            return replace(
                inner, factor=inner.factor / count if many["over"] else inner.factor * count
            )
    if conversion and conversion.suffix == "mm" and not LENGTH.search(name):
        return Conversion("um", 1000.0 * conversion.factor)
    return conversion


def checked_conversion(unit: str, name: str, source: str, place: str = "") -> Conversion:
    """Return the conversion from a unit that a user gave.

    Parameters
    ----------
    unit : str
        As a person writes it, such as ``mm/min`` or ``°F``.
    name : str
        The header of the column, which decides if a unit has two meanings.
    source, place : str
        Where it was given, for the refusal.

    Raises
    ------
    BadInput
        If the unit is unknown.
    """
    conversion = conversion_of(unit, name)
    if conversion is None:
        raise BadInput(source, place, f"{unit!r} is not a known unit: {KNOWN_UNITS}")
    return conversion
