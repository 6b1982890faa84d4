"""Fits compensators, applies them to runs, judges and monitors them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from fmu_compensator.driving import answers, inputs_of
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.survey import survey
from fmu_compensator.fit.updating import update_compensator
from fmu_compensator.monitoring import Report
from fmu_compensator.monitoring import monitor as watch
from fmu_compensator.runtime.modelfile import Model, load_model, parse_model
from measurement.drift import error_left, measured_drift
from measurement.files import write_atomically
from measurement.rig import FivePointRig, Rig, default_rig, rig_from_table
from measurement.runs import Run
from plant_model.machine_file import read_machine
from scenarios.grey_options import usual_choice
from scenarios.outputs import COMPENSATOR_FILE, check_output, guarding
from scenarios.presets import preset
from scenarios.replay import model_of, rig_of_model
from spindle_drift._inputs import (
    MachineLike,
    RunLike,
    as_run,
    as_runs,
    warn_of_doubts,
    warn_of_drift,
)
from spindle_drift._plots import plot_judged
from spindle_drift._refusals import refuse_options, refusing, refusing_methods

if TYPE_CHECKING:
    from matplotlib.figure import Figure

USUAL_MACHINE = "jig_borer"


@refusing_methods
@dataclass(frozen=True, repr=False)
class Compensator:
    """A compensator: temperatures, speed and tool length in, axis offsets out.

    Parameters
    ----------
    model : Model
        The contents of a compensator file; `Compensator.load` and `fit` return a compensator.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> runs = [sd.simulate("jig_borer", name, every_s=60.0, noise_seed=1)
    ...         for name in ("training_down", "training_random")]
    >>> compensator = sd.fit(runs, model="mlr", machine="jig_borer")
    >>> offsets = compensator.predict(runs[0])
    >>> list(offsets.columns)[:5]
    ['time_s', 'dX_um', 'dY_um', 'dZ_um', 'dX_uncertainty_um']
    >>> sd.Compensator.load(compensator.save("c.json")).name
    'mlr_compensator'
    """

    model: Model

    @classmethod
    def load(cls, path: str | Path) -> Compensator:
        """Read a compensator file, or the one in a compensator FMU.

        Parameters
        ----------
        path : str or path

        Returns
        -------
        Compensator

        Raises
        ------
        ModelFileError
            If the file cannot be used.
        """
        return cls(model_of(Path(path)) if Path(path).suffix == ".fmu" else load_model(path))

    @property
    def name(self) -> str:
        """Its name."""
        return self.model.name

    @property
    def sensors(self) -> list[str]:
        """The thermometers that it takes as inputs, in order."""
        return [sensor.name for sensor in self.model.sensors]

    @property
    def used(self) -> list[str]:
        """The thermometers that its error model uses."""
        return [self.model.sensors[index].name for index in self.model.chosen]

    @property
    def figures(self) -> pd.DataFrame:
        """RMSE [um] of each axis: uncompensated, training runs, left-out runs, promised.

        ``like`` leaves out runs that resemble the rest, ``unlike`` whole conditions; NaN if the
        file states none. All are remaining errors of the compensator as installed.
        """
        given = self.model.provenance["figures"]
        unseen = given.get("unseen") or {}
        rows = {
            axis: {
                "no_model": row["no_model"],
                "training": row["model"],
                **{
                    kind: unseen.get(kind, {}).get(axis, {}).get("model", math.nan)
                    for kind in ("like", "unlike", "promised")
                },
            }
            for axis, row in given.get("training", {}).items()
        }
        return pd.DataFrame.from_dict(rows, orient="index")

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the compensator file.

        Parameters
        ----------
        path : str or path
        force : bool
            Whether whatever is in the way may be replaced.

        Returns
        -------
        Path
            The path given.

        Raises
        ------
        BadInput
            If the path exists, is not a compensator file, and *force* is not given.
        """
        with guarding("fit", (), force):
            check_output(Path(path), COMPENSATOR_FILE)
            return write_atomically(path, compensator_text(self.model.table))

    def predict(self, run: RunLike, *, tool_length_mm: float | None = None) -> pd.DataFrame:
        """Return the offsets that it gives for every row of a run.

        Parameters
        ----------
        run : Run, DataFrame or path
            With the thermometers that the compensator uses, and ``speed_rpm`` if available.
        tool_length_mm : float, optional
            Tool length of a five-point rig [mm]; by default 100, or the nearest allowed length.

        Returns
        -------
        DataFrame
            ``time_s`` [s], ``dX_um`` ... and the half-widths of their intervals,
            ``dX_uncertainty_um`` ... [um] (-1: not known), ``valid_1`` and ``status_1``.

        Raises
        ------
        BadInput
            If the run lacks a thermometer that the compensator uses.
        """
        recorded = as_run(run)
        readings, speed = inputs_of(self.model, recorded)
        inputs = zip(recorded.time_s, readings, speed, repeat(None))
        sent = [
            (*out[:3], *out[6:9], float(out.valid), float(out.status))
            for out in answers(self.model, inputs, self.model.limits.judged_tool(tool_length_mm))
        ]
        offsets = [f"d{axis}{what}_um" for what in ("", "_uncertainty") for axis in "XYZ"]
        names = [*offsets, "valid_1", "status_1"]
        predicted = pd.DataFrame(sent, columns=names)
        predicted.insert(0, "time_s", recorded.time_s)
        return predicted

    def __repr__(self) -> str:
        """Return a summary in one line."""
        used, runs = len(self.used), len(self.model.provenance["runs"])
        return f"<Compensator {self.name}: {used} temperatures, {runs} runs>"

    def judge(
        self,
        run: RunLike,
        *,
        machine: MachineLike | None = None,
        tool_length_mm: float | None = None,
    ) -> pd.DataFrame:
        """Return the drift of a run, the offsets, and the error that would have remained.

        Parameters
        ----------
        run : Run, DataFrame or path
            With the displacements that the compensator was fitted to.
        machine : Machine, path or name, optional
            Machine whose five-point rig names the displacement sensors (default: as in training).
        tool_length_mm : float, optional
            Tool length at which a five-point rig's drift is evaluated [mm]; as `predict`.

        Returns
        -------
        DataFrame
            ``drift_X_um``, ``dX_um``, ``error_X_um``, ``dX_uncertainty_um`` and so on for each
            measured axis.
        """
        recorded = as_run(run)
        warn_of_doubts([recorded])
        meant = _rig_of(self.model, machine)
        length = self.model.limits.judged_tool(tool_length_mm)
        drift = measured_drift(recorded, meant, length, self.model.input_form)
        sent = self.predict(recorded, tool_length_mm=length)
        axes = [axis for axis in "XYZ" if f"drift_{axis}_um" in drift]
        drift = drift[[f"drift_{axis}_um" for axis in axes]]
        offsets = [sent[f"d{axis}_um"].to_numpy(float) for axis in axes]
        errors = error_left(drift, offsets, self.model.input_form)
        columns: dict[str, Any] = {"time_s": recorded.time_s}
        for axis in axes:
            columns[f"drift_{axis}_um"] = drift[f"drift_{axis}_um"]
            columns[f"d{axis}_um"] = sent[f"d{axis}_um"]
            columns[f"error_{axis}_um"] = errors[f"drift_{axis}_um"]
            columns[f"d{axis}_uncertainty_um"] = sent[f"d{axis}_uncertainty_um"]
        judged = pd.DataFrame(columns)
        warn_of_drift(recorded, judged)
        return judged

    def plot(
        self,
        run: RunLike,
        *,
        machine: MachineLike | None = None,
        tool_length_mm: float | None = None,
    ) -> Figure:
        """Return a figure of a run's drift and of the error that would remain.

        Parameters
        ----------
        run : Run, DataFrame or path
        machine : Machine, path or name, optional
        tool_length_mm : float, optional
            As `judge` takes them [mm].
        """
        recorded = as_run(run)
        judged = self.judge(recorded, machine=machine, tool_length_mm=tool_length_mm)
        return plot_judged(judged, recorded.name)

    def monitor(
        self,
        runs: RunLike | Sequence[RunLike],
        *,
        machine: MachineLike | None = None,
        on_run: Callable[[Run], object] = lambda run: None,
    ) -> Report:
        """Return whether the compensator still fits, from logs of the machine.

        Parameters
        ----------
        runs : Run, DataFrame or path, or several
            Each from its start; drift measured in all rows, some or none.
        machine : Machine, path or name, optional
            Machine whose rig defines the displacements (default: as in training).
        on_run : callable
            Called with each run that is done.

        Returns
        -------
        Report
            ``verdict``, ``summary``, ``advice``, ``runs``, ``gains``, ``inside`` and ``notes``.

        Raises
        ------
        BadInput
            If a run lacks a thermometer that the compensator uses.
        """
        rig = None if machine is None else _rig_of(self.model, machine)
        return watch(self.model, as_runs(runs), rig, on_run=on_run)

    def update(
        self, runs: RunLike | Sequence[RunLike], *, created: str | None = None
    ) -> Compensator:
        """Return the compensator updated with new runs; the training runs are not needed.

        Parameters
        ----------
        runs : Run, DataFrame or path, or several
            New runs.
        created : str, optional
            Date for the file (YYYY-MM-DD).

        Raises
        ------
        BadInput
            If a run is already in the compensator, or lacks a column.

        Examples
        --------
        >>> import spindle_drift as sd
        >>> names = ["training_down", "training_random", "training_stops", "step_speed"]
        >>> runs = [sd.simulate("jig_borer", name, every_s=60.0, noise_seed=1) for name in names]
        >>> old = sd.fit(runs[:3], model="mlr", machine="jig_borer")
        >>> new = old.update(runs[3])
        >>> [run["name"] for run in new.model.provenance["runs"]] == names
        True
        """
        table, _ = update_compensator(self.model, as_runs(runs), created=created)
        return Compensator(parse_model(compensator_text(table), self.name))


@refusing
def fit(
    runs: RunLike | Sequence[RunLike],
    model: str | None = None,
    *,
    machine: MachineLike | None = None,
    study: str | None = None,
    **options: Any,
) -> Compensator:
    """Fit a compensator to runs.

    Parameters
    ----------
    runs : Run, DataFrame or path, or several
        The training runs.
    model : str, optional
        Error model, the mean function of the Gaussian (default: gaussian, no mean function).
    machine : Machine, path or name, optional
        Machine that defines the sensors of the runs. Without it the five-point rig of `jig_borer`
        is used if the runs have its columns; otherwise the axis is taken from each displacement
        column's name.
    study : {"GA", "TS", "VAC"}, optional
        Do as that study does: points, their choice, model, its options, geometry. Other arguments
        override it.
    **options
        Options of `fmu_compensator.fit.fitting.fit_compensator` (``points``, ``input_form``,
        ``name``, ``title``, ``tool_length_mm``, ...) and of the error model.

    Returns
    -------
    Compensator

    Raises
    ------
    BadInput
        If the data or the options cannot be used.

    Examples
    --------
    >>> import spindle_drift as sd
    >>> names = ["training_down", "training_random", "training_stops"]
    >>> runs = [sd.simulate("jig_borer", name, every_s=60.0, noise_seed=1) for name in names]
    >>> compensator = sd.fit(runs, model="mlr", machine="jig_borer")
    >>> bool((compensator.figures["like"] < compensator.figures["no_model"]).all())
    True
    """
    refuse_options(fit_compensator, options, "fit", rest=True)
    refuse_options(survey, options.get("grey") or {}, "fit, grey")
    recorded = as_runs(runs)
    rig, sensors = _rig(recorded[0], machine)
    as_usual: dict[str, Any] = {"sensors": sensors, "grey": usual_choice()}
    if study is not None:
        given = preset(study, recorded, options.get("points"))
        as_usual |= {"points": given.points, "grey": dict(given.grey)}
        if isinstance(rig, FivePointRig):
            as_usual["geometry_form"] = given.geometry_form
        model = model or given.model
        as_usual |= given.models.get(model, {})
    table = fit_compensator(recorded, rig, model, **(as_usual | options))
    return Compensator(parse_model(compensator_text(table), table["name"]))


def _rig_of(model: Model, machine: MachineLike | None) -> Rig:
    from spindle_drift.machines import as_machine

    return rig_of_model(model, None if machine is None else as_machine(machine).model)


def _rig(run: Run, machine: MachineLike | None) -> tuple[Rig, list[str] | None]:
    from spindle_drift.machines import as_machine

    if machine is None:
        return default_rig(run, read_machine(USUAL_MACHINE).rig), None
    given = as_machine(machine)
    sensors = [sensor.name for sensor in given.model.sensors if sensor.unit == "degC"]
    return rig_from_table(given.model.rig, str(given.source)), sensors
