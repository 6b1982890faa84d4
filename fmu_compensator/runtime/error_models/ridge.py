"""Ridge regression on temperatures and their lags."""

from __future__ import annotations

from fmu_compensator.runtime.error_models.thermal_states import ThermalStates


class Ridge(ThermalStates):
    """Runs as thermal states do, its weights of levels and speed being zero."""
