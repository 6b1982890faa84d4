"""An .ssp of spindle-drift in libcosimpy: python ssp_in_libcosimpy.py FILE.ssp STOP_S OUT.csv."""

import sys

import pandas as pd
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

WANTED = {
    "plant": ["error_X", "error_Y", "error_Z", "drift_Z", "T1"],
    "compensator": ["dX", "dY", "dZ"],
}

log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1])
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
refs = {}
for slave in WANTED:
    index = execution.slave_index_from_instance_name(slave)
    known = {entry.name.decode(): entry.reference for entry in execution.slave_variables(index)}
    refs[index] = {name: known[name] for name in WANTED[slave]}

rows = []
while execution.status().current_time < float(sys.argv[2]) * 1e9:
    if not execution.step():
        sys.exit("a step failed")
    found = {"time": execution.status().current_time * 1e-9}
    for index, names in refs.items():
        values = observer.last_real_values(index, list(names.values()))
        found |= dict(zip(names, values, strict=True))
    rows.append(found)
pd.DataFrame(rows).to_csv(sys.argv[3], index=False)
