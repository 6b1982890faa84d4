"""Both FMUs coupled in libcosimpy: python in_libcosimpy.py PLANT COMPENSATOR SIGNALS.csv OUT.csv.

SIGNALS.csv has time [s], speed, ambient, coolant_inlet, tool_length; a row per communication point.
"""

import sys

import pandas as pd
from libcosimpy.CosimEnums import CosimVariableCausality
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

WANTED = ["error_X", "error_Y", "error_Z", "drift_Z", "T1"]
OFFSETS = ["dX", "dY", "dZ"]

log_output_level(CosimLogLevel.WARNING)
signals = pd.read_csv(sys.argv[3])
step = float(signals["time"][1] - signals["time"][0])
execution = CosimExecution.from_step_size(step_size=round(step * 1e9))  # [ns]
plant, compensator = (
    execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name=name))
    for path, name in zip(sys.argv[1:3], ("plant", "compensator"), strict=True)
)
refs = {
    index: {entry.name.decode(): entry for entry in execution.slave_variables(index)}
    for index in (plant, compensator)
}
inputs = {
    index: [
        name
        for name, entry in variables.items()
        if entry.causality == CosimVariableCausality.INPUT.value
    ]
    for index, variables in refs.items()
}
for start, end in ((plant, compensator), (compensator, plant)):
    for name in inputs[end]:
        if name in refs[start] and name not in signals:
            execution.connect_real_variables(
                start, refs[start][name].reference, end, refs[end][name].reference
            )

# The seed of the sensors' noise in the scenario step_speed.
execution.integer_initial_value(plant, refs[plant]["noise_seed"].reference, 101)
driven = {index: [name for name in inputs[index] if name in signals] for index in refs}
for index, names in driven.items():
    for name in names:
        execution.real_initial_value(index, refs[index][name].reference, signals[name][0])
override, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
execution.add_manipulator(override)
execution.add_observer(observer)

rows = []
for row in signals.to_dict("records")[:-1]:
    for index, names in driven.items():
        override.slave_real_values(
            index, [refs[index][name].reference for name in names], [row[name] for name in names]
        )
    if not execution.step():
        sys.exit(f"the step at {row['time']} s failed")
    found = {"time": row["time"] + step}
    for index, names in ((plant, WANTED), (compensator, OFFSETS)):
        values = observer.last_real_values(index, [refs[index][name].reference for name in names])
        found |= dict(zip(names, values, strict=True))
    rows.append(found)
pd.DataFrame(rows).to_csv(sys.argv[4], index=False)
