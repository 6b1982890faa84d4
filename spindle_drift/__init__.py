"""Measure, model and compensate the thermal drift of machine-tool spindles.

Notebooks import this package: ``import spindle_drift as sd``. A run is a pandas frame with a name;
every function that takes a run also takes such a frame or the path of a run file. Unusable input
raises `BadInput`, whose text is one line. Files are written only to a path that is given, and files
that this library did not make are replaced only with ``force=True``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from measurement.errors import BadInput
    from measurement.iso230 import Summary
    from measurement.runs import Run
    from spindle_drift.comparisons import Comparison, compare
    from spindle_drift.compensators import Compensator, fit
    from spindle_drift.components import Scenario, build_fmu, run_scenario
    from spindle_drift.gaps import Gap, find_gap
    from spindle_drift.machines import Calibration, Machine, calibrate, simulate
    from spindle_drift.recordings import ImportedLog, import_log, read_run, summary
    from spindle_drift.surveys import Points, points

    __version__: str

__all__ = [
    "BadInput",
    "Calibration",
    "Comparison",
    "Compensator",
    "Gap",
    "ImportedLog",
    "Machine",
    "Points",
    "Run",
    "Scenario",
    "Summary",
    "build_fmu",
    "calibrate",
    "compare",
    "find_gap",
    "fit",
    "import_log",
    "points",
    "read_run",
    "run_scenario",
    "simulate",
    "summary",
]

# Each name is imported on first use (PEP 562), because importing the libraries behind all of them
# takes seconds. Type checkers read the imports above instead.
_HOMES = {
    "measurement.errors": ("BadInput",),
    "measurement.iso230": ("Summary",),
    "measurement.runs": ("Run",),
    "spindle_drift.comparisons": ("Comparison", "compare"),
    "spindle_drift.compensators": ("Compensator", "fit"),
    "spindle_drift.components": ("Scenario", "build_fmu", "run_scenario"),
    "spindle_drift.gaps": ("Gap", "find_gap"),
    "spindle_drift.machines": ("Calibration", "Machine", "calibrate", "simulate"),
    "spindle_drift.recordings": ("ImportedLog", "import_log", "read_run", "summary"),
    "spindle_drift.surveys": ("Points", "points"),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

if not TYPE_CHECKING:  # with it, a type checker would accept any name

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            from scenarios.version import version

            value = version()
        elif name in _HOME:
            value = getattr(import_module(_HOME[name]), name)
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
