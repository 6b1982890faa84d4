"""What is wrong with measured runs: the one detector of broken sensors that every command asks.

`find_faults` looks at runs, alone and against each other, and returns one `Fault` for each thing
that is wrong: run, column, span, what, and what is done about it. `cleaned` takes out of the runs
what is not to be used; `looked_over` lets runs carry their faults along. Each check is a file of
`checks`. No model takes part: the data alone decide. A number of the checks is "set on the planted
faults" where those of `benchmarks.sensor_faults.run setting` decided; docs/results.md reports on
other runs, but for standstills counted in steps of a thermometer's resolution.
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
