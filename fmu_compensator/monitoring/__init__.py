"""Whether a compensator still fits its machine: what a log says of its sensors and its promises."""

from fmu_compensator.monitoring.monitor import Report, monitor

__all__ = ["Report", "monitor"]
