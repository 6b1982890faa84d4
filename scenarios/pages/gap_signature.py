"""Draws the signatures of what was added over what the model leaves without it."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from gap_finder.find import GapResult
from gap_finder.linearise import modelled, simulate_at
from gap_finder.long_log import own_hours
from gap_finder.observations import Observations
from gap_finder.regimes import residuals
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from scenarios.pages.charts import BEFORE, LINES, SHOWN, Chart, Line, Panel


def signature_charts(result: GapResult) -> list[Chart]:
    """Return a chart for each addition, of the run and the channels that it moves beyond noise.

    The signature is the calibrated machine with everything that was added, minus the same without
    this addition.
    """
    charts = []
    for addition in result.search.best.additions:
        with suppress(KeyError):  # another one is at a part that this one brought
            charts.append(_chart(result, addition.key, result.without(addition)))
    return charts


def _chart(result: GapResult, key: str, without: Machine) -> Chart:
    after = result.after.machine
    runs = [own_hours(observations) for observations in result.observed]
    signatures = [_signature(after, without, observations) for observations in runs]
    sizes = np.array([np.max(np.abs(_moving(values)), axis=0) for values in signatures])
    sizes /= runs[0].noise
    run = int(np.argmax(sizes.max(axis=1)))
    observed, signature = runs[run], signatures[run]
    left = signature - residuals(after, observed).values
    most, *more = np.argsort(-sizes[run], kind="stable")[:SHOWN].tolist()
    panels = []
    for i in sorted([most, *(at for at in more if sizes[run, at] > 1.0)]):
        name = observed.channels[i]
        curves = [left[:, i], signature[:, i]]
        if observed.lengths[i]:
            # Each run has its own zero of displacement, so only changes can be compared.
            measured = np.isfinite(left[:, i])
            curves = [values - np.mean(values[measured]) for values in curves]
        lines = (
            Line("measured minus model without it", observed.time_s, curves[0], BEFORE),
            Line("what it does", observed.time_s, curves[1], LINES[1], rank=2),
        )
        panels.append(Panel(f"{name} [{'µm' if observed.lengths[i] else 'K'}]", lines))
    name = key.replace(":", "_")
    return Chart(
        f"signature_{name}_{observed.run.name}",
        f"Signature of {key} over what is left without it: {observed.run.name}",
        "The run in which it does most, and the channels that it moves by more than noise. The "
        "model without it has everything else that was added, and the same numbers.",
        tuple(panels),
    )


def _moving(values: FloatArray) -> FloatArray:
    """Return a signature minus its mean, because calibration absorbs a constant first."""
    return np.asarray(values - np.mean(values, axis=0))


def _signature(machine: Machine, without: Machine, observed: Observations) -> FloatArray:
    """Return what an addition changes in every channel, shape (K, C)."""
    with_it, base = (
        modelled(simulate_at(which, observed), observed)[0] for which in (machine, without)
    )
    return np.asarray(with_it - base)
