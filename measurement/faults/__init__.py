"""Finds faults in measured runs: the one detector of broken sensors that every command uses.

`find_faults` checks runs, one by one and against each other, and returns one `Fault` per problem:
run, column, span, text, and how it is handled. `cleaned` removes unusable readings from the runs;
`looked_over` attaches the faults to the runs. Each check is a file in `checks`. No model is
involved, only the data. "Set on the planted faults" means that a number was chosen on those of
`benchmarks.sensor_faults.run setting`; docs/results.md reports on other runs, except for
standstills counted in steps of a thermometer's resolution.
"""

from measurement.faults.fault import STANDING, Fault
from measurement.faults.find import cleaned, find_faults, looked_over, unusable
from measurement.faults.kinds import GROSS, HANDLING, LEVELS
from measurement.faults.text import by_column, faults_text, group_line

__all__ = [
    "GROSS",
    "HANDLING",
    "LEVELS",
    "STANDING",
    "Fault",
    "by_column",
    "cleaned",
    "faults_text",
    "find_faults",
    "group_line",
    "looked_over",
    "unusable",
]
