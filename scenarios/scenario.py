"""Scenario files: TOML in, checked cases out.

The file format is declared here as pydantic models; the files in ``library/`` are examples. A
refusal is one line: file, place, value, what is allowed.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from measurement.errors import BadInput, checked, matching, near, shown
from measurement.files import toml_table
from measurement.runs import LONGEST_S
from plant_model.drive import MOST_STEPS
from scenarios.faults import SensorFault
from scenarios.signals import build
from scenarios.signals.base import Duration, Setting, Signal, Value

LIBRARY = Path(__file__).parent / "library"

Name = Annotated[
    str,
    Field(max_length=60),
    matching(r"[A-Za-z][A-Za-z0-9_-]*", "a letter, then letters, digits, _ and -"),
]
SignalName = Annotated[
    str,
    Field(max_length=100),
    matching(r"[A-Za-z][A-Za-z0-9_.\[\]]*", "a letter, then letters, digits, _ . [ ]"),
]
ParameterName = Annotated[str, Field(min_length=1, max_length=200)]
Text = Annotated[str, Field(max_length=4000)]
FileName = Annotated[str, Field(min_length=1, max_length=4096)]
Length = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]


class _Form(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Plant(_Form):
    """The machine: an FMU, sensor noise, parameters by name.

    *fmu* is a path, a name in the FMU folder, or a machine file (``.toml``).
    """

    fmu: FileName = "plant.fmu"
    """A path, a name in the FMU folder, or a machine file."""
    noise: bool = True
    """Whether the sensors are noisy."""
    parameters: dict[ParameterName, Value] = Field(default_factory=dict, max_length=500)
    """Values of the plant FMU's parameters, by name."""


class Probe(_Form):
    """A probe cycle: the plant's own displacement is passed to the compensator.

    *every_s*: at fixed intervals; *when_um*: when an uncertainty of the compensator exceeds this.
    """

    every_s: Annotated[float, Field(ge=1.0, le=LONGEST_S)] | None = None
    """A probe cycle at fixed intervals: the plant's own displacement is passed to the
    compensator."""
    when_um: Annotated[float, Field(ge=0.01, le=1e5)] | None = None
    """A probe cycle when an uncertainty exceeds this."""


class CompensatorSection(_Form):
    """The compensator: an FMU or a compensator file (``.json``), and what it is given.

    *tool_length_mm* is given to the compensator instead of the real length, to simulate a control
    that does not know its tools.
    """

    fmu: FileName = "compensator.fmu"
    """A path, a name in the FMU folder, or a compensator file."""
    enabled: bool = True
    """False: offsets stay zero."""
    tool_length_mm: Length | None = None
    """Length given to the compensator instead of the real one."""
    probe: Probe | None = None


class Variant(_Form):
    """The same scenario with some keys changed."""

    name: Name
    title: Text = ""
    set: dict[str, Any] = Field(default_factory=dict, max_length=100)
    """Keys that this variant changes: ``{ "key" = value }``."""


class Replay(_Form):
    """A compensator driven by measured runs instead of the plant."""

    runs: list[FileName] = Field(default_factory=list, max_length=1000)
    """Measured runs instead of a plant, without ``plant``, ``signals``, ``faults`` and
    ``variants``."""
    tool_length_mm: Length | None = None


class Settings(_Form):
    """A whole scenario file."""

    format: Literal[1]
    name: Name
    title: Text = Field(min_length=1)
    description: Text = ""
    duration_s: Duration = 28800.0
    """A multiple of *step_s*, at most 1,000,000 steps."""
    step_s: Annotated[float, Field(ge=1e-3, le=3600.0)] = 1.0
    """Communication step."""
    record_s: Annotated[float, Field(ge=1e-3, le=1e6)] = 10.0
    """Time between rows of the results, a multiple of *step_s*."""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    """Seed of sensor noise and random signals."""
    plant: Plant = Plant()
    compensator: CompensatorSection = CompensatorSection()
    signals: dict[SignalName, Any] = Field(default_factory=dict, max_length=200)
    """Values for the plant's inputs, and ``tool_length`` [mm]: a number, or a table with a
    ``kind``."""
    faults: list[SensorFault] = Field(default_factory=list, max_length=100)
    variants: list[Variant] = Field(default_factory=list, max_length=50)
    replay: Replay | None = None

    @model_validator(mode="after")
    def _fits(self) -> Settings:
        if self.duration_s / self.step_s > MOST_STEPS:
            raise ValueError(
                f"duration_s / step_s is more than {MOST_STEPS} steps: make step_s longer"
            )
        for name in ("duration_s", "record_s"):
            count = getattr(self, name) / self.step_s
            if round(count) < 1 or abs(count - round(count)) > 1e-6 * count:
                raise ValueError(
                    f"{name}, {getattr(self, name):g}, must be a multiple of "
                    f"step_s, {self.step_s:g}"
                )
        names = [variant.name for variant in self.variants]
        if len(set(names)) < len(names):
            raise ValueError("two variants have the same name")
        return self

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.duration_s / self.step_s)


@dataclass(frozen=True)
class Case:
    """One variant of a scenario, ready to run.

    Attributes
    ----------
    name, title : str
        Of the variant; ``main`` for a scenario without variants.
    settings : Settings
        Everything except the signals.
    signals : dict of str to Signal
        The signals that drive the plant, by input.
    setting : Setting
        Context that the signals need to return values.
    """

    name: str
    title: str
    settings: Settings
    signals: dict[str, Signal]
    setting: Setting


@dataclass(frozen=True)
class Scenario:
    """A scenario file, read and checked.

    Attributes
    ----------
    settings : Settings
        The file's settings, with the overrides of the command line.
    cases : tuple of Case
        The cases to simulate: the variants, or the file itself if it has none.
    path : Path
        The file.
    text : str
        Its content, unchanged.
    overrides : tuple of (str, object)
        Keys that the caller overrides.
    """

    settings: Settings
    cases: tuple[Case, ...]
    path: Path
    text: str
    overrides: tuple[tuple[str, Any], ...] = ()


def library() -> list[Path]:
    """Return the scenario files that come with the package."""
    return sorted(LIBRARY.glob("*.toml"))


def scenario_path(name_or_path: str | Path) -> Path:
    """Return the file of a shipped scenario's name, or the path as given.

    Raises
    ------
    BadInput
        If there is neither such a file nor such a scenario; the nearest name is suggested.
    """
    text = str(name_or_path)
    names = {path.stem: path for path in library()}
    if text in names:
        return names[text]
    try:
        path = Path(text).expanduser()
        if path.is_file():
            return path
    except (OSError, ValueError, RuntimeError) as error:
        raise BadInput(text, "", f"is not a path: {error}") from None
    hint = near(text.removesuffix(".toml"), names)
    raise BadInput(text, "", f"is neither a file nor one of the scenarios {', '.join(names)}{hint}")


def read_scenario(name_or_path: str | Path, overrides: Sequence[tuple[str, Any]] = ()) -> Scenario:
    """Read a scenario file, or a shipped scenario by its name.

    Parameters
    ----------
    name_or_path : str or path
        For example ``step_speed`` or ``my_scenario.toml``.
    overrides : sequence of (key, value)
        Keys to override, dotted: ``("compensator.enabled", False)``.

    Returns
    -------
    Scenario

    Raises
    ------
    BadInput
        For the first error in it, in one line.
    """
    path = scenario_path(name_or_path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(path, "", f"cannot be read: {' '.join(str(error).split())}") from None
    return scenario_from_text(text, path, overrides)


def scenario_from_text(
    text: str, path: Path, overrides: Sequence[tuple[str, Any]] = ()
) -> Scenario:
    """Check a scenario given as text; see :func:`read_scenario`.

    Parameters
    ----------
    text : str
        TOML.
    path : Path
        The file that it came from; file names in it are relative to its folder.
    overrides : sequence of (key, value)
        See `read_scenario`.

    Returns
    -------
    Scenario

    Raises
    ------
    BadInput
        For the first error in it, in one line.
    """
    table = toml_table(text, path)
    for key, value in overrides:
        table = changed(table, key, value, path, "--set")
    settings = checked(Settings, table, path)
    for key, _ in overrides:
        sets = [any(f"{key}.".startswith(f"{own}.") for own in v.set) for v in settings.variants]
        if sets and all(sets):
            problem = f"{shown(key)} has no effect: every variant sets it again, change it there"
            raise BadInput(path, "--set", problem)
    if settings.replay is not None:
        _check_replay(table, settings, path)
        return Scenario(settings, (), path, text, tuple(overrides))
    base = {key: value for key, value in table.items() if key != "variants"}
    cases = [
        _variant(base, variant, path, f"variants.{i}.set")
        for i, variant in enumerate(settings.variants)
    ]
    if not cases:
        cases = [case_from(base, "main", settings.title, path)]
    return Scenario(settings, tuple(cases), path, text, tuple(overrides))


def changed(
    table: dict[str, Any], key: str, value: Any, source: str | Path, place: str
) -> dict[str, Any]:
    """Return a copy of *table* in which the dotted *key* has another value.

    The copy shares what does not change with *table*. Everything after ``plant.parameters.`` is one
    name, since a parameter's name may contain dots.

    Parameters
    ----------
    table : dict
        A parsed scenario; not modified.
    key : str
        Dotted, such as ``signals.speed.value``.
    value
        Any value that TOML can express.
    source : str or path
        The scenario, for refusals.
    place : str
        Where the key was given.

    Raises
    ------
    BadInput
        If the key leads into something that is not a table.
    """
    changes = dict(table)
    *parents, last = key.split(".", 2 if key.startswith("plant.parameters.") else -1)
    inner: Any = changes
    for step in parents:
        # A plain number may be a constant signal, which has no keys inside.
        place_in: Any = step if isinstance(inner, dict) else None
        if isinstance(inner, list) and step.isdigit() and int(step) < len(inner):
            place_in = int(step)
        if place_in is None:
            inner = None
            break
        before = inner.get(step, {}) if isinstance(inner, dict) else inner[place_in]
        inner[place_in] = copy.copy(before)
        inner = inner[place_in]
    if not isinstance(inner, dict) or not key.strip():
        raise BadInput(source, place, f"{shown(key)} does not name a key of the scenario")
    inner[last] = value
    return changes


def _check_replay(table: dict[str, Any], settings: Settings, path: Path) -> None:
    clash = sorted({"plant", "signals", "faults", "variants"} & table.keys())
    if clash:
        raise BadInput(path, clash[0], "has no meaning beside [replay]: no plant is simulated")
    if not settings.compensator.enabled:
        raise BadInput(path, "compensator.enabled", "a replay needs the compensator")


def _variant(base: dict[str, Any], variant: Variant, path: Path, place: str) -> Case:
    table = base
    for key, value in variant.set.items():
        if key.split(".")[0] in ("variants", "replay", "format", "name"):
            raise BadInput(path, place, f"{shown(key)} cannot differ between variants")
        table = changed(table, key, value, path, place)
    try:
        return case_from(table, variant.name, variant.title or variant.name, path)
    except BadInput as error:
        if str(error.source) != str(path):
            raise
        raise BadInput(path, f"{place} ({variant.name}): {error.place}", error.problem) from None


def case_from(table: dict[str, Any], name: str, title: str, path: Path) -> Case:
    """Return the case of a table without variants.

    Parameters
    ----------
    table : dict
        A parsed scenario.
    name, title : str
        Of the case.
    path : Path
        The file that it came from.

    Raises
    ------
    BadInput
        For the first error in it, in one line.
    """
    settings = checked(Settings, table, path)
    setting = Setting(path, "signals", path.resolve().parent, settings.seed)
    signals = {key: build(entry, setting.inside(key)) for key, entry in settings.signals.items()}
    return Case(name, title, settings, signals, setting)
