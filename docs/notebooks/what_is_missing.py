# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # What does my model lack?
#
# A spindle model is never complete. The gap finder compares it with measured runs, shows how much of the
# difference can be explained at all, names what is missing, adds it, and judges the answer on unseen runs.
# The model is the jig borer in 24 lumps; the page `jig_borer` takes some minutes longer. Here the truth is
# known: on the machine that "measured" the runs, a long tool holder warms through the nose and grows, and
# our model lacks this effect.

# %%
# %% [markdown]
# ## Runs of a machine that knows more than our model
# %%
import tempfile
from pathlib import Path

import spindle_drift as sd

folder = Path(tempfile.mkdtemp())
model = sd.Machine("jig_borer_lumps")
text = Path(model.save(folder / "ours.toml")).read_text()
long = '{ value = 180, unit = "mm", low = 20, high = 250, source = "a long holder" }'
effect = f"[effects.tool_heating]\nholder_length = {long}\n"
(folder / "truth.toml").write_text(text.split("\n", 1)[1] + "\n" + effect)
truth = sd.Machine(folder / "truth.toml")
names = ["training_down", "training_random", "training_stops", "stop_and_go"]
runs = [sd.simulate(truth, name, every_s=60.0, noise_seed=n) for n, name in enumerate(names)]

# %% [markdown]
# ## Ask
#
# Only five effects are considered so that this page builds quickly; leave out `without` to try the whole
# catalogue. The last run is kept back for judging.

# %%
from plant_model.effects import catalogue

few = {"tool_heating", "centrifugal_shift", "slow_structure", "sensor_offset", "column_bending"}
without = [name for name in catalogue() if name not in few]
gap = sd.find_gap(model, runs[:3], [runs[3]], without=without, workers=1, out=folder / "gap")
print(gap.text)

# %% [markdown]
# ## The gap, channel by channel
#
# Residuals before and after, and the part that comes from sensor noise alone.

# %%
figure = gap.plot()

# %% [markdown]
# `gap.machine` is the model with the effect in force; every command takes it as a machine. The report in
# the folder shows where and when the model was off, and which effects came close. If the data cannot tell two
# effects apart, the verdict is `one_of` and the report describes a run that would; if nothing in the catalogue
# explains the gap, the verdict is `unknown`. See [what a model lacks](../gap.md) and [how often it is
# right](../gap_benchmark.md).

# %%
print(gap.verdict, gap.effects)
sorted(path.name for path in (folder / "gap").iterdir())
