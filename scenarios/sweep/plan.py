"""Plans the cases of a sweep, all checked before the first one runs."""

from __future__ import annotations

import itertools
import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from measurement.errors import BadInput, refuse_other, shown
from measurement.files import sha256_of
from plant_model.drive import MOST_STEPS
from plant_model.noise import LARGEST_SEED
from scenarios.fmu_file import read_description
from scenarios.fmu_files import check_fmus, find_fmu
from scenarios.scenario import Case, Scenario, Variant, case_from, changed, read_scenario
from scenarios.sweep.names import Names, Target, check_range
from scenarios.sweep.variation import OPTION, Variation, variation

PLANT, COMPENSATOR = "plant.fmu", "compensator.fmu"


@dataclass(frozen=True)
class Request:
    """A request for a sweep.

    Attributes
    ----------
    scenario : str
        A name from ``spindle-drift list``, or a scenario file (TOML).
    vary : tuple of str
        What varies: an input, a parameter of the plant or a key of the scenario, and a,b,c or
        low..high:COUNT (a grid), low..high, low..high:log or mean+-sd (drawn for every repeat); an
        x before them multiplies the scenario's value.
    repeat : int
        Number of runs of every grid point, each with its own draws and noise.
    seed : int or None
        Seed of draws and noise (default: the scenario's).
    variants : tuple of str
        One of the scenario's variants (default: all).
    overrides : tuple of (str, object)
        Keys to set in all cases, such as duration_s=3600 or signals.speed=6000.
    """

    scenario: str
    vary: tuple[str, ...]
    repeat: int = 1
    seed: int | None = None
    variants: tuple[str, ...] = ()
    overrides: tuple[tuple[str, Any], ...] = ()


@dataclass(frozen=True)
class Job:
    """One co-simulation of a sweep.

    Attributes
    ----------
    number : int
        Its index in the sweep, from 0.
    variant : str
        The variant of the scenario.
    repeat : int
        The repeat of its grid point.
    values : dict of str to object
        The values that vary, by label.
    case : Case
        Ready to run.
    plant, compensator : str
        SHA-256 of the FMUs; the compensator's is empty if it is not enabled.
    """

    number: int
    variant: str
    repeat: int
    values: dict[str, Any]
    case: Case
    plant: str
    compensator: str


@dataclass(frozen=True)
class Plan:
    """A sweep, ready to run.

    Attributes
    ----------
    scenario : Scenario
    variations : tuple of Variation
    titles : dict of str to str
        The variants by name.
    jobs : tuple of Job
        In order of variants, then grid points, then repeats.
    fmus : dict of str to Path
        The FMUs by SHA-256.
    identity : dict
        What identifies the sweep, ready for JSON.
    """

    scenario: Scenario
    variations: tuple[Variation, ...]
    titles: dict[str, str]
    jobs: tuple[Job, ...]
    fmus: dict[str, Path]
    identity: dict[str, Any]


def plan(request: Request, fmu_dir: Path, work: Path, version: str, *, quiet: bool = False) -> Plan:
    """Return the cases of a sweep.

    Parameters
    ----------
    request : Request
    fmu_dir : Path
        Folder of FMUs named without a folder.
    work : Path
        Folder in which FMUs for this sweep only may be built; must exist while it runs.
    version : str
        Version of this program.
    quiet : bool
        Do not report on building.

    Raises
    ------
    BadInput
        For a wrong name, value or number of cases.
    """
    scenario = read_scenario(request.scenario, request.overrides)
    if not scenario.cases:
        raise BadInput(scenario.path, "replay", "cannot be swept: nothing is simulated")
    asked = [variation(text) for text in request.vary]
    seed = _seed(request, scenario)
    variants = _chosen(scenario, request.variants)
    finder = _Fmus(scenario, variants, fmu_dir, work, quiet)
    names = finder.names(asked)
    variations = tuple(itertools.chain.from_iterable(map(names.expanded, asked)))
    if not 1 <= request.repeat <= MOST_STEPS:
        raise BadInput("--repeat", "", f"{request.repeat} is not allowed: 1 to {MOST_STEPS}")
    grid = [entry.values for entry in variations if not entry.is_drawn]
    count = math.prod(map(len, grid)) * request.repeat * len(variants)
    if count > MOST_STEPS:
        raise BadInput(OPTION, "", f"{count} cases are more than {MOST_STEPS}")
    targets = {entry.label: names.target(entry.name) for entry in variations}
    _check(variations, targets, variants)
    builder = _Builder(scenario, variations, targets, seed, finder)
    jobs = [
        builder.job(number, variant, point, repeat)
        for number, (variant, point, repeat) in enumerate(
            itertools.product(variants, list(itertools.product(*grid)), range(request.repeat))
        )
    ]
    used = sorted({fmu for job in jobs for fmu in (job.plant, job.compensator) if fmu})
    identity = {
        "scenario": scenario.settings.name,
        "text": scenario.text,
        "--set": [[key, json.dumps(value, default=str)] for key, value in request.overrides],
        "--vary": list(request.vary),
        "--repeat": request.repeat,
        "--seed": seed,
        "--variant": [variant.name for variant in variants],
        "FMUs": used,
        "version": version,
    }
    titles = {variant.name: variant.title or variant.name for variant in variants}
    fmus = {key: finder.paths[key] for key in used}
    return Plan(scenario, variations, titles, tuple(jobs), fmus, identity)


def _seed(request: Request, scenario: Scenario) -> int:
    seed = scenario.settings.seed if request.seed is None else request.seed
    if not 0 <= seed <= LARGEST_SEED:
        raise BadInput("--seed", "", f"{seed} is not allowed: 0 to {LARGEST_SEED}")
    return seed


def _chosen(scenario: Scenario, wanted: Sequence[str]) -> list[Variant]:
    variants = {variant.name: variant for variant in scenario.settings.variants}
    if not variants:
        variants = {"main": Variant(name="main", title=scenario.settings.title)}
    for name in wanted:
        refuse_other("--variant", "", name, variants)
    return [variant for name, variant in variants.items() if name in wanted or not wanted]


def _check(
    variations: Sequence[Variation], targets: Mapping[str, Target], variants: Sequence[Variant]
) -> None:
    keys = [targets[entry.label].key for entry in variations]
    for entry in variations:
        target = targets[entry.label]
        if keys.count(target.key) > 1:
            raise BadInput(OPTION, entry.name, "varies twice")
        if entry.relative:
            continue
        check_range(entry, target)
        said = [variant.set.get(target.key) for variant in variants]
        if any(value != said[0] for value in said):
            names = ", ".join(variant.name for variant in variants)
            raise BadInput(
                OPTION,
                entry.name,
                f"is what the variants differ in: choose one with --variant: {names}",
            )


@dataclass(frozen=True)
class _Fmus:
    """The FMUs of all cases, each found (or built) once: SHA-256 by name, path by SHA-256."""

    scenario: Scenario
    variants: Sequence[Variant]
    fmu_dir: Path
    work: Path
    quiet: bool
    known: dict[str, str] = field(default_factory=dict)
    paths: dict[str, Path] = field(default_factory=dict)

    @property
    def near(self) -> Path:
        """The scenario's folder."""
        return self.scenario.path.resolve().parent

    def sha256(self, name: str) -> str:
        """Return the SHA-256 of the FMU that a scenario calls *name*."""
        if name not in self.known:
            # One folder each, because FMUs built for this sweep share their file name.
            work = self.work / str(len(self.known))
            work.mkdir()
            path = find_fmu(name, self.fmu_dir, self.near, work, quiet=self.quiet, native=True)
            self.known[name] = sha256_of(path)
            self.paths[self.known[name]] = path.resolve()
        return self.known[name]

    def names(self, variations: Sequence[Variation]) -> Names:
        """Return what can vary in the FMUs of the scenario, its variants and the variations."""
        named: dict[str, list[str]] = {PLANT: [], COMPENSATOR: []}
        for key, names in named.items():
            head, _, tail = key.partition(".")
            usual = getattr(getattr(self.scenario.settings, head), tail)
            tried = [variant.set.get(key, usual) for variant in self.variants]
            tried += [value for entry in variations if entry.name == key for value in entry.values]
            if key == PLANT or self.scenario.settings.compensator.enabled:
                names += dict.fromkeys(map(str, tried))
        check_fmus(named[PLANT], named[COMPENSATOR], self.fmu_dir, self.near)
        descriptions: dict[str, list[Mapping[str, Any]]] = {key: [] for key in named}
        for key, described in descriptions.items():
            for name in named[key]:
                path = self.paths[self.sha256(name)]
                variables = read_description(path).modelVariables
                described.append({variable.name: variable for variable in variables})
        return Names(descriptions[PLANT], descriptions[COMPENSATOR])


@dataclass(frozen=True)
class _Builder:
    """Makes the jobs."""

    scenario: Scenario
    variations: Sequence[Variation]
    targets: Mapping[str, Target]
    seed: int
    fmus: _Fmus

    @cached_property
    def _table(self) -> dict[str, Any]:
        """The scenario without variants, with the command line's settings."""
        table = tomllib.loads(self.scenario.text)
        for key, value in (*self.scenario.overrides, ("variants", [])):
            table = self._with(table, key, value)
        return table

    def _with(self, table: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
        return changed(table, key, value, self.scenario.path, OPTION)

    def job(self, number: int, variant: Variant, point: Sequence[Any], repeat: int) -> Job:
        """Return one job: a grid point in one of its repeats.

        Raises
        ------
        BadInput
            If its values do not make a scenario.
        """
        values: dict[str, Any] = {}
        left, table = iter(point), self._table
        for key, value in (*variant.set.items(), ("seed", _repeated(self.seed, repeat))):
            table = self._with(table, key, value)
        for entry in self.variations:
            target = self.targets[entry.label]
            usual = self._usual(entry, target, table) if entry.relative else 1.0
            if entry.is_drawn:
                low, high = _factors(target, usual) if entry.relative else (target.low, target.high)
                values[entry.label] = entry.drawn(self.seed, repeat, low, high)
            else:
                values[entry.label] = next(left)
            value = values[entry.label]
            value = _scaled(usual, value) if entry.relative else value
            table = self._with(table, target.key, value)
        case = self._case(table)
        settings = case.settings
        other = self.fmus.sha256(settings.compensator.fmu) if settings.compensator.enabled else ""
        return Job(
            number, variant.name, repeat, values, case, self.fmus.sha256(settings.plant.fmu), other
        )

    def _usual(self, entry: Variation, target: Target, table: Mapping[str, Any]) -> Any:
        """Return the scenario's value, or else the plant's: a number, or a signal as a table."""
        usual = _found(table, target.key)
        if usual is None:
            usual = target.usual
        if isinstance(usual, dict) and "kind" in usual:
            return usual
        if not isinstance(usual, int | float) or isinstance(usual, bool):
            raise BadInput(OPTION, entry.label, f"{shown(usual)} is not a number to be multiplied")
        for factor in entry.ends():
            if not target.low <= usual * factor <= target.high:
                allowed = f"the plant FMU takes {target.low:g} to {target.high:g}"
                said = f"{factor:g} * {usual:g} is not allowed"
                raise BadInput(OPTION, entry.label, f"{said}: {allowed}")
        return usual

    def _case(self, table: dict[str, Any]) -> Case:
        try:
            return case_from(table, "main", self.scenario.settings.title, self.scenario.path)
        except BadInput as error:
            for entry in self.variations:
                key = self.targets[entry.label].key
                if error.place and (error.place.startswith(key) or key.startswith(error.place)):
                    raise BadInput(OPTION, entry.name, error.problem) from None
            raise


def _factors(target: Target, usual: Any) -> tuple[float, float]:
    """Return the limits of factors that keep a scaled value in its target's range."""
    if isinstance(usual, dict) or usual == 0:
        return -math.inf, math.inf
    low, high = sorted((target.low / usual, target.high / usual))
    return low, high


def _scaled(usual: Any, factor: float) -> Any:
    if isinstance(usual, dict):
        return {"kind": "scaled", "signal": usual, "factor": float(factor)}
    return usual * factor


def _found(table: Any, key: str) -> Any:
    """Return the value of a dotted key in a scenario's table, or None."""
    for step in key.split(".", 2 if key.startswith("plant.parameters.") else -1):
        table = table.get(step) if isinstance(table, dict) else None
    return table


def _repeated(seed: int, repeat: int) -> int:
    """Return the scenario's seed in a repeat; the first has the sweep's own, as in `run`."""
    if repeat == 0:
        return seed
    (word,) = np.random.SeedSequence([seed, repeat]).generate_state(1).tolist()
    return int(word % LARGEST_SEED) + 1
