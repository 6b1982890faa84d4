# ---
# jupyter:
#   jupytext:
#     text_representation: {extension: .py, format_name: percent}
#   kernelspec: {display_name: Python 3, language: python, name: python3}
# ---

# %% [markdown]
# # Calibrating through the FMU: sensitivities from its derivatives
#
# `spindle-drift calibrate` fits a machine file. If you have only the FMU, you can fit its parameters as well:
# with the plant's [derivatives](../fmu.md#derivatives) by states and parameters, one simulation also gives the
# sensitivity of every reading to each parameter, so the Jacobian of the fit needs no further simulations. The
# "measurements" here come from the same FMU with other parameters, plus noise. Apart from these parameters the
# model is exact, which it never is for a real machine.

# %%
import tempfile
from pathlib import Path
from time import process_time

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from scipy.linalg import expm
from scipy.optimize import least_squares

import spindle_drift as sd

folder = Path(tempfile.mkdtemp())
path = sd.build_fmu("jig_borer_lumps", folder, name="plant", native=True)
description = fmpy.read_model_description(str(path))
variables = {v.name: v for v in description.modelVariables}
states = [v.derivative.name for v in description.modelVariables if v.derivative is not None]
shown = [f"T{i}" for i in range(1, 12) if i not in (5, 9)] + ["drift_X", "drift_Y", "drift_Z"]
fitted = ["sources.front_bearing.f0", "sources.rear_bearing.f0", "sources.motor.loss"]
known = np.array([float(variables[name].start) for name in fitted])
true = known * [1.4, 0.8, 1.2]


# %% [markdown]
# ## A simulation with its sensitivities
#
# In a co-simulation the FMU steps itself. Sensitivities S of the states follow S' = A S + B, with A and B from
# the derivatives of the rates by states and parameters; one exponential takes them over a step.

# %%
STEP, STEPS = 60.0, 240
unzipped = fmpy.extract(str(path))
simulations = 0


def refs(names):
    return [variables[name].valueReference for name in names]


RATES, STATES, SHOWN, FITTED = (
    refs(names) for names in ([f"der({name})" for name in states], states, shown, fitted)
)


def simulated(parameters, sensitivities=False):
    """Return what is shown after each step, and how it follows the parameters."""
    global simulations
    simulations += 1
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=unzipped,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="fitted",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.setReal(FITTED, list(parameters))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()

    def slopes(unknowns, knowns):
        return np.array([fmu.getDirectionalDerivative(unknowns, [k], [1.0]) for k in knowns]).T

    found, followed = [], []
    n, p = len(states), len(fitted)
    s = np.zeros((n, p))
    for k in range(STEPS):
        fmu.setReal(refs(["speed"]), [4000.0 if k < 120 else 1500.0])
        if sensitivities:
            both = np.zeros((n + p, n + p))
            both[:n, :n], both[:n, n:] = slopes(RATES, STATES), slopes(RATES, FITTED)
            both = expm(STEP * both)
            s = both[:n, :n] @ s + both[:n, n:]
        fmu.doStep(k * STEP, STEP)
        found.append(fmu.getReal(SHOWN))
        if sensitivities:
            followed.append(slopes(SHOWN, STATES) @ s + slopes(SHOWN, FITTED))
    fmu.terminate()
    fmu.freeInstance()
    return np.array(found), np.array(followed)


# %% [markdown]
# Compared with central differences, which take two simulations per parameter:

# %%
_, exact = simulated(known, sensitivities=True)
differences = []
for place, value in enumerate(known):
    ends = [known + sign * 1e-3 * value * (np.arange(len(known)) == place) for sign in (1, -1)]
    up, down = (simulated(end)[0] for end in ends)
    differences.append((up - down) / (2e-3 * value))
differences = np.moveaxis(differences, 0, -1)
for place, name in enumerate(fitted):
    off = np.abs(exact - differences)[..., place].max() / np.abs(differences[..., place]).max()
    print(f"{name}: apart by {off:.1e} of the largest")

# %% [markdown]
# ## The fit
#
# Here derivatives save simulations but no time, because Python calls the FMU for every column of the Jacobians
# in each step. Their advantage is that no difference step has to be chosen.

# %%
NOISE = np.array([0.05] * 9 + [0.5] * 3)  # [K], [um]
measured = simulated(true)[0]
measured = measured + NOISE * np.random.default_rng(1).standard_normal(measured.shape)


def missed(scale):
    return ((simulated(scale * known)[0] - measured) / NOISE).ravel()


def jacobian(scale):
    _, followed = simulated(scale * known, sensitivities=True)
    return (followed * known / NOISE[:, None]).reshape(-1, len(known))


for name, by in (("with derivatives", jacobian), ("with differences", "2-point")):
    simulations, began = 0, process_time()
    fit = least_squares(missed, np.ones(len(known)), jac=by)
    deviations = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
    print(f"{name}: {simulations} simulations, {process_time() - began:.1f} s of the processor")
    for place, parameter in enumerate(fitted):
        print(
            f"  {parameter}: {fit.x[place]:.4f} +- {deviations[place]:.4f} of what the machine file "
            f"says; in truth {true[place] / known[place]:.1f}"
        )
