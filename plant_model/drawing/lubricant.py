"""Viscosity of a lubricant of an ISO VG grade at any temperature."""

from __future__ import annotations

from functools import cache
from math import log10

GRADES = (10, 15, 22, 32, 46, 68, 100, 150, 220, 320)
"""Kinematic viscosity at 40 degC, given by ISO 3448 [mm2/s]."""

USUAL_INDEX = 95.0
"""Viscosity index of a mineral oil [1], given by SKF's diagram of viscosity over temperature for
rolling bearings, which is drawn for this index."""


@cache
def viscosity_at_100(grade: float, index: float = USUAL_INDEX) -> float:
    """Return the kinematic viscosity at 100 degC [mm2/s] from grade and viscosity index.

    Notes
    -----
    Inverts ASTM D2270 from the library ``chemicals``. The standard begins at 2 mm2/s at 100 degC,
    so oils thinner than VG 10 have no index.
    """
    from chemicals.viscosity import viscosity_index
    from scipy.optimize import brentq

    def miss(warm: float) -> float:
        return float(viscosity_index(grade * 1e-6, warm * 1e-6) or 0.0) - index

    return float(brentq(miss, max(2.0, 0.06 * grade), 0.55 * grade))


def viscosity(grade: float, degc: float, index: float = USUAL_INDEX) -> float:
    """Return the kinematic viscosity [mm2/s] at a temperature [degC] by ASTM D341.

    lg lg (nu + 0.7) = A - B lg T, with T in K, through the viscosities at 40 and 100 degC.

    Parameters
    ----------
    grade : float
        ISO VG grade, the viscosity at 40 degC [mm2/s]; 10 to 320.
    degc : float
        Temperature [degC].
    index : float
        Viscosity index (ASTM D2270) [1].
    """
    cold, warm = (log10(log10(nu + 0.7)) for nu in (grade, viscosity_at_100(grade, index)))
    t_cold, t_warm = log10(313.15), log10(373.15)
    slope = (cold - warm) / (t_warm - t_cold)
    return float(10.0 ** (10.0 ** (cold - slope * (log10(degc + 273.15) - t_cold))) - 0.7)
