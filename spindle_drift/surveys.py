"""Which temperatures are alike, and which explain most of the drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from fmu_compensator.fit.columns import targets_of
from fmu_compensator.fit.survey import Survey, survey
from scenarios.presets import preset
from spindle_drift._inputs import MachineLike, RunLike, as_runs
from spindle_drift._refusals import refuse_options, refusing, refusing_methods
from spindle_drift.compensators import USUAL_MACHINE
from spindle_drift.machines import as_machine


@refusing_methods
@dataclass(frozen=True)
class Points:
    """How alike temperatures are, and which are chosen.

    Attributes
    ----------
    chosen : list of str
        The chosen temperatures.
    groups : dict of str to list of list of str
        Groups of temperatures, by grouping method.
    degree : DataFrame
        Grey comprehensive degree of all pairs [1].
    scores : DataFrame
        Pearson's r and the grey relational degree of each temperature to the error [1].
    combinations : DataFrame
        All combinations of the chosen temperatures, largest adjusted R2 first.
    details : dict
        Everything, as ``spindle-drift points --json`` prints it.
    survey : Survey
        The same as arrays, with the dendrogram's linkage.
    """

    chosen: list[str]
    groups: dict[str, list[list[str]]]
    degree: pd.DataFrame
    scores: pd.DataFrame
    combinations: pd.DataFrame
    details: dict[str, Any] = field(repr=False)
    survey: Survey = field(repr=False)


@refusing
def points(
    runs: RunLike | Sequence[RunLike],
    *,
    machine: MachineLike | None = None,
    study: str | None = None,
    **options: Any,
) -> Points:
    """Group temperatures and choose the most informative of each group.

    Parameters
    ----------
    runs : Run, DataFrame or path, or several
        Runs with temperatures and displacements.
    machine : Machine, path or name, optional
        Machine whose rig defines the displacements; without it the column names do.
    study : {"GA", "TS", "VAC"}, optional
        Choose as that study does. Other arguments override it.
    **options
        Options of `fmu_compensator.fit.survey.survey`: ``target``, ``grouping``, ``threshold``,
        ``theta``, ``image``, ``absolute_image``, ``clusters``, ``variables``, ``keep_quiet``,
        ``score``.

    Returns
    -------
    Points

    Raises
    ------
    BadInput
        If the runs or options cannot be used.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> run = sd.simulate("jig_borer", "step_speed", every_s=60.0, noise_seed=1)
    >>> len(sd.points(run, machine="jig_borer", study="TS").chosen)
    5
    """
    refuse_options(survey, options, "points")
    recorded = as_runs(runs)
    rig = targets_of(recorded, as_machine(machine or USUAL_MACHINE).model.rig)
    if study is not None:
        given = preset(study, recorded, options.get("grouping"))
        options = {**given.grey, "grouping": given.points, **options}
    surveyed = survey(recorded, rig, **options)
    table = surveyed.to_dict()
    names = table["sensors"]
    scores = pd.DataFrame({key: table[key] for key in ("pearson", "relational")}).loc[names]
    return Points(
        table["points"],
        table["groups"],
        pd.DataFrame(table["degree"], index=names, columns=names),
        scores,
        pd.DataFrame(table["subsets"]),
        table,
        surveyed,
    )
