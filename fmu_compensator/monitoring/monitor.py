"""Checks from logs whether a compensator still fits its machine.

Three questions are answered by comparison with runs left out of training. Do the thermometers agree
with each other as before? Are the conditions those of training? If the log has measured drift, is
the remaining error within what was promised? Without measured drift only the first two can be
answered, and the verdict says so.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import nan

import numpy as np
from scipy.special import bdtrc

from fmu_compensator.driving import Driven, drive, late_lines, learnt_as
from fmu_compensator.fit.data import first_of, refuse_repeated
from fmu_compensator.fit.run_conditions import Condition, conditions_of
from fmu_compensator.leaps import leaps_of
from fmu_compensator.monitoring.drift import AxisError, Gain, axis_errors, gain_of, misses_of
from fmu_compensator.monitoring.sensors import WORTH_SHARE, Agreement, Astray, swap_lines
from fmu_compensator.runtime.compensator import HOLDING, SPARED, UNTRAINED
from fmu_compensator.runtime.modelfile import Model
from fmu_compensator.signs import opposite_axes, sign_lines
from measurement.doubts import doubt_lines
from measurement.faults import GROSS, LEVELS, Fault, cleaned, find_faults
from measurement.faults.series import FEWEST_SAMPLES
from measurement.resampling import WRONG
from measurement.rig import AXES, Rig, not_in_mm, rig_from_table
from measurement.runs import Run
from measurement.warm import named_warm

TOO_SHORT = "too_short"
DOUBTFUL = "doubtful"
FITS, LEARNT, SENSOR, CHANGED = "fits", "learnt", "sensor", "changed"
OUTSIDE, UNUSUAL, NOT_MEASURED = "outside", "unusual_runs", "not_measured"
VERDICTS = {
    DOUBTFUL: "a unit, a clock, a sign or a place in these runs may be wrong",
    CHANGED: "the machine no longer drifts as it did in training",
    OUTSIDE: "new conditions: the runs are outside training",
    SENSOR: "a thermometer is broken, or disagrees with all others",
    UNUSUAL: "a few runs drifted unlike training; this may be chance",
    NOT_MEASURED: "temperatures are as in training; the drift was not measured",
    FITS: "still fits",
    LEARNT: "no verdict: the compensator was trained on these runs",
    TOO_SHORT: "no verdict: the logs are too short",
}
"""Verdicts, the most urgent first."""
ADVICE = {
    DOUBTFUL: "correct what is doubtful, or make sure that it is right, before anything else",
    SENSOR: "check that thermometer; if it reads correctly, its surroundings have changed: measure "
    "the drift and update the compensator with these runs",
    CHANGED: "find out what changed in the machine, then update the compensator with these runs",
    OUTSIDE: "check the thermometers named and what cools them, then measure the drift in these "
    "conditions and update the compensator with the runs",
    UNUSUAL: "measure more runs to tell an exception from a change",
    NOT_MEASURED: "measure the drift in one run: temperatures do not show how the machine expands",
    FITS: "nothing to do",
    LEARNT: "log later runs",
    TOO_SHORT: "log whole runs, starting when the machine starts",
}
SLIPPED = "find out what slipped: a displacement sensor, or a joint of the machine"
"""What to do about a leap of the remaining drift."""
MORE = "more than promised remains"
WORSE = "the offsets do not help"
FEW = "the interval holds less than it promises"
OUTSIDE_SHARE = 0.25
"""A run with at least this share of samples with status 2 is outside training [1]: set on no
data; docs/results.md reports it."""


@dataclass(frozen=True)
class RunReport:
    """The result for one run.

    Attributes
    ----------
    run : str
    verdict : str
        One of `VERDICTS`; a single run is never `UNUSUAL` or `DOUBTFUL`.
    reasons : tuple of str
        One sentence each.
    sensor : str or None
        The thermometer to blame.
    outside : float
        Share of samples that the compensator reported as outside training [1].
    without_offsets : float
        Share of samples in which it held its offsets, ramped them to zero or sent zero [1].
    errors : tuple of AxisError
        Of the axes whose drift was measured.
    conditions : tuple of Condition
        Conditions of the run, compared with those of training.
    leaps : dict of str to str
        By axis, a leap of the remaining drift that no switch of the machine explains, in words.
    but : dict of str to list of str
        What is no good news, whatever the verdict, and in which axes.
    """

    run: str
    verdict: str
    reasons: tuple[str, ...]
    sensor: str | None
    outside: float
    without_offsets: float
    errors: tuple[AxisError, ...]
    conditions: tuple[Condition, ...]
    leaps: dict[str, str] = field(default_factory=dict)
    but: dict[str, list[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Report:
    """The result of `monitor`.

    Attributes
    ----------
    verdict : str
        One of `VERDICTS`.
    summary, advice : str
        The verdict in words, and what to do.
    runs : tuple of RunReport
        In the order given.
    gains : tuple of Gain
        Of the axes whose drift has changed.
    promised : float
        Share of samples that the interval should contain [1]; NaN without one.
    inside : dict of str to float
        Share that it contains, by axis: mean over later runs with good thermometers [1].
    notes : tuple of str
        What to know about the runs, and what could not be checked.
    """

    verdict: str
    summary: str
    advice: str
    runs: tuple[RunReport, ...]
    gains: tuple[Gain, ...] = ()
    promised: float = nan
    inside: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = field(default=())


def monitor(
    model: Model,
    runs: Sequence[Run],
    rig: Rig | None = None,
    *,
    on_run: Callable[[Run], object] = lambda run: None,
) -> Report:
    """Check whether a compensator still fits its machine.

    Parameters
    ----------
    model : Model
        The compensator.
    runs : sequence of Run
        Logs of whole runs, each from its start, with the thermometers that it uses. Drift may be
        measured in all rows, in some (probes), or not at all.
    rig : Rig, optional
        Meaning of the displacement columns; by default the rig stored in the file.
    on_run : callable
        Called with each run when it is done.

    Raises
    ------
    BadInput
        If a run is given twice, or lacks a thermometer that the compensator uses.
    """
    refuse_repeated(runs)
    used = [model.sensors[index].name for index in model.chosen]
    doubted, notes = doubt_lines(runs), []
    if warm := named_warm(runs):
        notes.append(
            f"the machine was warm when these began: {warm}; their errors do not mean that the "
            "compensator no longer fits"
        )
    learnt = [learnt_as(model, run) is not None for run in runs]
    if known := [run.name for run, was in zip(runs, learnt, strict=True) if was]:
        notes.append(
            f"the compensator was trained on these: {', '.join(known)}; their errors say nothing "
            "about later runs"
        )
    if rig is None and "rig" in model.provenance:
        rig = rig_from_table(model.provenance["rig"], f"{model.source}: provenance.rig")
    notes += [*_in_mm(runs, rig), *late_lines(model, runs, rig)]
    figures = model.provenance["figures"]
    if not (figures.get("unseen") or {}).get("by_run"):
        notes.append(
            "the file does not say how much runs left out of training differed: an error counts as "
            "too large if its root mean square exceeds the promised half width"
        )
    length = model.limits.judged_tool()
    agreement, misses = Agreement(model), misses_of(figures)
    faults = find_faults(runs)
    promised = model.new_gaussian().coverage
    reports, opposite, swapped = [], [], []
    for place, run in enumerate(runs):
        left = cleaned([run], find_faults([run]), GROSS)[0]  # independent of the other runs
        driven = drive(model, run, left, rig, length)
        here = [fault for fault in faults if fault.place == place]
        pair = agreement.swapped(left)
        swapped.append((run.name, pair))
        report = _run_report(
            run,
            driven,
            _worth_saying(here, run, used, model.input_form),
            None if pair else agreement.of(left),
            conditions_of(run, used, figures.get("conditions") or ()),
            axis_errors(driven, misses, promised),
            [sensor.name for sensor in model.sensors],
            leaps_of(run, driven),
        )
        if report.verdict == FITS and learnt[place]:
            report = replace(report, verdict=LEARNT, but={})
        reports.append(report)
        opposite.append((run.name, opposite_axes(driven.drift, driven.error)))
        on_run(run)
    doubted += [*sign_lines(opposite), *swap_lines(swapped)]
    return replace(
        _report(reports, doubted=bool(doubted)),
        promised=promised,
        inside=_inside(reports),
        notes=(*doubted, *notes),
    )


def _in_mm(runs: Sequence[Run], rig: Rig | None) -> list[str]:
    """Return a line if runs have the rig's displacements as lengths, which are not drifts."""
    there = {name for run in runs for name in run.frame}
    named = [f"{name.removesuffix('_um')}_mm" for name in (rig.columns if rig else [])]
    lengths = [name for name in named if name in there]
    return [not_in_mm(lengths)] if lengths else []


def _worth_saying(
    faults: Sequence[Fault], run: Run, sensors: Sequence[str], input_form: str
) -> list[Fault]:
    """Return the faults of the thermometers in use that would harm the offsets."""
    columns = {f"{name}_degC" for name in sensors}
    whole = max(float(run.time_s[-1] - run.time_s[0]), 1e-9)
    harmful = [
        fault
        for fault in faults
        if fault.column in columns
        and (fault.is_gross or (input_form != "rise" and fault.kind in LEVELS))
    ]
    lasting = {
        column
        for column in columns
        if sum(fault.end_s - fault.start_s for fault in harmful if fault.column == column)
        >= WORTH_SHARE * whole
    }
    return [fault for fault in harmful if fault.column in lasting]


def _run_report(
    run: Run,
    driven: Driven,
    faults: Sequence[Fault],
    astray: Astray | None,
    conditions: Sequence[Condition],
    errors: Sequence[AxisError],
    sensors: Sequence[str],
    leaps: dict[str, str],
) -> RunReport:
    status = driven.status
    outside = float(np.mean(status == UNTRAINED))
    idle = float(np.mean(status >= HOLDING))
    reasons: list[str] = []
    sensor = None
    verdict = FITS if errors else NOT_MEASURED
    unusual = [error for error in errors if error.is_unusual]
    if unusual:
        verdict = CHANGED
        reasons += [
            f"{error.axis}: {error.left:.1f} um of {error.none:.1f} um remain, "
            f"{error.miss:.2f} times the promised half width; "
            f"up to {error.bound:.2f} is usual"
            for error in unusual
        ]
    reasons += leaps.values()
    if outside >= OUTSIDE_SHARE:
        verdict = CHANGED if unusual else OUTSIDE
        reasons.append(f"outside training in {outside:.0%} of the samples: {_last_said(driven)}")
    reasons += [f"new: {condition.text}" for condition in conditions if condition.is_new]
    without = [output for output in driven.outputs if output.status == SPARED]
    broken = [output for output in without if output.status_sensor]
    unheard = (len(without) - len(broken)) / len(driven.outputs)
    if unheard >= WORTH_SHARE:
        reasons.append(f"speed is missing in {unheard:.0%} of the samples")
    never = driven.outputs[-1] if not driven.started.any() else None
    if faults:
        verdict, sensor = SENSOR, faults[0].column.rsplit("_", 1)[0]
        reasons = [*(fault.line() for fault in faults), *reasons]
    elif never is not None or len(broken) >= WORTH_SHARE * len(driven.outputs):
        times = Counter(output.status_sensor for output in broken)
        said = never or max(broken, key=lambda output: times[output.status_sensor])
        verdict = SENSOR
        sensor = sensors[said.status_sensor - 1] if said.status_sensor else None
        reasons = [said.status_text, *reasons]
    elif astray is not None:
        verdict, sensor = SENSOR, astray.sensor
        reasons = [
            f"{sensor} is {astray.off_by_K:.1f} K away from what the others suggest; without it "
            "they agree as in training",
            *reasons,
        ]
    if verdict in (FITS, NOT_MEASURED) and (short := _too_short(run, conditions)):
        verdict, reasons = TOO_SHORT, [short, *reasons]
    return RunReport(
        run.name,
        verdict,
        tuple(reasons),
        sensor,
        outside,
        idle,
        tuple(errors),
        tuple(conditions),
        leaps,
        {} if verdict in (SENSOR, TOO_SHORT) else _but(errors),
    )


def _too_short(run: Run, conditions: Sequence[Condition]) -> str:
    """Return why a log is too short for a verdict; empty if it is not."""
    rows, seconds = len(run.frame), float(run.time_s[-1] - run.time_s[0])
    trained = next(
        (condition.low * 3600.0 for condition in conditions if condition.unit == "h"), 0.0
    )
    if rows >= FEWEST_SAMPLES and seconds >= WORTH_SHARE * trained:
        return ""
    return f"{rows} rows in {seconds / 60.0:.1f} min (training: {trained / 60.0:.0f} min or more)"


def _last_said(driven: Driven) -> str:
    """Return the last status text about inputs outside training."""
    for output in reversed(driven.outputs):
        if output.status == UNTRAINED:
            return output.status_text
    return "taken together, temperatures are further from training than in any training run"


def _inside(runs: Sequence[RunReport]) -> dict[str, float]:
    judged = [run for run in runs if run.verdict not in (SENSOR, LEARNT)]
    errors = [error for run in judged for error in run.errors]
    return {
        axis: float(np.mean([error.inside for error in errors if error.axis == axis]))
        for axis in dict.fromkeys(error.axis for error in errors)
    }


def _verdict(runs: Sequence[RunReport]) -> str:
    """Return the verdict on a log if nothing in it is doubted."""
    given = [run.verdict for run in runs]
    verdict = next(name for name in VERDICTS if name in given)
    if verdict == CHANGED:
        changed = [run for run in runs if run.verdict == CHANGED]
        judged = sum(bool(run.errors) for run in runs)
        if min(_chance(len(changed), judged), _chance_of_worst(changed, judged)) > WRONG:
            outside = any(run.outside >= OUTSIDE_SHARE for run in runs)
            return OUTSIDE if outside else UNUSUAL
    return FITS if verdict == NOT_MEASURED and FITS in given else verdict


def _gains(runs: Sequence[RunReport]) -> tuple[Gain, ...]:
    """Return the gains of the axes whose drift has changed."""
    changed = [run for run in runs if run.verdict == CHANGED]
    axes = sorted({error.axis for run in changed for error in run.errors if error.is_unusual})
    gains = (
        gain_of(axis, [e for run in runs for e in run.errors if e.axis == axis]) for axis in axes
    )
    return tuple(gain for gain in gains if gain is not None)


def _report(runs: Sequence[RunReport], *, doubted: bool) -> Report:
    verdict = _verdict(runs)
    gains = _gains(runs) if verdict == CHANGED else ()
    # A wrong unit looks like a change; in new conditions a prediction may itself be wrong.
    if doubted and verdict in (CHANGED, UNUSUAL):
        verdict = DOUBTFUL
    sensors = list(
        dict.fromkeys(run.sensor for run in runs if run.verdict == SENSOR and run.sensor)
    )
    summary, advice = VERDICTS[verdict], ADVICE[verdict]
    but = _all_but(runs)
    if verdict == FITS and but:
        advice = ADVICE[UNUSUAL]
    if leapt := [f"{run.run} ({axis})" for run in runs for axis in run.leaps]:
        summary = f"{summary}; the drift leaps in {first_of(leapt)}"
        advice = SLIPPED if verdict == FITS else f"{SLIPPED}; {advice}"
    if doubted:  # nothing is learnt from such runs
        advice = f"check that thermometer; {ADVICE[DOUBTFUL]}" if sensors else ADVICE[DOUBTFUL]
    if sensors:
        named = f"{', '.join(sensors)}: broken, or not what the others explain"
        summary = named if verdict == SENSOR else f"{summary}; {named}"
    summary = said_with(verdict, summary, but)
    return Report(verdict, summary, advice, tuple(runs), gains)


def _but(errors: Sequence[AxisError]) -> dict[str, list[str]]:
    """Return what is no good news in a run, and in which axes.

    Runs left out of training were no better, so it shows no change of the machine.
    """
    found = {
        MORE: [e.axis for e in errors if e.miss > 1.0 and not e.is_unusual],
        WORSE: [e.axis for e in errors if e.left > e.none],
        FEW: [e.axis for e in errors if e.miss <= 1.0 and e.few < WRONG],
    }
    return {what: axes for what, axes in found.items() if axes}


def _all_but(runs: Sequence[RunReport]) -> list[str]:
    """Return what is no good news in a log, and in which runs."""
    found = {
        what: [f"{run.run} ({axis})" for run in runs for axis in run.but.get(what, ())]
        for what in (MORE, WORSE, FEW)
    }
    return [f"{what} in {first_of(where)}" for what, where in found.items() if where]


def said_with(verdict: str, text: str, but: Sequence[str]) -> str:
    """Return what a verdict says together with what is no good news."""
    if not but:
        return text
    return f"{text}{', but ' if verdict == FITS else '; '}{'; '.join(but)}"


def _chance_of_worst(unusual: Sequence[RunReport], runs: int) -> float:
    """Return the probability that the worst of *runs* runs misses this much by chance [1]."""
    least = min(error.chance for run in unusual for error in run.errors if error.is_unusual)
    return 1.0 - (1.0 - min(len(AXES) * least, 1.0)) ** runs


def _chance(unusual: int, runs: int) -> float:
    """Return the probability that *unusual* of *runs* runs, or more, are unusual by chance [1]."""
    # Up to three axes are checked in each run.
    return float(bdtrc(unusual - 1, runs, len(AXES) * WRONG))
