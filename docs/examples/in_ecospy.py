"""Both FMUs coupled in ecospy: python in_ecospy.py PLANT COMPENSATOR SIGNALS.csv OUT.csv.

SIGNALS.csv has time [s], speed, ambient, coolant_inlet, tool_length; a row per communication point.
"""

import ctypes
import sys
from importlib import metadata

import fmpy
import pandas as pd

# ecospy's library needs the one in the package tbb, but does not look for it there.
(library,) = (file for file in metadata.files("tbb") if file.name == "libtbb.so.12")
ctypes.CDLL(str(library.locate().resolve()), mode=ctypes.RTLD_GLOBAL)

from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402

WANTED = ["error_X", "error_Y", "error_Z", "drift_Z", "T1"]
OFFSETS = ["dX", "dY", "dZ"]

signals = pd.read_csv(sys.argv[3])
step = float(signals["time"][1] - signals["time"][0])
paths = dict(zip(("plant", "compensator"), sys.argv[1:3], strict=True))
variables = {
    part: {entry.name: entry for entry in fmpy.read_model_description(path).modelVariables}
    for part, path in paths.items()
}
driven = [
    (part, name)
    for part in paths
    for name, entry in variables[part].items()
    if name in signals and entry.causality == "input"
]
rows = []
with EcosSimulationStructure() as structure:
    for part, path in paths.items():
        structure.add_model(part, path)
    for start, end in (("plant", "compensator"), ("compensator", "plant")):
        for name, entry in variables[end].items():
            if entry.causality == "input" and name in variables[start] and name not in signals:
                structure.make_real_connection(f"{start}::{name}", f"{end}::{name}")
    # The seed of the sensors' noise in the scenario step_speed.
    first = {f"{part}::{name}": float(signals[name][0]) for part, name in driven}
    structure.add_parameter_set("start", {"plant::noise_seed": 101, **first})
    with EcosSimulation(step, structure=structure) as simulation:
        simulation.init(0.0, "start")
        for row in signals.to_dict("records")[:-1]:
            for part, name in driven:
                simulation.set_real(f"{part}::{name}", row[name])
            found = {"time": simulation.step()}
            found |= {name: simulation.get_real(f"plant::{name}") for name in WANTED}
            found |= {name: simulation.get_real(f"compensator::{name}") for name in OFFSETS}
            rows.append(found)
        simulation.terminate()
pd.DataFrame(rows).to_csv(sys.argv[4], index=False)
