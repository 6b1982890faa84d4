# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # How warm is the shaft? A Kalman filter around the plant FMU
#
# No thermometer sits on a turning shaft. The plant's FMU in C is for [model exchange](../fmu.md#model-exchange)
# and gives exact directional derivatives, so a filter of a few lines can correct its states with the
# available thermometers. The machine here is a plant whose bearings have 40 % more friction than the model
# assumes, and it has been running for two hours when the filter starts: the model alone gets both wrong.

# %%
import tempfile
from pathlib import Path

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.fmi2 import FMU2Model
from scipy.linalg import expm

import spindle_drift as sd

folder = Path(tempfile.mkdtemp())
path = sd.build_fmu("jig_borer_lumps", folder, name="plant", native=True)
description = fmpy.read_model_description(str(path))
variables = {v.name: v for v in description.modelVariables}
states = [v.derivative.name for v in description.modelVariables if v.derivative is not None]
thermometers = [f"T{i}" for i in range(1, 12) if i not in (5, 9)]  # T5 and T9 drive the model
len(states), "states", thermometers

# %% [markdown]
# ## A day of the machine
#
# The same FMU in co-simulation with other friction. Its thermometers have 0.05 K of noise.

# %%
STEP = 60.0
scenario = sd.simulate("jig_borer_lumps", "step_speed", every_s=STEP)
time, speed = scenario.time_s, scenario.frame["speed_rpm"].to_numpy()
driven = [speed, scenario.frame["T5_degC"], scenario.frame["T9_degC"]]
columns = dict(zip(["speed", "ambient", "coolant_inlet"], driven, strict=True))
for variable in description.modelVariables:
    if variable.causality == "input":
        columns.setdefault(variable.name, np.full(len(time), float(variable.start)))
inputs = np.rec.fromarrays(
    [time, *(np.asarray(column, float) for column in columns.values())],
    names=["time", *columns],
)
friction = [f"sources.{bearing}.f0" for bearing in ("front_bearing", "rear_bearing")]
worn = {name: 1.4 * float(variables[name].start) for name in friction}
truth = fmpy.simulate_fmu(
    str(path),
    fmi_type="CoSimulation",
    stop_time=float(time[-1]),
    output_interval=STEP,
    input=inputs,
    start_values=worn,
    output=[*states, *thermometers],
)
noise = np.random.default_rng(1)
read = np.array([truth[name] for name in thermometers]).T
read += 0.05 * noise.standard_normal(read.shape)

# %% [markdown]
# ## The filter
#
# One step moves the states by the exponential of the Jacobian, assembled column by column from directional
# derivatives, and so is the matrix from states to thermometers. Unknown friction acts much like another
# speed, so one more state is a factor on the speed; its column is the derivative by that input.


# %%
class Plant:
    """The FMU in model exchange: rates, readings and their derivatives."""

    def __init__(self) -> None:
        self.fmu = FMU2Model(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(path)),
            modelIdentifier=description.modelExchange.modelIdentifier,
            instanceName="filter",
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.fmu.enterContinuousTimeMode()
        self.x = self.refs(states)
        self.rate = self.refs([f"der({name})" for name in states])
        self.shown = self.refs(thermometers)

    def refs(self, names):
        return [variables[name].valueReference for name in names]

    def put(self, row, z):
        """Set inputs and states; the last of z is by how much the speed seems larger."""
        given = [row[0] * (1.0 + z[-1]), *row[1:]]
        self.fmu.setReal(self.refs(["speed", "ambient", "coolant_inlet"]), [*map(float, given)])
        self.fmu.setContinuousStates((fmpy.fmi2.fmi2Real * len(states))(*z[:-1]), len(states))

    def derivatives(self, of, row):
        by = [(known, 1.0) for known in self.x] + [(variables["speed"].valueReference, row[0])]
        columns = [self.fmu.getDirectionalDerivative(of, [k], [float(one)]) for k, one in by]
        return np.array(columns).T


START_K, STEP_K, FACTOR, NOISE_K = 3.0, 0.03, 0.01, 0.05


def filtered(measured):
    plant, size = Plant(), len(states) + 1
    z = np.append(np.full(len(states), 21.0), 0.0)
    spread = np.diag([START_K**2] * len(states) + [0.2**2])
    grown = np.diag([STEP_K**2] * len(states) + [FACTOR**2])
    found = []
    for k in range(first, len(time)):
        row = [float(column[k]) for column in driven]
        plant.put(row, z)
        if measured:
            h = plant.derivatives(plant.shown, row)
            gain = spread @ h.T @ np.linalg.inv(h @ spread @ h.T + NOISE_K**2 * np.eye(len(h)))
            z = z + gain @ (read[k] - np.array(plant.fmu.getReal(plant.shown)))
            spread = spread - gain @ h @ spread
            plant.put(row, z)
        found.append(z[:-1])
        # One exponential gives both the step of the states and what their present rate adds.
        both = np.zeros((size + 1, size + 1))
        both[: size - 1, :size] = plant.derivatives(plant.rate, row)
        both[: size - 1, size] = plant.fmu.getReal(plant.rate)
        both = expm(STEP * both)
        z = z + both[:size, size]
        spread = both[:size, :size] @ spread @ both[:size, :size].T + grown
    return np.array(found)


first = int(2 * 3600 / STEP)
model, corrected = filtered(measured=False), filtered(measured=True)

# %% [markdown]
# ## The shaft

# %%
shaft = states.index("nodes.shaft_front.temperature")
figure, ax = plt.subplots(figsize=(9, 3.2))
hours = time[first:] / 3600
ax.plot(time / 3600, truth[states[shaft]], color="#8b929c", label="true")
ax.plot(hours, model[:, shaft], color="#c8553d", label="model alone")
ax.plot(hours, corrected[:, shaft], color="#1d5fa8", label="corrected by the thermometers")
ax.set(xlabel="time [h]", ylabel="front of the shaft [°C]")
ax.grid(True)
legend = ax.legend()

# %%
true = np.array([truth[name] for name in states]).T[first:]
for name, found in (("model alone", model), ("corrected", corrected)):
    off = np.sqrt(((found - true)[30:, shaft] ** 2).mean())
    print(f"{name}: the shaft is off by {off:.2f} K after the first half hour")
