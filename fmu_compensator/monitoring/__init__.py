"""Checks from a log whether a compensator still fits its machine: sensors and remaining errors."""

from fmu_compensator.monitoring.monitor import Report, monitor

__all__ = ["Report", "monitor"]
