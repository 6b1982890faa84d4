"""Compares error models on unseen runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from fmu_compensator.fit import comparison
from fmu_compensator.fit.columns import targets_of
from fmu_compensator.fit.contestants import Contestant, contestants
from fmu_compensator.fit.splits import Split, leave_out
from fmu_compensator.fit.survey import survey
from measurement.doubts import doubt_lines
from measurement.errors import BadInput
from measurement.faults import Fault, find_faults, looked_over
from scenarios.presets import Preset, preset
from spindle_drift._inputs import MachineLike, RunLike, as_runs
from spindle_drift._plots import plot_bars
from spindle_drift._refusals import refuse_options, refusing, refusing_methods
from spindle_drift.compensators import USUAL_MACHINE
from spindle_drift.machines import as_machine

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@refusing_methods
@dataclass(frozen=True)
class Comparison:
    """How well error models predict unseen runs.

    Attributes
    ----------
    table : DataFrame
        The title of each model, and for each target the RMSE on training and on unseen runs, the
        share of the unseen drift that it predicts, the RMSE of the error model alone and its weight
        next to the Gaussian; best first, baselines included.
    left_out : dict of str to str
        Models that cannot be fitted to these runs, and why.
    notes : list of str
        Data that was left out.
    details : dict
        Everything, as ``spindle-drift compare --json`` prints it.
    faults : list of Fault
        Faulty data in the runs; it was not used.
    doubts : list of str
        Numbers in the runs that contradict what they are said to be.
    results : fmu_compensator.fit.comparison.Comparison
        The measured and predicted values, run by run.
    """

    table: pd.DataFrame
    left_out: dict[str, str]
    notes: list[str]
    details: dict[str, Any] = field(repr=False)
    faults: list[Fault] = field(repr=False)
    doubts: list[str] = field(repr=False)
    results: comparison.Comparison = field(repr=False)

    def plot(self, target: str | None = None) -> Figure:
        """Return a figure of the errors on training and on unseen runs, best model first.

        Parameters
        ----------
        target : str, optional
            Target whose RMSE is shown; by default the first.

        Raises
        ------
        BadInput
            If the comparison has no RMSE of the target.
        """
        ends = ("_training", "_unseen")
        names = [str(name) for name in self.table]
        targets = [name.removesuffix(ends[1]) for name in names if name.endswith(ends[1])]
        name = targets[0] if target is None else target
        if name not in targets:
            raise BadInput("plot", "target", f"{name!r} is not allowed: {', '.join(targets)}")
        columns = {f"{name}{end}": end.strip("_") for end in ends}
        shown = self.table[list(columns)].rename(columns=columns)
        return plot_bars(shown, f"RMSE of {name}", "RMSE [µm, µrad]")

    @property
    def best(self) -> str:
        """The model with the smallest error on unseen runs, baselines excluded."""
        free = self.table[~self.table["uses_displacement"]]
        return str(next(name for name in free.index if name not in ("no_model", "persistence")))


@refusing
def compare(
    train: Sequence[RunLike],
    validate: Sequence[RunLike] = (),
    *,
    models: Sequence[str] | None = None,
    machine: MachineLike | None = None,
    by: str = "run",
    seed: int | None = None,
    study: str | None = None,
    points: str = "",
    grey: Mapping[str, Any] | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
    on_step: Callable[[str, int], None] = lambda label, steps: None,
) -> Comparison:
    """Compare error models on unseen runs.

    Parameters
    ----------
    train, validate : sequence of Run, DataFrame or path
        Training runs and unseen runs. Without *validate*, each of *train* is left out in turn.
    models : sequence of str, optional
        Error models; all by default. The baselines no_model and persistence are always included.
    machine : Machine, path or name, optional
        Machine file whose rig defines the displacements; by default that of `jig_borer` if the runs
        have its columns, otherwise every displacement column is a target.
    by : {"run", "speeds"}
        What is left out in turn: each run, or all runs of the same speeds.
    seed : int, optional
        Random seed, for models that start at random.
    study : {"GA", "TS", "VAC"}, optional
        Do as that study does: its models with their options, and its points. Other arguments
        override it.
    points : str
        Temperatures for all models; by default each model's usual ones.
    grey : mapping, optional
        Options of the choice of points, as `spindle_drift.points` takes them.
    options : mapping of str to mapping, optional
        Options of the models, by model name.
    on_step : callable
        Called with the label of each piece of work as it begins, and the number of pieces.

    Returns
    -------
    Comparison

    Raises
    ------
    BadInput
        If the runs or models cannot be used.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> names = ["training_down", "training_random", "stop_and_go"]
    >>> runs = [sd.simulate("jig_borer", name, every_s=60.0, noise_seed=1) for name in names]
    >>> found = sd.compare(runs[:2], runs[2:], models=["mlr", "ridge"])
    >>> sorted(found.table.index[~found.table["uses_displacement"]])
    ['mlr', 'no_model', 'persistence', 'ridge']
    """
    refuse_options(survey, grey or {}, "compare, grey")
    learnt, judged = as_runs(list(train)), as_runs(list(validate)) if len(validate) else []
    digests = {run.fingerprint(): run for run in learnt}
    for run in judged:
        if (same := digests.get(run.fingerprint())) is not None:
            problem = f"is the same run as {same.name} in --train"
            raise BadInput("--validate", run.name, f"{problem}: it would be judged on what it saw")
    given = None if study is None else preset(study, [*learnt, *judged], points)
    entrants = _contestants(models, given, points, grey or {}, options or {}, seed)
    # All runs together, so that every fold and every figure has the same verdict on each sensor.
    every = looked_over([*learnt, *judged])
    rig = targets_of(every, as_machine(machine or USUAL_MACHINE).model.rig)
    if judged:
        splits = [Split("the judged runs", every[: len(learnt)], every[len(learnt) :])]
    else:
        splits = leave_out(every, by)
    steps = len(splits) * len(entrants)
    compared = comparison.compare(
        splits, rig, entrants, on_step=lambda label: on_step(label, steps)
    )
    runs = sorted({run.fingerprint(): run for run in every}.values(), key=lambda run: run.name)
    faults = find_faults(runs)
    details = compared.to_dict() | {"data": [fault.to_dict() for fault in faults]}
    return Comparison(
        _ranking(details["models"], compared.targets),
        dict(compared.left_out),
        list(compared.notes),
        details,
        faults,
        doubt_lines(runs),
        compared,
    )


def _ranking(models: Sequence[Mapping[str, Any]], targets: Sequence[str]) -> pd.DataFrame:
    rows = {}
    for entry in models:
        row = {"title": entry["title"], "uses_displacement": bool(entry["uses_displacement"])}
        for target in targets:
            row[f"{target}_training"] = entry["train"][target]["rmse"]
            row[f"{target}_unseen"] = entry["validate"][target]["rmse"]
            row[f"{target}_predicted"] = entry["validate"][target]["eta"]
            if "alone" in entry:
                row[f"{target}_alone"] = entry["alone"][target]["rmse"]
                row[f"{target}_counts"] = entry["counts"][target]
        rows[entry["name"]] = row
    return pd.DataFrame.from_dict(rows, orient="index")


def _contestants(
    models: Sequence[str] | None,
    given: Preset | None,
    points: str,
    grey: Mapping[str, Any],
    options: Mapping[str, Mapping[str, Any]],
    seed: int | None,
) -> list[Contestant]:
    if given is not None:
        models = list(given.models) if models is None else models
        points, grey = points or given.points, {**given.grey, **grey}
        options = {
            name: {**given.models.get(name, {}), **options.get(name, {})}
            for name in {*models, *options}
        }
    return contestants(models, points=points, seed=seed, grey=grey, options=options)
