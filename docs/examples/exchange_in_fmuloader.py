"""The plant in model exchange, by fmuloader: python exchange_in_fmuloader.py PLANT.fmu OUT.csv.

PLANT.fmu is the C form, FMI 2.0 or 3.0. Speed is 6000 for an hour; SciPy's Radau method integrates.
"""

import sys

import fmpy
import numpy as np
import pandas as pd
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from fmuloader.fmi3 import Fmi3Slave
from scipy.integrate import solve_ivp

WANTED = ["drift_X", "drift_Y", "drift_Z", "T1"]
INPUTS = {"speed": 6000.0, "ambient": 24.0}
STEP_S, STOP_S = 60.0, 3600.0

# fmuloader leaves the description to another library.
description = fmpy.read_model_description(sys.argv[1])
refs = {variable.name: variable.valueReference for variable in description.modelVariables}
identifier, count = description.modelExchange.modelIdentifier, description.numberOfContinuousStates
if description.fmiVersion == "2.0":
    fmu = Fmi2Slave(sys.argv[1], model_identifier=identifier)
    fmu.instantiate("plant", Fmi2Type.MODEL_EXCHANGE, guid=description.guid)
    fmu.setup_experiment(start_time=0.0)
    put, take, rates = fmu.set_real, fmu.get_real, fmu.get_derivatives
else:
    fmu = Fmi3Slave(sys.argv[1], model_identifier=identifier)
    fmu.instantiate_model_exchange("plant", instantiation_token=description.guid)
    put, take, rates = fmu.set_float64, fmu.get_float64, fmu.get_continuous_state_derivatives
fmu.enter_initialization_mode()
put([refs[name] for name in INPUTS], list(INPUTS.values()))
fmu.exit_initialization_mode()
(fmu.new_discrete_states if description.fmiVersion == "2.0" else fmu.update_discrete_states)()
fmu.enter_continuous_time_mode()


def at(time, states):
    """Set the FMU's time and states."""
    fmu.set_time(time)
    fmu.set_continuous_states(states.tolist())


def slope(time, states):
    """Return the rates of the states."""
    at(time, states)
    return rates(count)


start = np.array(fmu.get_continuous_states(count))
times = np.arange(0.0, STOP_S + STEP_S / 2, STEP_S)
found = solve_ivp(slope, (0.0, STOP_S), start, "Radau", times, rtol=1e-8, atol=1e-8)
rows = []
for time, states in zip(found.t, found.y.T, strict=True):
    at(time, states)
    rows.append([time, *take([refs[name] for name in WANTED])])
fmu.terminate()
fmu.free_instance()
pd.DataFrame(rows, columns=["time", *WANTED]).to_csv(sys.argv[2], index=False)
