"""Who takes part: the studies' models as they train them and as we do, ours, and baselines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from benchmarks.studies.published import GA_POINTS
from fmu_compensator.fit.recipe import Recipe
from scenarios.presets import PRESETS, TRAINED

STUDY_STEP_S = 270.0
"""The time-series study has 89 samples of some 400 min [s]."""
STUDY_POINTS = ",".join(f"T{number}" for number in GA_POINTS)
"""What the GA-BP study chose of the same eleven thermometers."""
SEEDED = ("bp", "ga_bp", "vac")
TRUTH, NO_MODEL, PERSISTENCE = "truth", "no_model", "persistence"
STUDY_CHOICE = PRESETS["GA"].grey
"""How the GA-BP study chooses: absolute degree on initial-value images, relative degree on mean
images, one point a group by its grey relational degree to elongation."""
TS_CHOICE = PRESETS["TS"].grey
"""How the time-series study chooses: hierarchical clustering with C = 4, the ambient air kept, five
variables by their correlation with elongation."""


@dataclass(frozen=True)
class Entrant:
    """One row of a table.

    Attributes
    ----------
    title : str
        For the tables.
    kind : str
        Kind of error model, or one of `TRUTH`, `NO_MODEL`, `PERSISTENCE`.
    options : mapping
        Of the error model.
    points : str
        Temperatures to use; empty: what is usual for the model.
    grey : mapping
        Options of their choice.
    step_s : float, optional
        Rows are thinned to this [s].
    measured : bool
        Whether it is told the drift measured one step before.
    machines : tuple of str
        Where it takes part; empty: everywhere.
    memory : bool, optional
        Of a baseline by temperature: whether it remembers earlier samples.
    """

    title: str
    kind: str
    options: Mapping[str, Any] = field(default_factory=dict)
    points: str = ""
    grey: Mapping[str, Any] = field(default_factory=dict)
    step_s: float | None = None
    measured: bool = False
    machines: tuple[str, ...] = ()
    memory: bool | None = None

    @property
    def is_fitted(self) -> bool:
        """Whether there is a model to fit."""
        return self.kind not in (TRUTH, NO_MODEL, PERSISTENCE)

    @property
    def by_temperature(self) -> bool:
        """Whether it predicts without measured displacement, from more than the speed alone."""
        return self.is_fitted and self.kind not in ("arma", "ne", "fem")

    def recipe(self, seed: int) -> Recipe:
        """Return how to fit it, with a random start of its own for every seed."""
        options = dict(self.options)
        if self.kind in SEEDED:
            options["seed"] = seed
        return Recipe(self.kind, points=self.points, grey=self.grey, options=options)


ENTRANTS: Mapping[str, Entrant] = {
    TRUTH: Entrant("Ceiling: the truth without noise", TRUTH),
    NO_MODEL: Entrant("No model", NO_MODEL),
    "persistence": Entrant("Persistence, 30 s before", PERSISTENCE, measured=True),
    "persistence_270": Entrant(
        "Persistence, 270 s before", PERSISTENCE, step_s=STUDY_STEP_S, measured=True
    ),
    "bp_study": Entrant("BP, as GA", "bp", TRAINED, points=STUDY_POINTS),
    "ga_bp_study": Entrant("GA-BP, as GA", "ga_bp", {**TRAINED, "hidden": 10}, points=STUDY_POINTS),
    "ga_bp_nodes": Entrant(
        "GA-BP without decay, nodes by data left out",
        "ga_bp",
        TRAINED,
        points=STUDY_POINTS,
        machines=("study_size",),
    ),
    "ga_bp_nodes_training": Entrant(
        "GA-BP without decay, nodes by the error in training",
        "ga_bp",
        {**TRAINED, "nodes_by": "training"},
        points=STUDY_POINTS,
        machines=("study_size",),
    ),
    "bp_four": Entrant("BP with decay, GA's points", "bp", points=STUDY_POINTS),
    "ga_bp_four": Entrant("GA-BP with decay, GA's points", "ga_bp", points=STUDY_POINTS),
    "bp_chosen": Entrant(
        "BP with decay, points chosen as GA", "bp", points="grey", grey=STUDY_CHOICE
    ),
    "bp": Entrant("BP with decay, our points", "bp"),
    "ga_bp": Entrant("GA-BP with decay, our points", "ga_bp"),
    "bp_5_5": Entrant("BP 5-5 with decay, our points", "bp", {"hidden": (5, 5)}),
    "mlr_ts": Entrant("MLRA, as TS", "mlr", points="hierarchical", grey=TS_CHOICE),
    "bp_ts": Entrant(
        "BP 5-5-5-3, as TS",
        "bp",
        {**TRAINED, "hidden": (5, 5)},
        points="hierarchical",
        grey=TS_CHOICE,
    ),
    "mlr": Entrant("Multiple linear regression, grey points", "mlr"),
    "mlr_all": Entrant(
        "Linear regression, all thermometers", "mlr", {"subset": False}, points="all", memory=False
    ),
    "ridge_all": Entrant(
        "Ridge, all thermometers", "ridge", {"lags_s": ()}, points="all", memory=False
    ),
    "arma": Entrant("Time series, free-running", "arma"),
    "arma_one": Entrant("Time series, one step of 30 s", "arma", measured=True),
    "arma_270": Entrant(
        "Time series, one step of 270 s",
        "arma",
        {"step_s": STUDY_STEP_S},
        step_s=STUDY_STEP_S,
        measured=True,
    ),
    "ne": Entrant("Natural exponential", "ne"),
    "fem": Entrant("Finite-element spindle", "fem"),
    "vac": Entrant("VAC hybrid", "vac"),
    "vac_least_squares": Entrant(
        "VAC's least-squares twin", "vac", {"combination": "least_squares"}
    ),
    "vac_adaptive": Entrant("VAC with adaptive weights", "vac", {"combination": "adaptive"}),
    "ne_fem": Entrant(
        "Natural exponential, zss and tau from FEM", "ne", {"steady": "fem", "tau_s": "fem"}
    ),
    "arx": Entrant("ARX with temperatures", "arx"),
    "armax": Entrant("ARMAX with temperatures", "arx", {"estimator": "armax"}),
    "ridge": Entrant("Ridge, lagged temperatures", "ridge", memory=True),
    "bayes": Entrant("Bayesian ridge, lagged temperatures", "bayes"),
    "thermal_states": Entrant("Ridge, thermal states", "thermal_states", memory=True),
}
