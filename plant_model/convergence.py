"""How much the results change with the number of cells."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measurement.errors import BadInput
from measurement.files import read_toml
from plant_model.drawing.expand import expanded, is_page
from plant_model.drawing.layout import Drawing
from plant_model.drawing.mesh import Mesh
from plant_model.machine_file import machine_from_table, machine_path
from plant_model.machine_forms import MOST_NODES
from plant_model.parameters import FloatArray
from plant_model.simulate import Simulation, simulate
from plant_model.warm_up import warm_up

FINER = (0.5, 1.0, 2.0, 3.0)
"""Numbers of cells to try, as multiples of the page's [1]: set on no data."""


@dataclass(frozen=True)
class Fineness:
    """One row of the table.

    Attributes
    ----------
    longest_mm : float
        Length of the longest cell.
    sectors, nodes : int
    temperature, drift : float
        Largest difference from the finest row over all thermometers and over all displacement
        sensors, as a share of the largest change that any of them shows [1].
    worst_k, worst_um : float
        The same differences, absolute [K, um].
    """

    longest_mm: float
    sectors: int
    nodes: int
    temperature: float
    drift: float
    worst_k: float
    worst_um: float


def convergence(name_or_path: str | Path) -> list[Fineness]:
    """Simulate a page's warm-up with half to three times the cells and compare the results.

    Parameters
    ----------
    name_or_path : str or path
        A page.

    Raises
    ------
    BadInput
        If it is not a page.
    """
    path = machine_path(name_or_path)
    table = read_toml(path)
    if not is_page(table):
        raise BadInput(path, "", "is in lumps: only a page of a drawing has cells to count")
    cells = table.get("cells", {})
    usual, longest = Mesh(Drawing(table, path)).sectors, float(cells.get("longest", 40.0))
    plans = [(finer, usual) for finer in FINER]
    plans += [(FINER[-1], 2 * usual)] if usual > 1 else []
    seen: list[tuple[int, FloatArray, FloatArray]] = []
    done: list[tuple[float, int]] = []
    for finer, sectors in plans:
        fine = expanded(table, path, finer=finer, sectors=sectors)
        if len(fine["nodes"]) > MOST_NODES:
            continue
        machine = machine_from_table(fine, path)
        shown = simulate(machine, warm_up(machine), step_s=60.0)
        done.append((finer, sectors))
        seen.append((len(machine.nodes), *_shown(shown)))
    _, warm, moved = seen[-1]
    spans = [float(np.abs(part).max()) or 1.0 for part in (warm, moved)]
    rows = []
    for (finer, sectors), (nodes, *parts) in zip(done, seen, strict=True):
        worst = [
            float(np.abs(a - b).max(initial=0.0)) for a, b in zip(parts, (warm, moved), strict=True)
        ]
        shares = [error / span for error, span in zip(worst, spans, strict=True)]
        rows.append(Fineness(longest / finer, sectors, nodes, *shares, *worst))
    return rows


def _shown(shown: Simulation) -> tuple[FloatArray, FloatArray]:
    """Return the changes of the thermometers, then of the displacements, (channels, times)."""
    thermometers = {sensor.name for sensor in shown.machine.sensors}
    warm = [r[0] - r[0, 0] for name, r in shown.readings.items() if name in thermometers]
    moved = [r[0] for name, r in shown.readings.items() if name not in thermometers]
    return np.array(warm).reshape(len(warm), -1), np.array(moved)
