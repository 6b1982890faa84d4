"""Comparison of all error models on the same runs: fit, and prediction of unseen runs.

Splits are by run or by condition, never by row: rows of one run are so similar that a model trained
on a random half of them knows the other half.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fmu_compensator.fit.columns import MeasuredColumns, shown_targets, unit_of
from fmu_compensator.fit.contestants import NO_MODEL, ONE_STEP, Contestant, held
from fmu_compensator.fit.data import Prepared, prepare, speedless_notes
from fmu_compensator.fit.features import learnable
from fmu_compensator.fit.fitting import USUAL_MODEL, as_json
from fmu_compensator.fit.installed import COVERAGE, Installed
from fmu_compensator.fit.promise import FEWEST_JUDGED_ROWS
from fmu_compensator.fit.splits import Split
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.drift import predicted_drift
from measurement.errors import BadInput
from measurement.figures import figures_of_merit
from measurement.rig import Rig
from measurement.warm import named_warm
from measurement.workers import one_thread


@dataclass(frozen=True)
class Judged:
    """One run and a contestant's prediction of it.

    Attributes
    ----------
    run : str
        Its name.
    time_s : array (n,)
        Rows with targets [s].
    measured, predicted : arrays (n, m)
        The displayed targets, in their order [um, urad].
    half_width : array (n, m) or None
        Half width of the prediction interval [um, urad].
    """

    run: str
    time_s: Array
    measured: Array
    predicted: Array
    half_width: Array | None = None


@dataclass
class Row:
    """One contestant's results.

    Attributes
    ----------
    name, title : str
        Of the contestant.
    uses_displacement : bool
        Whether it was given the measurement one sample before. The score then does not apply to a
        machine that measures no displacement while cutting.
    train, validate : list of Judged
        By run; a run may be in *train* several times, once per split.
    report : dict
        Diagnostics of the last fit.
    chosen : list of str
        Temperatures of the last fit.
    coverage : list of float
        Nominal coverage of the prediction interval, then measured per target; empty without one.
    alone : list of Judged
        The judged runs predicted by the error model alone; empty if there is no error model or no
        Gaussian.
    counts : list of array (m,)
        In each split, the weight of the error model's prediction [1].
    """

    name: str
    title: str
    uses_displacement: bool
    train: list[Judged] = field(default_factory=list)
    validate: list[Judged] = field(default_factory=list)
    report: dict[str, Any] = field(default_factory=dict)
    chosen: list[str] = field(default_factory=list)
    coverage: list[float] = field(default_factory=list)
    alone: list[Judged] = field(default_factory=list)
    counts: list[Array] = field(default_factory=list)

    def score(self, units: Sequence[str]) -> float:
        """Return the error on unseen runs over that of no model [1].

        Squares of targets in the same unit are added up, so that one that hardly moves hardly
        counts; the mean over the units is returned.

        Parameters
        ----------
        units : sequence of str
            Of the targets.
        """
        measured = np.concatenate([run.measured for run in self.validate])
        missed = measured - np.concatenate([run.predicted for run in self.validate])
        alike = [np.array(units) == unit for unit in dict.fromkeys(units)]
        pairs = [(np.sum(missed[:, here] ** 2), np.sum(measured[:, here] ** 2)) for here in alike]
        ratios = [np.sqrt(left / drift) for left, drift in pairs if drift > 0.0]
        return float(np.mean(ratios)) if ratios else float("nan")


@dataclass(frozen=True)
class Comparison:
    """Results of all contestants.

    Attributes
    ----------
    targets : list of str
        Names of the displayed targets.
    units : list of str
        Their units.
    rows : list of Row
        Ranked by error on unseen runs; rows that use displacement come last.
    left_out : dict of str to str
        Models that cannot be fitted to the runs, and why.
    notes : list of str
        What was left out of the data, and what looks odd in it.
    """

    targets: list[str]
    units: list[str]
    rows: list[Row]
    left_out: dict[str, str]
    notes: list[str]

    def to_dict(self) -> dict[str, Any]:
        """Return everything in JSON types; undefined values are null."""
        return {
            "targets": dict(zip(self.targets, self.units, strict=True)),
            "models": [self._row(row) for row in self.rows],
            "left_out": [{"name": n, "reason": why} for n, why in self.left_out.items()],
            "notes": self.notes,
        }

    def _row(self, row: Row) -> dict[str, Any]:
        validate = self.figures(row.validate)
        per_run = [{"run": run.run, **self.figures([run])} for run in row.validate]
        table = {
            "name": row.name,
            "title": row.title,
            "uses_displacement": row.uses_displacement,
            "score": row.score(self.units),
            "temperatures": row.chosen,
            "train": self.figures(row.train),
            "validate": {**validate, "per_run": per_run},
        }
        if row.coverage:
            wanted, *covered = row.coverage
            shares = dict(zip(self.targets, covered, strict=True))
            table["interval"] = {"coverage_wanted": wanted, "coverage_measured": shares}
        if row.alone:
            table["alone"] = self.figures(row.alone)
            table["counts"] = self.counted(row)
        if "curve" in row.report:
            table["convergence"] = row.report["curve"]
        plain: dict[str, Any] = as_json(table)
        return plain

    def counted(self, row: Row) -> dict[str, float]:
        """Return the weight of the error model by target, mean over the splits [1]."""
        return dict(zip(self.targets, np.mean(row.counts, axis=0), strict=True))

    def figures(self, judged: Sequence[Judged]) -> dict[str, dict[str, float]]:
        """Return the figures of merit of each target over all rows of some runs.

        Parameters
        ----------
        judged : sequence of Judged
            Runs with the same targets as the comparison.

        Returns
        -------
        dict of str to dict of str to float
            By target; the inner names are those of `measurement.figures.figures_of_merit` [um,
            urad].
        """
        measured = np.concatenate([run.measured for run in judged])
        predicted = np.concatenate([run.predicted for run in judged])
        return {
            name: figures_of_merit(measured[:, place], predicted[:, place])
            for place, name in enumerate(self.targets)
        }


@one_thread()
def compare(
    splits: Sequence[Split],
    rig: Rig | MeasuredColumns,
    entrants: Sequence[Contestant],
    *,
    on_step: Callable[[str], None] = lambda label: None,
) -> Comparison:
    """Return the results of every contestant on every split.

    Parameters
    ----------
    splits : sequence of Split
        Results of all splits are combined.
    rig : rig or MeasuredColumns
        Meaning of the displacement columns.
    entrants : sequence of Contestant
        See `contestants`.
    on_step : callable
        Called with the label of each piece of work as it begins: one per split and contestant.

    Raises
    ------
    BadInput
        If no run can be used, or no model at all can be fitted; a single model that cannot be
        fitted is left out with the reason.
    """
    usable = [_usable(split) for split in splits]
    bench = [_Bench(split, rig) for split, _ in usable]
    first = bench[0].of("rise")[0]
    places = shown_targets(rig, first.targets)
    units = [unit_of(rig, name) for name in places]
    rows: list[Row] = []
    left_out: dict[str, str] = {}
    last: BadInput | None = None
    for entrant in entrants:
        rows_here = _rows_of(entrant)
        try:
            for split_bench in bench:
                on_step(f"{entrant.name} on {split_bench.split.name}")
                split_bench.judge(entrant, rows_here, list(places.values()))
        except BadInput as refusal:
            left_out[entrant.name] = str(refusal)
            last = refusal
            continue
        # A model that could use measurements may not do so (a hybrid whose parts cannot).
        rows += [row for row in rows_here if row.validate]
    if last is not None and not any(row.chosen for row in rows):
        raise last  # no model at all can be fitted
    _measure_coverage(rows)
    rows.sort(key=lambda row: (row.uses_displacement, row.score(units)))
    notes = list(dict.fromkeys(note for split_bench in bench for note in split_bench.notes()))
    notes += dict.fromkeys(note for _, note in usable if note)
    return Comparison(list(places), units, rows, left_out, notes)


def _rows_of(entrant: Contestant) -> list[Row]:
    """Return a contestant's rows: by itself and, if it can use measurements, one step ahead."""
    rows = [Row(entrant.name, entrant.title, False)]
    if entrant.name == NO_MODEL:
        return rows
    if entrant.recipe is None or entrant.recipe.model.uses_measured:
        title = f"{entrant.title}, one step ahead"
        rows.append(Row(entrant.name + ONE_STEP, title, True))
    return rows


def _usable(split: Split) -> tuple[Split, str]:
    """Return a split without runs that teach nothing, and a note about them; empty if none."""
    train, unused = learnable(split.train)
    notes = [f"{split.name}: {note}" for note in unused]
    if judged := named_warm(split.validate):
        notes.append(f"judged like cold starts, though the machine was warm: {judged}")
    return replace(split, train=train), "; ".join(notes)


class _Bench:
    """One split's runs, prepared once for each input form."""

    def __init__(self, split: Split, rig: Rig | MeasuredColumns) -> None:
        self.split, self._rig = split, rig
        self._prepared: dict[str, tuple[Prepared, Prepared]] = {}

    def of(self, form: str) -> tuple[Prepared, Prepared]:
        """Return the training and judged runs in an input form."""
        if form not in self._prepared:
            train = prepare(self.split.train, self._rig, form)
            validate = prepare(self.split.validate, self._rig, form, sensors=train.sensors)
            if validate.sensors != train.sensors:
                missing = ", ".join(sorted(set(train.sensors) - set(validate.sensors)))
                problem = f"{missing}: in the training runs, but not in all judged ones"
                raise BadInput("judged runs", "", problem)
            for run in validate.runs:
                if run.history([]).known.sum() < FEWEST_JUDGED_ROWS:
                    few = f"has fewer than {FEWEST_JUDGED_ROWS} rows with all displacements"
                    raise BadInput("judged runs", run.name, f"{run.lost or few}: leave it out")
            if speedless := speedless_notes(train, validate):  # as `fit` to all of them decides
                train = replace(train.without_speed(), notes=(*train.notes, *speedless))
                validate = validate.without_speed()
            self._prepared[form] = train, validate
        return self._prepared[form]

    def notes(self) -> list[str]:
        """Return the notes on the data."""
        return [
            note
            for train, validate in self._prepared.values()
            for note in (*train.notes, *(n for n in validate.notes if "rows left out" in n))
        ]

    def judge(self, entrant: Contestant, rows: Sequence[Row], places: list[int]) -> None:
        """Fit a contestant and add its predictions to its rows.

        The prediction judged is that of what `fit` would install, including the Gaussian. In
        addition, and one step ahead, the error model alone is judged, as in the studies.
        """
        if entrant.recipe is None:
            self._baseline(rows, places)
            return
        recipe = entrant.recipe
        train, validate = self.of(recipe.input_form)
        installed = Installed.fit(recipe, train, train.runs)
        fitted, chosen = installed.fitted, installed.chosen
        for row in rows:
            free = not row.uses_displacement
            if not free and not fitted.uses_measured:
                continue
            row.report = fitted.report()
            row.chosen = [train.sensors[index] for index in chosen]
            has_mean = free and recipe.kind != USUAL_MODEL
            if has_mean:
                row.counts.append(installed.gaussian.share[places])
            for runs, judged in ((train.runs, row.train), (validate.runs, row.validate)):
                for run in runs:
                    if free:
                        prediction = installed.predict(run)
                        whole, width = prediction.rows, prediction.half_width
                        values, mean = (
                            predicted_drift(-shown, whole.targets, recipe.input_form)
                            for shown in (prediction.values, prediction.mean)
                        )
                        if has_mean and judged is row.validate:
                            row.alone += _judged(whole, mean, places, None)
                    else:
                        whole, width = recipe.rows(run, chosen), None
                        values = fitted.predict(whole, whole.targets)
                    judged += _judged(whole, values, places, width)

    def _baseline(self, rows: Sequence[Row], places: list[int]) -> None:
        train, validate = self.of("rise")
        for row in rows:
            for runs, judged in ((train.runs, row.train), (validate.runs, row.validate)):
                for run in runs:
                    whole = run.history([])
                    values = held(whole, whole.targets if row.uses_displacement else None)
                    judged += _judged(whole, values, places, None)


def _judged(
    run: TrainingRun, values: Array, places: list[int], width: Array | None
) -> list[Judged]:
    known = run.known
    if not known.any():
        return []
    return [
        Judged(
            run.name,
            run.time_s[known],
            run.targets[known][:, places],
            values[known][:, places],
            None if width is None else width[known][:, places],
        )
    ]


def _measure_coverage(rows: Iterable[Row]) -> None:
    for row in rows:
        if not row.validate or any(run.half_width is None for run in row.validate):
            continue
        inside = [
            np.abs(run.measured - run.predicted) <= run.half_width
            for run in row.validate
            if run.half_width is not None
        ]
        row.coverage = [COVERAGE, *np.concatenate(inside).mean(axis=0).tolist()]
