"""Both FMUs coupled in fmpy: python in_fmpy.py PLANT.fmu COMPENSATOR.fmu SIGNALS.csv OUT.csv.

SIGNALS.csv has time [s], speed, ambient, coolant_inlet, tool_length; a row per communication point.
"""

import sys
import tempfile

import fmpy
import pandas as pd
from fmpy.fmi2 import FMU2Slave

WANTED = ["error_X", "error_Y", "error_Z", "drift_Z", "T1"]
OFFSETS = ["dX", "dY", "dZ"]


def opened(path: str, name: str):
    """Return an instantiated FMU and its variables by name."""
    description = fmpy.read_model_description(path)
    fmu = FMU2Slave(
        guid=description.guid,
        modelIdentifier=description.coSimulation.modelIdentifier,
        unzipDirectory=fmpy.extract(path, f"{folder.name}/{name}"),
        instanceName=name,
    )
    fmu.instantiate()
    return fmu, {variable.name: variable for variable in description.modelVariables}


def give(part, values):
    """Set real inputs."""
    fmu, variables = part
    fmu.setReal([variables[name].valueReference for name in values], list(values.values()))


def take(part, names):
    """Return real variables by name."""
    fmu, variables = part
    return dict(
        zip(names, fmu.getReal([variables[name].valueReference for name in names]), strict=True)
    )


folder = tempfile.TemporaryDirectory()
plant, compensator = opened(sys.argv[1], "plant"), opened(sys.argv[2], "compensator")
signals = pd.read_csv(sys.argv[3])
step = float(signals["time"][1] - signals["time"][0])
readings = [name for name in compensator[1] if name in plant[1] and name.startswith("T")]

# The seed of the sensors' noise in the scenario step_speed.
plant[0].setInteger([plant[1]["noise_seed"].valueReference], [101])
now = signals.iloc[0].drop("time").to_dict()
told = {name: now[name] for name in ("speed", "tool_length")}
for part, first in ((plant, now), (compensator, told)):
    part[0].setupExperiment(startTime=0.0)
    part[0].enterInitializationMode()
    if part is compensator:
        first = first | take(plant, readings)
    give(part, first)
    part[0].exitInitializationMode()

rows = []
for row in signals.to_dict("records"):
    time = row.pop("time")
    offsets = take(compensator, OFFSETS)
    rows.append({"time": time} | take(plant, WANTED) | offsets)
    # Both take the values at this point, then both step: neither sees the other's new values.
    give(compensator, take(plant, readings) | {name: row[name] for name in told})
    give(plant, row | offsets)
    for fmu, _ in (compensator, plant):
        fmu.doStep(time, step)
pd.DataFrame(rows).to_csv(sys.argv[4], index=False)
