"""Both FMUs nested into one: python in_one_fmu.py PLANT COMPENSATOR SIGNALS.csv OUT.csv.

SIGNALS.csv has time [s], speed, ambient, coolant_inlet, tool_length; a row per communication point.
fmu-manipulation-toolbox makes machine.fmu next to OUT.csv; fmpy runs it.
"""

import json
import subprocess
import sys
import sysconfig
from pathlib import Path

import fmpy
import pandas as pd

WANTED = ["error_X", "error_Y", "error_Z", "drift_Z", "elongation"]

plant, compensator = (str(Path(path).resolve()) for path in sys.argv[1:3])
folder = Path(sys.argv[4]).resolve().parent
signals = pd.read_csv(sys.argv[3])
step = float(signals["time"][1] - signals["time"][0])
assembly = {
    "name": "machine.fmu",
    "fmu": [plant, compensator],
    "step_size": step,
    # Outputs and inputs with equal names are connected, the others exposed. Only an input that both
    # FMUs take has to be listed.
    "input": [
        [name, fmu, name] for name in ("speed", "tool_length") for fmu in (plant, compensator)
    ],
    # The seed of the sensors' noise in the scenario step_speed.
    "start": [[plant, "noise_seed", 101]],
}
(folder / "machine.json").write_text(json.dumps(assembly))
program = Path(sysconfig.get_path("scripts")) / "fmucontainer"
subprocess.run([program, "-container", "machine.json"], cwd=folder, check=True)

result = fmpy.simulate_fmu(
    folder / "machine.fmu",
    stop_time=float(signals["time"].iloc[-1]),
    output_interval=step,
    input=signals.to_records(index=False),
    start_values=signals.iloc[0].drop("time").to_dict(),
    output=WANTED,
)
pd.DataFrame(result).to_csv(sys.argv[4], index=False)
