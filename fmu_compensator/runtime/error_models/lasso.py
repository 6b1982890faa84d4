"""LASSO regression on temperatures and their lags."""

from __future__ import annotations

from fmu_compensator.runtime.error_models.thermal_states import ThermalStates


class Lasso(ThermalStates):
    """Runs as thermal states do, most of its weights being zero."""
