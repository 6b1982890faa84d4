"""Rolling bearings by designation: bore, outside diameter and width from their dimension series."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import pi
from typing import Literal

BORES = {0: 10.0, 1: 12.0, 2: 15.0, 3: 17.0}
"""Bore [mm] of the first bore codes; from 04 on it is five times the code (ISO 15)."""

# Bore code: outside diameter and width [mm], ISO 15 dimension series.
_SERIES_10 = {
    0: (26, 8), 1: (28, 8), 2: (32, 9), 3: (35, 10), 4: (42, 12), 5: (47, 12), 6: (55, 13),
    7: (62, 14), 8: (68, 15), 9: (75, 16), 10: (80, 16), 11: (90, 18), 12: (95, 18), 13: (100, 18),
    14: (110, 20), 15: (115, 20), 16: (125, 22), 17: (130, 22), 18: (140, 24), 19: (145, 24),
    20: (150, 24), 21: (160, 26), 22: (170, 28), 24: (180, 28), 26: (200, 33), 28: (210, 33),
    30: (225, 35), 32: (240, 38),
}  # fmt: skip
_SERIES_19 = {
    0: (22, 6), 1: (24, 6), 2: (28, 7), 3: (30, 7), 4: (37, 9), 5: (42, 9), 6: (47, 9),
    7: (55, 10), 8: (62, 12), 9: (68, 12), 10: (72, 12), 11: (80, 13), 12: (85, 13), 13: (90, 13),
    14: (100, 16), 15: (105, 16), 16: (110, 16), 17: (120, 18), 18: (125, 18), 19: (130, 18),
    20: (140, 20), 21: (145, 20), 22: (150, 20), 24: (165, 22), 26: (180, 24), 28: (190, 24),
    30: (210, 28), 32: (220, 28),
}  # fmt: skip
_SERIES_02 = {
    0: (30, 9), 1: (32, 10), 2: (35, 11), 3: (40, 12), 4: (47, 14), 5: (52, 15), 6: (62, 16),
    7: (72, 17), 8: (80, 18), 9: (85, 19), 10: (90, 20), 11: (100, 21), 12: (110, 22),
    13: (120, 23), 14: (125, 24), 15: (130, 25), 16: (140, 26), 17: (150, 28), 18: (160, 30),
    19: (170, 32), 20: (180, 34),
}  # fmt: skip
_WIDTHS_30 = {
    5: 16, 6: 19, 7: 20, 8: 21, 9: 23, 10: 23, 11: 26, 12: 26, 13: 26, 14: 30, 15: 30, 16: 34,
    17: 34, 18: 37, 19: 37, 20: 37, 21: 41, 22: 45, 24: 46, 26: 52, 28: 53, 30: 56, 32: 60,
}  # fmt: skip
_SERIES_30 = {code: (_SERIES_10[code][0], width) for code, width in _WIDTHS_30.items()}

SERIES: dict[str, tuple[Literal["ball", "roller"], dict[int, tuple[int, int]]]] = {
    "NN30": ("roller", _SERIES_30),
    "N10": ("roller", _SERIES_10),
    "719": ("ball", _SERIES_19),
    "70": ("ball", _SERIES_10),
    "72": ("ball", _SERIES_02),
    "60": ("ball", _SERIES_10),
    "62": ("ball", _SERIES_02),
}
"""Kind of rolling elements and sizes by bore code, for each series."""

_FORM = re.compile(r"(?<!\d)(NN30|N10|719|70|72|60|62)(\d\d)(?!\d)")

FILL = {"ball": 0.68, "roller": 0.77}
"""Share of metal in the volume between bore and outside diameter: a 7014 weighs 0.6 kg."""


@dataclass(frozen=True)
class Bearing:
    """One rolling bearing.

    Attributes
    ----------
    designation : str
    kind : {"ball", "roller"}
    bore, outside, width : float
        [mm].
    """

    designation: str
    kind: Literal["ball", "roller"]
    bore: float
    outside: float
    width: float

    @property
    def mean_diameter(self) -> float:
        """Half the sum of bore and outside diameter [mm]."""
        return (self.bore + self.outside) / 2.0

    @property
    def mass(self) -> float:
        """Its mass [kg], from the volume between bore and outside."""
        ring = pi / 4.0 * (self.outside**2 - self.bore**2) * self.width * 1e-9
        return FILL[self.kind] * 7850.0 * ring


def by_designation(designation: str) -> Bearing | None:
    """Return the bearing with a designation, or None if the series or size is not known.

    Makers' letters before and after are ignored: ``7014``, ``B7014-C-T-P4S`` and ``7014 CD/P4A``
    have the same size.

    Parameters
    ----------
    designation : str
        As on the bearing or in a catalogue, in upper or lower case.

    Returns
    -------
    Bearing or None
        With bore, outer diameter and width [mm].
    """
    match = _FORM.search(designation.upper().replace(" ", ""))
    if not match:
        return None
    kind, sizes = SERIES[match[1]]
    code = int(match[2])
    if code not in sizes:
        return None
    outside, width = sizes[code]
    bore = BORES.get(code, 5.0 * code)
    return Bearing(designation, kind, bore, float(outside), float(width))


def known_designations() -> str:
    """Return the series with their sizes, for a refusal."""
    return ", ".join(f"{name}{min(s):02d} to {name}{max(s):02d}" for name, (_, s) in SERIES.items())
