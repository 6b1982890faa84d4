"""The gap finder's answer as data: the content of ``gap.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from gap_finder.advice import MOST_LINES, advice
from gap_finder.calibrate import ParameterEstimate
from gap_finder.candidates import Candidate, beyond_usual_range
from gap_finder.comparison import GapComparison
from gap_finder.data_faults import DataFault
from gap_finder.find import ADEQUATE, Judged
from gap_finder.forward_backward import MARGIN, Hypothesis, units_of
from gap_finder.hypotheses import AddedChange
from gap_finder.keys import driver_of, law_of, place_of
from gap_finder.reference import ReferenceModel
from gap_finder.regimes import RunResiduals, places
from gap_finder.score import Fit, Units
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

MACHINE_BEFORE, MACHINE_AFTER = "machine_before.toml", "machine_after.toml"


def report_of(
    judged: Judged,
    faults: Sequence[DataFault] = (),
    cosimulation: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the content of ``gap.json``.

    Parameters
    ----------
    judged : Judged
        The result, judged on the held-out runs.
    faults : sequence of DataFault
        Data left out of the runs.
    cosimulation : mapping, optional
        The gap of the plant FMUs on the held-out runs.
    """
    result, reference = judged.result, judged.reference
    units = units_of(result.search.nothing, [result.search.best])
    steps = result.search.steps
    entries = [_entry(judged, place) for place in range(len(result.keys))]
    sets: list[list[str]] = [entry["one_of"] for entry in entries if len(entry["one_of"]) > 1]
    several = sets[0] if sets else []
    table = {
        "verdict": judged.verdict,
        "in_doubt": bool(judged.doubt),
        "effects": entries,
        "one_of": list(dict.fromkeys(name_of(key) for key in several or result.keys[:1])),
        "separate_by": _separated(several),
        "runners_up": _runners_up(judged),
        "silent": list(result.search.silent),
        "look_at": look_at(result.after, judged.used.after),
        "where": [asdict(place) for place in places(judged.used.before)],
        "gap": {
            "calibration": judged.used.gap_against(reference.used),
            "holdout": judged.unseen.gap_against(reference.unseen),
        },
        "channels": _channels(judged.unseen, reference),
        "remaining": {
            "is_adequate": judged.is_adequate,
            "left_per_run_and_channel": result.after.left_each,
            "numbers_off": float(np.sqrt(units.numbers)),
            "limit": ADEQUATE,
            "share": reference.share,
            "where": [asdict(predicted) for predicted in reference.places()],
            "predicted_by": [asdict(predicted) for predicted in reference.sources()],
        },
        "machine": MACHINE_AFTER,
        "data_faults": [asdict(fault) for fault in faults],
        "evidence": {
            "share_explained": result.explained,
            "doubt": judged.doubt,
            "fall": steps[0].fall if steps else 0.0,
        },
    }
    return table if cosimulation is None else table | {"cosimulation": dict(cosimulation)}


def look_at(fit: Fit, left: Sequence[RunResiduals]) -> list[str]:
    """Return what calibration shows about the description, in lines that name a number or channel.

    Parameters
    ----------
    fit : Fit
        The calibrated machine, with what is named.
    left : sequence of RunResiduals
        On the runs used.
    """
    lines = advice(fit.machine, left, fit.calibration.parameters)
    kinds = ("odd_run", "far_from_usual", "worse_than_no_model", "not_moved")
    return [line.text for kind in kinds for line in lines if line.kind == kind][:MOST_LINES]


def _channels(unseen: GapComparison, reference: ReferenceModel) -> dict[str, dict[str, Any]]:
    """Return the table of channels, with the best predictors of each one's residual."""
    table = unseen.channels_against(reference.unseen)
    for name, entry in table.items():
        entry["predicted_by"] = [asdict(source) for source in reference.sources(name)]
    return table


def _runners_up(judged: Judged) -> list[dict[str, Any]]:
    """Return what was fully scored in the first step and not named, the best first.

    Their probabilities are relative to the answer and to "nothing".
    """
    search = judged.result.search
    if not search.steps:
        return []
    others = [one for one in search.steps[0].tried if one.keys[-1] not in search.best.keys]
    # Where nothing is named, the best is "nothing", which counts once.
    answers = {one.keys: one for one in (search.nothing, search.best)}
    together = [*others, *answers.values()]
    odds = _odds(together, units_of(search.nothing, together))[: len(others)]
    ranked = sorted(zip(odds.tolist(), others, strict=True), key=lambda pair: -pair[0])
    told = [{**named(one.keys[-1], one.fit.machine), "probability": p} for p, one in ranked]
    return told[:MOST_LINES]


def _odds(hypotheses: Sequence[Hypothesis], units: Units) -> FloatArray:
    """Return the probability of each hypothesis, if one of them holds [1]."""
    scores = np.array([hypothesis.score(units) for hypothesis in hypotheses])
    odds = np.exp(-(scores - scores.min()) / 2.0)
    return np.asarray(odds / odds.sum())


def _separated(keys: Sequence[str]) -> str:
    """Return in plain words which further run or sensor would tell a set apart; empty if none."""
    if not keys:
        return ""
    names = {name_of(key) for key in keys}
    if names & {"sensor_offset", "sensor_drift", "sensor_lag", "sensor_place"}:
        return "a second thermometer beside the one that is in question"
    if names & {"moves_axis", "fixture_warming", "column_bending", "slow_structure"}:
        return (
            "a thermometer on each part in question that has none, and a long stand in which the "
            "hall changes and the spindle does not turn"
        )
    if all(name in catalogue() for name in names):
        return "runs at other speeds, each held until the temperatures are steady, and a long stop"
    return "a thermometer on each part in question that has none"


def named(key: str, machine: Machine) -> dict[str, Any]:
    """Return an effect's name, and its channel, driver or place if it has one.

    Parameters
    ----------
    key : str
    machine : Machine
        With it.
    """
    name, _, channel = key.partition(":")
    if name not in catalogue():
        return {"name": name, "place": place_of(key)}
    driver = driver_of(machine, key)[0]
    if driver:
        return {"name": name, "driver": driver}
    return {"name": name, "channel": channel} if channel else {"name": name}


def _entry(judged: Judged, place: int) -> dict[str, Any]:
    """Return the entry of one addition in ``gap.json``."""
    result = judged.result
    best, machine = result.search.best, result.after.machine
    key, added = best.keys[place], best.additions[place]
    others = list(
        dict.fromkeys(_in_place(rival, best, place) for rival in result.search.rivals[place])
    )
    entry: dict[str, Any] = {
        **named(key, machine),
        "one_of": [key, *others],
        "rivals": [named(other, machine) for other in others],
        "larger_than_usual": [],
        "probability": _probability(judged, place),
        "evidence": _evidence(judged),
    }
    estimates = {estimate.name: estimate for estimate in result.after.calibration.parameters}
    if isinstance(added, AddedChange):
        change = added.change
        entry["title"] = change.title
        same = [other for other in others if name_of(other) == change.name]
        entry["other_places"] = [place_of(other) for other in same]
        entry["or_else"] = [named(other, machine) for other in others if other not in same]
        numbers = change.parameters()
        entry["parameters"] = {
            n: change.shown(_number(estimates[full]))
            for n, full in numbers.items()
            if full in estimates
        }
        return entry | change.details(machine)
    effect = catalogue()[name_of(key)]
    entry["title"] = effect.title
    if "driver" in entry:
        same = [other for other in others if law_of(other) == law_of(key)]
        words = [driver_of(machine, other)[1] for other in (key, *same)]
        entry["driver_in_words"] = " or ".join(words)
    since = [run.run.name for run in result.observed if key not in run.absent]
    if len(since) < len(result.observed):
        entry["runs"] = since
    prefix = f"effects.{key}."
    entry["parameters"] = {
        name.removeprefix(prefix): _number(estimate)
        for name, estimate in estimates.items()
        if name.startswith(prefix)
    }
    # What was tried, but cannot be calibrated.
    settings = effect.given if effect.tried else ()
    if isinstance(added, Candidate) and added.is_switched:
        settings = effect.switched
    if settings:
        table = machine.effects[key]
        entry["set_at"] = {
            name: {"value": table[name].value, "unit": table[name].unit} for name in settings
        }
    runs = [*judged.used.after, *judged.unseen.after]
    if behind := {r.observed.run.name: r.behind[key] for r in runs if key in r.behind}:
        entry["behind_at_start_K"] = behind
    entry["larger_than_usual"] = list(beyond_usual_range(machine, key))
    return entry


def _in_place(hypothesis: Hypothesis, best: Hypothesis, place: int) -> str:
    """Return what a hypothesis has in place of one addition of the best."""
    rest = [key for i, key in enumerate(best.keys) if i != place]
    return next((key for key in hypothesis.keys if key not in rest), hypothesis.keys[-1])


def _probability(judged: Judged, place: int) -> float:
    """Return the probability of an addition relative to its rivals [1]."""
    search = judged.result.search
    return float(_odds((search.best, *search.rivals[place]), search.steps[-1].units)[0])


def _number(estimate: ParameterEstimate) -> dict[str, Any]:
    return {name: getattr(estimate, name) for name in ("value", "low", "high", "unit")}


def _evidence(judged: Judged) -> str:
    result = judged.result
    step = result.search.steps[0]
    together = "all names together explain" if len(result.keys) > 1 else "it explains"
    units = units_of(result.search.nothing, [result.search.best])
    before, after = result.before, result.after
    eased = (before.numbers_moved - after.numbers_moved) / units.numbers
    gained = float(np.sum((before.left - after.left) / units.channels))
    mostly = ", mostly because the file's numbers then need to move less" if eased > gained else ""
    return (
        f"{together} {max(result.explained, 0.0):.0%} of the squared error on runs predicted from "
        f"the others; the score falls by {step.fall:.0f} ({MARGIN:.0f} needed){mostly}"
    )
