# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # My first compensator, from an xlsx
#
# From a recorder's workbook to a compensator that has been judged on a day that it never saw, and to
# the FMU that a control or a simulation tool takes. `march.xlsx` holds five days of a simulated jig
# borer, written as a German recorder would: local dates, units in a second header line, kelvin,
# millimetres. It lies beside this notebook; `docs/site/make_march.py` made it. Yours goes the same way.

# %%
import spindle_drift as sd

# %% [markdown]
# ## Import
#
# Names become signals with units, units are converted, and the long log is cut at its pauses: one run
# a day. What could not be placed, and what looks doubtful, is said.

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
# Before any model: how far does the nose move, how fast, and what is wrong with the sensors?

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
# What it promises: root mean square errors in µm without compensation, on its own training runs, and on runs
# left out: like the rest, and unlike them. Believe the worse of the last two. In conditions that training did not
# see the compensator says so while it runs (status 2), and its interval widens.

# %%
compensator.figures

# %% [markdown]
# ## Judge
#
# The day that was kept back, with all checks and limits, as a control would run it.

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
# The file holds what was learnt and how surely, so that `update` can take in more days without the old ones. The FMU is FMI 2.0 co-simulation: temperatures, speed and
# tool length in; offsets, uncertainty and status out.

# %%
import tempfile
from pathlib import Path

folder = Path(tempfile.mkdtemp())
compensator.save(folder / "my_compensator.json")
print(sd.build_fmu(compensator, folder / "dist", name="my_compensator"))
sorted(path.name for path in (folder / "dist").iterdir())
