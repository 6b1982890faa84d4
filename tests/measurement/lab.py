"""The workbooks of a laboratory: one of temperatures, one of displacements, a sheet a day."""

from pathlib import Path

import numpy as np

from tests.measurement.importing.made import workbook

SHEETS = 18
ROWS = 200
EVERY_S = 60.0
TAUS_S = np.array([900.0, 2400.0, 5400.0, 1800.0])
RISES_K = np.array([14.0, 9.0, 5.0, 1.0])
"""Of front bearing, rear bearing, housing and hall at 10,000 r/min."""
DIA_UM_PER_K = np.array([0.8, -0.3, 2.1, 0.0])
GROWTH_UM_PER_K = np.array([1.9, 1.1, 0.5, 0.0])


def day(number: int) -> tuple[np.ndarray, np.ndarray]:
    """Return temperatures [degC] and the two displacements [um] of a day, a row a minute."""
    draw = np.random.default_rng(number)
    speed = np.repeat(draw.uniform(0.0, 1.0, 4), ROWS // 4)
    rise, rises = np.zeros(4), []
    for share in speed:
        rise = rise + (RISES_K * share - rise) * EVERY_S / TAUS_S
        rises.append(rise)
    table = np.array(rises)
    temperatures = 19.0 + draw.uniform(0.0, 4.0) + table + draw.normal(0.0, 0.03, table.shape)
    drift = np.column_stack([table @ DIA_UM_PER_K, table @ GROWTH_UM_PER_K])
    return temperatures.round(2), (drift + draw.normal(0.0, 0.3, drift.shape)).round(2)


def clock_s() -> np.ndarray:
    """Return the time of a day's rows [s]."""
    return EVERY_S * np.arange(ROWS)


def workbooks(folder: Path) -> tuple[Path, Path]:
    """Write both workbooks as a laboratory has them: no time, no units, Sheet1 to Sheet18."""
    days = {f"Sheet{number}": day(number) for number in range(1, SHEETS + 1)}
    names = ["T front", "T rear", "T housing", "T hall"]
    temperatures = {title: [names, *found[0].tolist()] for title, found in days.items()}
    lengths = {title: [["Dia_Disp", "Growth"], *found[1].tolist()] for title, found in days.items()}
    return (
        workbook(folder / "Temperatures.xlsx", temperatures),
        workbook(folder / "Displacements.xlsx", lengths),
    )
