"""The replay: a compensator FMU driven by a measured run instead of the plant.

Each row of the run is one sample: the compensator's output is compared with the drift measured in
the same row. A control calls it many times a minute, so its offsets are equally recent and nothing
is interpolated. A probe is known one second after its row, whose error is what the probe found.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from fmu_compensator.driving import held, refuse_lacking
from fmu_compensator.fit.training import GRID_S
from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from fmu_compensator.runtime.geometry import FivePoint
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.drift import error_left, measured_drift
from measurement.errors import BadInput
from measurement.faults import GROSS, STANDING, Fault, cleaned, find_faults
from measurement.rig import AXES, Rig, rig_from_table
from measurement.runs import Run
from plant_model.machine import Machine
from scenarios.fmu import Port, Slave, alone
from scenarios.fmu_file import compensator_file
from scenarios.pages.charts import Chart
from scenarios.probe_cycle import ProbeInputs
from scenarios.probing import ProbedRun, Probing
from scenarios.recording import Event, FmuFacts, facts_of, notice
from scenarios.views import before_and_after
from scenarios.wiring import PROBED, TOOL_LENGTH

LABEL = "Compensated"
LABEL_PROBED = "Compensated, with probes"
LABEL_HELD = "Last probe held"


@dataclass(frozen=True)
class Replay:
    """One run replayed.

    Attributes
    ----------
    run : Run
        The measured run.
    frame : DataFrame
        ``time_s``, the measured drift ``drift_X_um`` ..., the offsets ``dX_um`` ..., the remaining
        error ``error_X_um`` ..., the half-width of its interval ``dX_uncertainty_um`` ..., and the
        status.
    left_out : int
        Number of rows that do not count because a displacement sensor was broken.
    faults : tuple of Fault
        Faults in the run.
    events : tuple of Event
        Changes of the status.
    fmu : FmuFacts
        The compensator.
    probes : tuple of int, optional
        Rows at which a probe was taken; None if probing was not requested. With probing the frame
        also has ``unprobed_error_X_um`` ... without probes and ``held_error_X_um`` ... with the
        last probe held.
    """

    run: Run
    frame: pd.DataFrame
    left_out: int
    faults: tuple[Fault, ...]
    events: tuple[Event, ...]
    fmu: FmuFacts
    probes: tuple[int, ...] | None = None


def model_of(fmu: Path) -> Model:
    """Return the compensator file inside a compensator FMU.

    Parameters
    ----------
    fmu : Path
        In Python or in C.

    Raises
    ------
    BadInput
        If the FMU does not contain one.
    ModelFileError
        If it cannot be used.
    """
    text = compensator_file(fmu)
    if text is None:
        problem = "holds no compensator file, so nothing says what its offsets stand for"
        raise BadInput(fmu, "", problem)
    return parse_model(text, f"{fmu}: {MODEL_FILE}")


def rig_of_model(model: Model, machine: Machine | None = None) -> Rig:
    """Return the rig that measures what a compensator predicts.

    A direct geometry names its columns. A five-point geometry has distances, not sensors: their
    names and signs come from the *machine*'s rig, by default from that of the training.

    Parameters
    ----------
    model : Model
    machine : Machine, optional
        Used if both have a five-point rig.
    """
    geometry = model.table["geometry"]
    if not isinstance(model.geometry, FivePoint):
        return rig_from_table({"kind": "direct", "axes": geometry["axes"]}, model.source)
    distances = {name: geometry[name] for name in ("spacing_mm", "near_to_gauge_mm")}
    given = machine.rig if machine else {}
    named = given if given.get("kind") == "five_point" else model.provenance.get("rig", {})
    return rig_from_table({**named, "kind": "five_point", **distances}, model.source)


def replay(
    fmu: Path,
    model: Model,
    run: Run,
    rig: Rig,
    tool_length_mm: float | None = None,
    *,
    keep_frozen: bool = False,
    probing: Probing | None = None,
) -> Replay:
    """Drive a compensator FMU with a run.

    Parameters
    ----------
    fmu : Path
        The compensator.
    model : Model
        Its compensator file.
    run : Run
        Temperatures by the FMU's names, speed if available, and the rig's displacements.
    rig : Rig
        Defines the displacements.
    tool_length_mm : float, optional
        By default 100 mm, or the nearest allowed length [mm].
    keep_frozen : bool
        Count rows in which a displacement sensor was frozen or at the end of its range.
    probing : Probing, optional
        Give the compensator the run's own drift now and then, as a probe would.

    Raises
    ------
    BadInput
        If the run lacks a column of the error model or of the rig.
    FmuError
        If the FMU fails.
    """
    refuse_lacking(model, run)
    faults = find_faults([run])
    kinds = [kind for kind in GROSS if not (keep_frozen and kind in STANDING)]
    # The compensator gets all readings as they are, but is judged only by sound ones.
    left = cleaned([run], faults, kinds)[0]
    length = model.limits.judged_tool(tool_length_mm)
    drift = measured_drift(left, rig, length, model.input_form)
    out = (left.frame[rig.columns].isna() & run.frame[rig.columns].notna()).any(axis=1)
    axes = [axis for axis in AXES if f"drift_{axis}_um" in drift]

    def left_of(sent: Mapping[str, np.ndarray]) -> pd.DataFrame:
        offsets = [sent[f"d{axis}"] for axis in axes]
        return error_left(drift[[f"drift_{axis}_um" for axis in axes]], offsets, model.input_form)

    columns: dict[str, object] = {"time_s": run.time_s} | {
        str(name): drift[name] for name in drift.columns
    }
    probed = None
    if probing is not None:
        probed = ProbedRun(probing, model, left, rig, length)
        unprobed = left_of(_driven(fmu, run, length, None)[0])
        for axis in axes:
            columns[f"unprobed_error_{axis}_um"] = unprobed[f"drift_{axis}_um"]
    sent, codes, events, facts = _driven(fmu, run, length, probed)
    errors = left_of(sent)
    for axis in axes:
        columns[f"d{axis}_um"] = sent[f"d{axis}"]
        columns[f"error_{axis}_um"] = errors[f"drift_{axis}_um"]
        if probed is not None:
            columns[f"held_error_{axis}_um"] = drift[f"drift_{axis}_um"] - probed.held(axis)
        if f"d{axis}_uncertainty" in sent:
            columns[f"d{axis}_uncertainty_um"] = sent[f"d{axis}_uncertainty"]
    frame = pd.DataFrame({**columns, "status_1": codes})
    # Not before: each axis counts from its own first reading, even in a row that does not count.
    frame.loc[out, frame.filter(regex="^drift_|error_").columns] = np.nan
    rows = None if probed is None else tuple(probed.rows)
    if rows is not None:
        frame["measured_1"] = np.isin(np.arange(len(frame)), rows).astype(int)
    return Replay(run, frame, int(out.sum()), tuple(faults), tuple(events), facts, rows)


def _driven(
    fmu: Path, run: Run, length: float, probed: ProbedRun | None
) -> tuple[dict[str, np.ndarray], np.ndarray, list[Event], FmuFacts]:
    """Load the FMU and step it through the run."""
    with alone(fmu, "compensator") as (slave, _):
        return *_drive(slave, run, length, probed), facts_of(slave)


def _drive(
    slave: Slave, run: Run, length: float, probed: ProbedRun | None
) -> tuple[dict[str, np.ndarray], np.ndarray, list[Event]]:
    """Step through the run; return the outputs at each row, status codes, and events."""
    seen = Port(slave, [name for name in slave.names("input") if not name.startswith(PROBED)])
    rows = np.full((len(run.time_s), len(seen.names)), math.nan)
    for place, name in enumerate(seen.names):
        column = slave.column(name)
        if name == TOOL_LENGTH:
            rows[:, place] = length
        elif column in run.frame.columns:
            rows[:, place] = held(run.time_s, run.frame[column].to_numpy(float))
    axes = len(AXES)
    outputs = [f"d{axis}" for axis in AXES] + [f"d{axis}_uncertainty" for axis in AXES]
    sent = Port(slave, [name for name in outputs if name in slave.variables])
    codes = Port(slave, ["status", "status_sensor"], "Integer")
    probe = ProbeInputs(slave)
    table = np.zeros((len(rows), len(sent.names)))
    status = np.zeros(len(rows))
    events: list[Event] = []
    time_s = run.time_s - run.time_s[0]
    # An FMU reads its inputs at the start of a step: a row's offsets move until the next row.
    ends_s = np.append(time_s[1:], time_s[-1] + GRID_S)
    with slave.starting(float(ends_s[-1])):
        seen.values[:] = rows[0]
        seen.set()
    for k, (start_s, end_s) in enumerate(zip(time_s.tolist(), ends_s.tolist(), strict=True)):
        seen.values[:] = rows[k]
        seen.set()
        measured = None
        if k and probed is not None and probed.due(k, table[k - 1, axes:].tolist()):
            measured = probed.targets[k]
        known_s = end_s if measured is None else min(start_s + 1.0, (start_s + end_s) / 2.0)
        slave.step(start_s, known_s - start_s)
        sent.get()
        codes.get()
        table[k], status[k] = sent.values, codes.values[0]
        code, sensor = codes.values.tolist()
        notice(events, start_s, code, sensor, lambda: slave.text("status_text"))
        if measured is not None:
            probe.set(measured)
            slave.step(known_s, end_s - known_s)
            probe.set(None)
    return dict(zip(sent.names, table.T, strict=True)), status, events


def chart_of(entry: Replay, name: str) -> Chart:
    """Return the drift before and after, one panel per axis."""
    shown = [(label, frame) for _, label, frame in results_of(entry) if label != LABEL_HELD]
    # The interval is that of the compensator as driven, with probes if there were any.
    panels = before_and_after(shown[::-1], entry.frame)
    return Chart(name, f"Drift before and after compensation: {entry.run.name}", "", panels)


def results_of(entry: Replay) -> list[tuple[str, str, pd.DataFrame]]:
    """Return the lines of the table: name, label, and a frame with drift and error."""
    frame, name = entry.frame, entry.run.name
    if entry.probes is None:
        return [(name, LABEL, frame)]
    lines = []
    for what, label in (("unprobed_", LABEL), ("", LABEL_PROBED), ("held_", LABEL_HELD)):
        errors = {
            f"error_{axis}_um": frame[f"{what}error_{axis}_um"]
            for axis in AXES
            if f"error_{axis}_um" in frame
        }
        lines.append((f"{what}{name}", label, frame.assign(**errors)))
    return lines
