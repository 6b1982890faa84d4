"""Bayesian ridge regression on rises of temperature and their lags."""

from __future__ import annotations

from fmu_compensator.runtime.error_models.thermal_states import ThermalStates


class Bayes(ThermalStates):
    """Predicts as thermal states do, without levels and speed; its numbers are fitted otherwise."""
