"""Runs that the gap finder's tests share: short ones of the lumped model itself.

The finder's figures come from an independent simulator in ``benchmarks/gap``; these runs only show
that its parts do what they say.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from gap_finder.candidates import Candidate, candidates
from gap_finder.linearise import simulate_runs
from gap_finder.observations import Observations
from measurement.runs import Run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.simulate import simulate
from tests.plant_model.conftest import jig_borer_lumps

__all__ = ["candidates_of", "inputs_of", "jig_borer_lumps", "only_free", "runs_of"]

SPECTRA = {
    "down": ([0.0, 1.2, 2.2], [12000.0, 7000.0, 0.0]),
    "stairs": ([0.0, 0.8, 1.6, 2.4], [3000.0, 6000.0, 9000.0, 13000.0]),
    "stops": ([0.0, 0.7, 1.1, 1.9, 2.4], [10000.0, 0.0, 14000.0, 0.0, 8000.0]),
    "steady": ([0.0, 0.2], [0.0, 11000.0]),
}


def inputs_of(name: str, every_s: float = 30.0) -> pd.DataFrame:
    """Return three hours of one of the spectra."""
    hours, speeds = SPECTRA[name]
    time = np.arange(0.0, 3.0 * 3600.0 + 1.0, every_s)
    at = np.searchsorted(np.array(hours) * 3600.0, time, side="right") - 1
    return pd.DataFrame(
        {
            "time_s": time,
            "speed_rpm": np.array(speeds)[at],
            "T5_degC": 21.0 + 0.5 * np.sin(time / 2500.0),
            "T9_degC": 21.0 + 1.5 * (1.0 - np.exp(-time / 5000.0)),
        }
    )


def runs_of(machine: Machine, every_s: float = 30.0, seed: int = 1) -> list[Run]:
    """Return one noisy run of each spectrum."""
    return [
        Run(name, simulate(machine, inputs_of(name, every_s), noise_seed=seed + i).run_frame())
        for i, name in enumerate(SPECTRA)
    ]


def only_free(machine: Machine, *names: str) -> Machine:
    """Return the machine with nothing but some parameters free."""
    items = tuple(
        replace(
            item,
            parameters={
                key: replace(p, calibrate=item.parameter_name(key) in names)
                for key, p in item.parameters.items()
            },
        )
        for item in machine.items
    )
    nodes = tuple(
        replace(node, capacity=replace(node.capacity, calibrate=False)) for node in machine.nodes
    )
    effects = {
        key: {name: replace(p, calibrate=False) for name, p in table.items()}
        for key, table in machine.effects.items()
    }
    return replace(machine, items=items, nodes=nodes, effects=effects)


def candidates_of(machine: Machine, observed: Sequence[Observations], name: str) -> list[Candidate]:
    """Return an effect as it is tried on a machine."""
    plain = simulate_runs(machine, observed)
    return list(candidates(machine, observed, plain, catalogue()[name]))
