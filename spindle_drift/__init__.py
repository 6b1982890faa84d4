"""Measure, model and compensate the thermal drift of machine-tool spindles.

What a notebook imports: ``import spindle_drift as sd``. Runs are pandas frames with a name; every
function that takes a run also takes a frame like one or the path of a run file. Input that cannot
be used raises `BadInput`, whose text is one line. Files are written only where a path is given, and
no file is replaced that this library did not make, unless ``force=True``.
"""

from __future__ import annotations

from measurement.errors import BadInput
from measurement.iso230 import Summary
from measurement.runs import Run
from scenarios.version import version
from spindle_drift.comparisons import Comparison, compare
from spindle_drift.compensators import Compensator, fit
from spindle_drift.components import Scenario, build_fmu, run_scenario
from spindle_drift.gaps import Gap, find_gap
from spindle_drift.machines import Calibration, Machine, calibrate, simulate
from spindle_drift.recordings import ImportedLog, import_log, read_run, summary

__version__ = version()

__all__ = [
    "BadInput",
    "Calibration",
    "Comparison",
    "Compensator",
    "Gap",
    "ImportedLog",
    "Machine",
    "Run",
    "Scenario",
    "Summary",
    "build_fmu",
    "calibrate",
    "compare",
    "find_gap",
    "fit",
    "import_log",
    "read_run",
    "run_scenario",
    "simulate",
    "summary",
]
