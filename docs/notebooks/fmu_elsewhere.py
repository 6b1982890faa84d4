# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # The FMU in another tool
#
# Both parts are FMUs, so any tool that imports FMI 2.0 co-simulation runs them. Here the other tool is
# fmpy; OpenModelica, Simulink and others take the same files: see [in other tools](../embedding.md). The
# FMUs in C99 need no Python at all: [the FMUs without Python](../native.md).

# %%
import tempfile
from pathlib import Path

import spindle_drift as sd

folder = Path(tempfile.mkdtemp())
runs = [
    sd.simulate("jig_borer", name, every_s=60.0, noise_seed=1)
    for name in ("training_down", "training_random", "training_stops")
]
compensator = sd.fit(runs, machine="jig_borer")
fmu = sd.build_fmu(compensator, folder, name="compensator")
fmu.name, f"{fmu.stat().st_size / 1e3:.0f} kB"

# %% [markdown]
# ## What a tool sees

# %%
import fmpy

fmpy.dump(str(fmu))

# %% [markdown]
# ## Run it on a recorded day
#
# fmpy's own `simulate_fmu` feeds the recorded temperatures in and collects offsets, their uncertainty
# and the status.

# %%
import numpy as np

day = sd.simulate("jig_borer", "stop_and_go", every_s=60.0, noise_seed=7)
inputs = {"time": day.time_s, "speed": day.frame["speed_rpm"]}
inputs |= {name: day.frame[f"{name}_degC"] for name in compensator.sensors}
inputs["tool_length"] = np.full(len(day.time_s), 150.0)
signals = np.rec.fromarrays([np.asarray(v, float) for v in inputs.values()], names=list(inputs))
found = fmpy.simulate_fmu(
    str(fmu),
    stop_time=float(day.time_s[-1]),
    step_size=60.0,
    output_interval=60.0,
    input=signals,
    output=["dX", "dY", "dZ", "dZ_uncertainty", "status"],
)
found[-1]

# %%
import matplotlib.pyplot as plt

figure, ax = plt.subplots(figsize=(9, 3))
drift = compensator.judge(day)["drift_Z_um"]
ax.plot(day.time_s / 3600, drift, color="#8b929c", label="drift in Z")
ax.plot(
    found["time"] / 3600, -found["dZ"], color="#1d5fa8", label="what the FMU sends, turned round"
)
low, high = -found["dZ"] - found["dZ_uncertainty"], -found["dZ"] + found["dZ_uncertainty"]
ax.fill_between(found["time"] / 3600, low, high, color="#1d5fa8", alpha=0.2, label="90 % interval")
ax.set(xlabel="time [h]", ylabel="[µm]")
ax.grid(True)
legend = ax.legend()

# %% [markdown]
# ## In the loop
#
# A scenario couples plant and compensator and writes a report; here in one call.

# %%
scenario = sd.run_scenario("stop_and_go", out=folder / "stop_and_go")
scenario.table

# %%
figure = scenario.plot()
