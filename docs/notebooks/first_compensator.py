# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # My first compensator, from an xlsx
#
# From a recorder's workbook to a compensator, judged on an unseen day, and to the FMU for a control or
# a simulation tool. `march.xlsx` holds five days of a simulated jig borer, written as a German recorder
# would write them: local dates, units in a second header line, kelvin, millimetres. It is in the same
# folder as this notebook; `docs/site/make_march.py` made it. Your own workbook works the same way.

# %%
import spindle_drift as sd

# %% [markdown]
# ## Import
#
# Names become signals with units, units are converted, and the long log is cut at its pauses: one run
# a day. The import lists what it could not place and what looks doubtful.

# %%
log = sd.import_log("march.xlsx")
log.table

# %%
print("left out:", log.left_out)
print("doubtful:", log.doubts)
log.runs[0].frame.head()

# %% [markdown]
# ## Look
#
# Before fitting a model: how far does the nose move, how fast, and are any sensors faulty?

# %%
print(sd.summary(log.runs[1]).text())

# %%
figure = (
    log.runs[1]
    .frame.set_index("time_s")
    .filter(like="_um")
    .plot(xlabel="time [s]", ylabel="drift [µm]", figsize=(9, 3), grid=True)
)

# %% [markdown]
# ## Fit
#
# Four days to learn from; the fifth is kept back.

# %%
train, unseen = log.runs[:4], log.runs[4]
compensator = sd.fit(train, name="my_compensator")
compensator.model.title

# %% [markdown]
# The promise: root mean square errors in µm without compensation, on the training runs, and on runs left out,
# like and unlike the rest. Rely on the worse of the last two. In conditions outside training the compensator
# reports status 2 and its interval widens.

# %%
compensator.figures

# %% [markdown]
# ## Judge
#
# The unseen day, with all checks and limits, as a control would run it.

# %%
judged = compensator.judge(unseen)
judged.filter(like="_um").pow(2).mean().pow(0.5).round(2)

# %%
figure = compensator.plot(unseen)

# %% [markdown]
# Does it still fit? The same question for logs of later weeks; see [Watch, measure,
# update](../lifecycle.md).

# %%
report = compensator.monitor(unseen)
print(report.verdict, "-", report.summary)

# %% [markdown]
# ## Take it elsewhere
#
# The file holds the model and its uncertainty, so `update` can add more days without the old ones. The FMU is
# FMI 2.0 co-simulation: temperatures, speed and tool length in; offsets, uncertainty and status out.

# %%
import tempfile
from pathlib import Path

folder = Path(tempfile.mkdtemp())
compensator.save(folder / "my_compensator.json")
print(sd.build_fmu(compensator, folder / "dist", name="my_compensator"))
sorted(path.name for path in (folder / "dist").iterdir())
