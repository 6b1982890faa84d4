"""Formats the results of a fit as lines: weights, time constants, orders, tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fmu_compensator.fit.error_models import fitted_models
from scenarios.pages.charts import SHOWN


def details_text(kind: str, targets: Sequence[str], details: Mapping[str, Any]) -> list[str]:
    """Return the error model's report on its fit as lines.

    Parameters
    ----------
    kind : str
        Kind of error model.
    targets : sequence of str
        What it predicts.
    details : mapping
        Its report.
    """
    lines = []
    if not fitted_models()[kind].by_temperature:
        lines.append(f"of them {kind}, the mean function, uses none; the Gaussian on it does")
    return [*lines, *_all_of(targets, details)]


def _all_of(targets: Sequence[str], details: Mapping[str, Any]) -> Iterator[str]:
    if "condition_number" in details:
        each = ", ".join(f"{name} {v:.1f}" for name, v in details["variance_inflation"].items())
        yield f"condition number {details['condition_number']:.1f}, variance inflation: {each}"
    yield from _weights(details)
    yield from _time_constants(targets, details)
    if "factors" in details:
        each = ", ".join(f"{name} {factor:.2f}" for name, factor in details["factors"].items())
        yield f"factors on what the finite elements start from: {each}"
    if "weights_and_thresholds" in details:
        shape = "-".join(map(str, details["nodes"]))
        yield f"network {shape}, {details['iterations']} iterations"
    yield from _series(details)
    for part, its in details.get("parts", {}).items():
        yield from (f"{part}: {line}" for line in _all_of(targets, its))


def _weights(details: Mapping[str, Any]) -> Iterator[str]:
    for condition, rows in details.get("weights", {}).items():
        for target, row in rows.items():
            each = ", ".join(f"{name} {weight:.2f}" for name, weight in row.items())
            yield f"weights, {condition}, {target}: {each}"


def _time_constants(targets: Sequence[str], details: Mapping[str, Any]) -> Iterator[str]:
    for key, when in (("tau_s", "turning"), ("tau_stopped_s", "standing")):
        if key in details:
            pairs = zip(targets, details[key], strict=True)
            each = ", ".join(f"{target} {tau:.0f}" for target, tau in pairs)
            yield f"time constant {when} [s]: {each}"


def _series(details: Mapping[str, Any]) -> Iterator[str]:
    series = details.get("targets")
    for target, arma in (series if isinstance(series, Mapping) else {}).items():
        if "adf_p" in arma:
            p, d, q = arma["order"]
            tests = ", ".join(f"{value:.3g}" for value in arma["adf_p"])
            yield f"{target}: ARMA({p}, {q}) of difference {d}, AIC {arma['aic']:.1f}"
            yield f"  ADF p of each difference: {tests}"
            for key in ("acf", "pacf"):
                values = ", ".join(f"{value:.2f}" for value in arma[key][1 : 1 + SHOWN])
                band = f"white noise stays within {arma['white_noise_95']:.2f}"
                yield f"  {key.upper()} from lag 1: {values} ({band})"
