"""What probe cycles bring: error against probes a run, on runs that a compensator never saw.

    python -m benchmarks.probing DATA [--model gaussian] [--write]

DATA holds ``lathe`` and ``electric_spindle``. A compensator is fitted to some runs and driven
through the others; at a probe it is given the run's own measured drift, with 0.5 um of noise.
Beside it stand no compensation, the compensator without probes, and the last probe held, without
any model. Nothing is fitted or chosen on the judged runs; a limit comes from the uncertainty in the
*training* runs.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.results_page import as_table, tell
from benchmarks.trust.questions import electric_pieces, lathe_runs
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.compensator import WAITING, RunningCompensator
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.drift import measured_drift
from measurement.faults import GROSS, cleaned, find_faults
from measurement.rig import Rig, rig_from_table
from measurement.runs import Run
from scenarios.probing import ProbedRun, Probing

STEP_S = 60.0
"""Rows closer together are left out: a compensator's step is not what is judged here [s]."""
COUNTS = (1, 2, 4, 8)
WHEN = (0.65,)
"""Limits, over the mean half width in the training runs [1]."""


@dataclass(frozen=True)
class Split:
    """Runs to learn from and runs to judge on."""

    name: str
    train: Sequence[Run]
    judged: Sequence[Run]
    rig: Rig


@dataclass(frozen=True)
class Line:
    """What a way to probe comes to: mean number of probes, and per axis medians over runs [um]."""

    way: str
    probes: float
    error: dict[str, float]
    held: dict[str, float]
    coverage: dict[str, float]


def splits(data: Path) -> Iterator[Split]:
    """Yield the splits of the data sets that are there."""
    lathe = lathe_runs(data / "lathe")
    if lathe:
        axes = {"disp_x": {"axis": "X"}, "disp_z": {"axis": "Z"}}
        rig = rig_from_table({"kind": "direct", "axes": axes}, "rig")
        early = [run for run in lathe if run.name < "202008"]
        late = [run for run in lathe if run.name >= "202008"]
        yield Split("lathe, August to October, from June and July", early, late, rig)
        yield Split("lathe, June and July, from August to October", late, early, rig)
    record = data / "electric_spindle" / "first_3000_min.csv"
    if record.is_file():
        pieces, rig = electric_pieces(record)
        half = len(pieces) // 2
        yield Split(
            "electric spindle, second half, from the first", pieces[:half], pieces[half:], rig
        )
        yield Split(
            "electric spindle, first half, from the second", pieces[half:], pieces[:half], rig
        )


def judge(split: Split, model: Model) -> list[Line]:
    """Return a line for every way to probe."""
    judged, train = (_judgeable(runs) for runs in (split.judged, split.train))
    plain = Probing(most=0)
    judged = [run for run in judged if driven(run, split.rig, model, plain)["started"]]
    drift = [_drift(run, split.rig, model) for run in judged]
    nothing = {axis: float(np.median([_rms(one[axis]) for one in drift])) for axis in drift[0]}
    lines = [Line("no compensation", 0.0, nothing, nothing, {})]
    lines.append(_line("no probe", plain, judged, split.rig, model))
    for count in COUNTS:
        shortest = min(float(run.time_s[-1] - run.time_s[0]) for run in judged)
        every = Probing(every_s=shortest / (count + 1), most=count)
        name = f"{count} at fixed intervals of {shortest / 60 / (count + 1):.0f} min"
        lines.append(_line(name, every, judged, split.rig, model))
    usual = np.mean([driven(run, split.rig, model, plain)["widest"] for run in train])
    for share in WHEN:
        limit = float(f"{share * usual:.2g}")
        for most in (4, None):
            name = f"when past {limit:g} um" + ("" if most is None else f", at most {most}")
            when = Probing(when_um=limit, most=most)
            lines.append(_line(name, when, judged, split.rig, model))
    return lines


def _judgeable(runs: Sequence[Run]) -> list[Run]:
    """Return runs a minute a row, their broken displacements left out."""
    found = cleaned(runs, find_faults(runs), GROSS)
    thinned = []
    for shown, whole in zip(found, runs, strict=True):
        kept, last = [], -np.inf
        for row, time in enumerate(whole.time_s):
            if time - last >= STEP_S * 0.99:
                kept.append(row)
                last = time
        temperatures = {name: whole.frame[name] for name in whole.temperatures}
        frame = shown.frame.assign(**temperatures).iloc[kept].reset_index(drop=True)
        thinned.append(Run(whole.name, frame))
    return thinned


def _drift(run: Run, rig: Rig, model: Model) -> dict[str, np.ndarray]:
    drift = measured_drift(run, rig, 0.0, model.input_form)
    return {str(name)[6]: drift[name].to_numpy() for name in drift.columns}


def driven(run: Run, rig: Rig, model: Model, probing: Probing) -> dict[str, Any]:
    """Drive a compensator through a run with probes; return errors by axis, and what was asked."""
    compensator, probed = RunningCompensator(model), ProbedRun(probing, model, run, rig, 0.0)
    readings = run.frame[[f"{sensor.name}_degC" for sensor in model.sensors]].to_numpy(float)
    speed = run.frame["speed_rpm"].to_numpy(float) if "speed_rpm" in run.frame else None
    offsets, widths = np.zeros((len(readings), 3)), np.full((len(readings), 3), -1.0)
    started = np.zeros(len(readings), dtype=bool)
    time_s = run.time_s
    for k in range(len(readings) - 1):
        measured = probed.targets[k].tolist() if probed.due(k, widths[k].tolist()) else None
        output = compensator.step(
            time_s[k],
            time_s[k + 1] - time_s[k],
            readings[k].tolist(),
            np.nan if speed is None else speed[k],
            0.0,
            measured,
        )
        offsets[k + 1], widths[k + 1] = output[:3], output[6:9]
        started[k + 1] = output.status != WAITING
    found: dict[str, Any] = {"started": bool(started.any()), "axes": {}, "widest": 0.0}
    found["probes"] = len(probed.rows)
    if not found["started"]:
        return found
    for axis, drift in _drift(run, rig, model).items():
        at = "XYZ".index(axis)
        error = np.where(started, drift + offsets[:, at], np.nan)
        known = np.isfinite(error)
        found["axes"][axis] = {
            "error": _rms(error),
            "held": _rms(np.where(started, drift - probed.held(axis), np.nan)),
            "coverage": float(np.mean(np.abs(error[known]) <= widths[known, at])),
        }
        found["widest"] = max(found["widest"], float(np.mean(widths[started, at])))
    return found


def _line(name: str, probing: Probing, runs: Sequence[Run], rig: Rig, model: Model) -> Line:
    found = [driven(run, rig, model, probing) for run in runs]
    axes = found[0]["axes"]
    error, held = (
        {axis: float(np.median([one["axes"][axis][what] for one in found])) for axis in axes}
        for what in ("error", "held")
    )
    inside = {
        axis: float(np.mean([one["axes"][axis]["coverage"] for one in found])) for axis in axes
    }
    return Line(name, float(np.mean([one["probes"] for one in found])), error, held, inside)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(values**2)))


def table_text(split: Split, kind: str, lines: Sequence[Line]) -> str:
    """Return a split's table, in Markdown."""
    axes = list(lines[0].error)
    head = ["", "probes a run"]
    head += [f"{axis}{what}" for axis in axes for what in (" [µm]", " held [µm]", " inside")]
    rows = []
    for line in lines:
        cells = [line.way, f"{line.probes:.1f}"]
        for axis in axes:
            cells.append(f"{line.error[axis]:.1f}")
            cells.append(f"{line.held[axis]:.1f}" if line.probes else "")
            cells.append(f"{100 * line.coverage[axis]:.0f} %" if line.coverage else "")
        rows.append(cells)
    title = f"### {split.name[0].upper()}{split.name[1:]}"
    count = f"`{kind}`, {len(split.train)} runs learnt from, {len(split.judged)} judged."
    return f"{title}\n\n{count}\n\n{as_table(head, rows)}\n"


def main() -> int:
    """Run the benchmark, print its tables, and put them into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--model", default="gaussian")
    parser.add_argument("--write", action="store_true", help="also write docs/results.md")
    args = parser.parse_args()
    texts = []
    for split in splits(args.data):
        # The slew limit of a control has no part in the model's error.
        limits = {"slew_um_per_s": 1000.0}
        table = fit_compensator(split.train, split.rig, args.model, limits=limits)
        model = parse_model(compensator_text(table), split.name)
        texts.append(table_text(split, args.model, judge(split, model)))
    if not texts:
        print(f"{args.data}: holds neither lathe nor electric_spindle")
        return 2
    tell("probing", "\n".join(texts), write=args.write)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
