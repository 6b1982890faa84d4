"""Coolants by name: water, water with glycol, oil."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from plant_model.drawing.lubricant import GRADES, viscosity

WARM = 22.0
"""Temperature of the values [degC], given by the table below."""

GLYCOL = {
    0: (997.9, 4182.2, 0.6016, 0.9543),
    10: (1010.1, 4047.2, 0.5556, 1.2095),
    20: (1023.5, 3899.8, 0.5099, 1.5721),
    30: (1037.2, 3724.1, 0.4668, 2.0425),
    40: (1050.9, 3527.2, 0.4268, 2.6503),
    50: (1063.9, 3322.5, 0.3904, 3.4632),
    60: (1076.0, 3110.5, 0.3576, 4.5327),
}
"""Ethylene glycol in water by mass [%]: density [kg/m3], specific heat [J/(kg K)], conductivity
[W/(m K)], viscosity [mPa s]. From CoolProp 8.0 (``Water``, ``INCOMP::MEG``), which takes seconds to
load; a test recomputes the table."""

ALLOWED = "water, glycol N % (N up to 60), oil N (N an ISO VG grade)"


@dataclass(frozen=True)
class Coolant:
    """A liquid.

    Attributes
    ----------
    density, specific_heat, conductivity, viscosity : float
        [kg/m3], [J/(kg K)], [W/(m K)], [Pa s].
    source : str
        Source of the values.
    """

    density: float
    specific_heat: float
    conductivity: float
    viscosity: float
    source: str

    @property
    def heat_per_litre(self) -> float:
        """Heat capacity [J/(l K)]."""
        return self.density * self.specific_heat / 1000.0


def coolant(name: str) -> Coolant | None:
    """Return a coolant at 22 degC, or None for an unknown name.

    ``water``, ``glycol 30 %`` (ethylene glycol in water, by mass, up to 60 %) and ``oil 10`` (a
    mineral oil of that ISO VG grade).

    Parameters
    ----------
    name : str
        Exactly one of these forms.
    """
    glycol = re.fullmatch(r"glycol (\d{1,2}) ?%", name)
    oil = re.fullmatch(r"oil (\d{1,3})", name)
    if oil and int(oil[1]) in GRADES:
        thick = 860e-6 * viscosity(int(oil[1]), WARM)
        return Coolant(860.0, 1900.0, 0.132, thick, f"{name}, usual mineral oil, ASTM D341")
    if name == "water" or (glycol and int(glycol[1]) <= 60):
        share = int(glycol[1]) if glycol else 0
        rows = np.array(list(GLYCOL.values()))
        rows[:, 3] = np.log(rows[:, 3])
        density, heat, conductivity, log_mpas = (
            float(np.interp(share, list(GLYCOL), column)) for column in rows.T
        )
        thick = float(np.exp(log_mpas)) * 1e-3
        return Coolant(density, heat, conductivity, thick, f"{name} by CoolProp")
    return None
