# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # My machine, from its drawing
#
# A handful of numbers from a drawing and a motor plate become a thermal model that simulates, shows
# itself on a page, and is ready to be calibrated on measured runs. The commands are those of a shell;
# the exclamation mark runs them from a notebook.

# %%
import tempfile
from pathlib import Path

import spindle_drift as sd

folder = Path(tempfile.mkdtemp())

# %% [markdown]
# ## A page of the machine
#
# Front bearing, highest speed, motor power: the rest gets class values. Lines with `CHECK` are not from
# your drawing.

# %%
# !spindle-drift new-machine -o {folder}/mine.toml --bearing 7014 --speed 12000 --power 15 --rig five_point

# %%
print((folder / "mine.toml").read_text()[:2500], "...")

# %% [markdown]
# ## What became of it
#
# `show-machine` draws the section to scale and lists what looks wrong.

# %%
# !spindle-drift show-machine {folder}/mine.toml -o {folder}/mine.html --force

# %%
machine = sd.Machine(folder / "mine.toml")
free = machine.parameters
free.head(10)

# %% [markdown]
# ## It simulates at once
#
# Two hours at full speed, then an hour at rest, in a hall of 21 °C.

# %%
import numpy as np
import pandas as pd

time_s = np.arange(0.0, 3 * 3600.0 + 1, 30.0)
inputs = pd.DataFrame({"time_s": time_s})
for name in machine.inputs:
    inputs[name] = 21.0
inputs["speed_rpm"] = np.where(time_s < 2 * 3600.0, 12000.0, 0.0)
run = sd.simulate(machine, inputs, noise_seed=1)
run.frame.iloc[[0, 120, 240, -1]].T.round(2)

# %%
figure = (
    run.frame.set_index("time_s")
    .filter(like="_degC")
    .plot(xlabel="time [s]", ylabel="temperature [°C]", figsize=(9, 4), grid=True)
)

# %% [markdown]
# ## One number of the drawing, and what it does
#
# Half the joint conductance between a bearing ring and its seat: how much warmer does the front get?

# %%
[seat, *_] = [name for name in free.index if "front" in name]
low = machine.with_values({seat: float(free.loc[seat, "low"])})
other = sd.simulate(low, inputs, noise_seed=1)
first = next(name for name in run.frame if name.endswith("_degC"))
print(
    f"{seat}: {free.loc[seat, 'value']:.3g} -> {free.loc[seat, 'low']:.3g} {free.loc[seat, 'unit']}"
)
(other.frame - run.frame).filter(like="_degC").iloc[240].round(2)
