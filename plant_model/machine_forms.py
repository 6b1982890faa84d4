"""Outer forms of a machine file, checked by pydantic; a drawing's page shares some of them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from measurement.errors import BadInput, matching
from measurement.rig import AxisOfColumn, FivePointRig, Sign, SimulatedRig

NAME = r"[A-Za-z][A-Za-z0-9_]*"
"""Pattern of names of parts, sensors and inputs."""

Name = Annotated[
    str,
    StringConstraints(max_length=60),
    matching(NAME, "a letter, then letters, digits and _"),
]
SignalUnit = Literal["degC", "rpm", "mm_min", "Nm", "W", "lpm"]
Number = Annotated[float, Field(allow_inf_nan=False)]

MOST_NODES = 500
"""Most lumps of a machine file: set on no data."""


class Form(BaseModel):
    """Base of all forms: unknown fields are refused, and values are not converted."""

    model_config = ConfigDict(extra="forbid", strict=True)


class ParameterForm(Form):
    """A number with its range and source."""

    value: Number
    """Between *low* and *high*."""
    unit: str
    """Fixed for each parameter."""
    low: Number
    """The range is *low* to *high*: for calibration four standard deviations wide, of the logarithm
    if positive, and not a hard limit."""
    high: Number
    source: str = Field(min_length=1)
    """A key of ``references``, or free text."""
    calibrate: bool = False
    """Calibration may change it, and it is a parameter of the plant FMU."""


class TiedForm(Form):
    """A number that follows a named one."""

    number: str
    factor: Number | None = None
    unit: str | None = None


class InputForm(Form):
    """What drives the machine."""

    unit: SignalUnit
    """``degC`` is a boundary temperature."""
    column: str = Field(min_length=1)
    """Its run-file column, which ends in the unit."""
    low: Number
    """The model's intended range is *low* to *high*."""
    high: Number
    default: Number | None = None
    """Its value for a run without that column; if left out, a run must have it."""


class NodeForm(Form):
    """A lump."""

    name: Name
    capacity: dict[str, Any]
    """A parameter, 0.001 to 1e9 J/K."""
    start: str = "ambient"
    """Sensor or ``degC`` input whose first value it starts at; or ``rest``: its steady state with
    the machine at rest, without heat that depends on temperature."""
    start_share: Number = Field(default=1.0, ge=0.0, le=2.0)
    """Share of the way to that start from the first boundary temperature."""


class SensorForm(Form):
    """A thermometer."""

    name: Name
    """Its column is ``<name>_degC``."""
    of: str
    """A node or a boundary temperature."""
    noise: Number = Field(default=0.0, ge=0.0, le=10.0)
    """Standard deviation [K]."""
    resolution: Number = Field(default=0.0, ge=0.0, le=10.0)
    """Step [K]."""


class AxisForm(Form):
    """How the control applies offsets."""

    slew_um_per_s: Number = Field(default=10.0, gt=0.0, le=1e5)
    """How fast the control moves an offset."""
    limit_um: Number = Field(default=300.0, gt=0.0, le=1e5)
    """Largest offset."""
    resolution_um: Number = Field(default=0.1, ge=0.0, le=100.0)
    """Step of an offset."""


class FiveForm(FivePointRig):
    """A five-point rig; its sensors are variables of the plant FMU, and it must give its signs."""

    kind: Literal["five_point"]
    near_x: Name
    near_y: Name
    distal_x: Name
    distal_y: Name
    axial: Name
    axial_sign: Sign


class DirectForm(SimulatedRig):
    """A rig of direct displacements; unlike in a compensator's fit, an axis may occur twice."""

    kind: Literal["direct"]
    axes: dict[Name, AxisOfColumn] = Field(min_length=1)
    """By sensor name; the sensor sees the nose at the gauge line, and its column is
    ``<name>_um``."""


class FileForm(Form):
    """A whole machine file."""

    format: Literal[1]
    name: Name
    title: str
    description: str = ""
    references: dict[Name, str] = Field(default_factory=dict)
    """Sources, by the key cited in parameters."""
    numbers: dict[Name, ParameterForm] = Field(default_factory=dict)
    """Parameters that several others follow: ``{ number = "film", factor = 0.025, unit = "W/K" }``.
    Calibration, sweeps and the plant FMU see ``numbers.film`` instead of its followers."""
    inputs: dict[Name, InputForm] = Field(min_length=1)
    """What drives the model, by name. Spindle speed is ``speed``, or else the only one in rpm."""
    nodes: list[NodeForm] = Field(min_length=1, max_length=MOST_NODES)
    links: list[dict[str, Any]] = Field(default_factory=list, max_length=5000)
    """``kind``, ``name`` (by default the joined names, ``shaft-housing``) and the fields of the
    kind: [kinds](effects.md#kinds-of-links-sources-and-parts)."""
    sources: list[dict[str, Any]] = Field(default_factory=list, max_length=500)
    """The same."""
    structure: list[dict[str, Any]] = Field(default_factory=list, max_length=500)
    """The same; a shaft, housing or ring needs exactly one part of kind ``located``."""
    sensors: list[SensorForm] = Field(default_factory=list, max_length=500)
    rig: FiveForm | DirectForm = Field(discriminator="kind")
    axis: AxisForm = Field(default_factory=AxisForm)
    effects: dict[str, dict[str, Any]]
    """In force, by name; ``{}`` uses the nominal numbers: [effects](effects.md)."""


def is_item_name(name: object) -> bool:
    """Return whether a text can be an item's name, such as ``shaft-housing``."""
    return isinstance(name, str) and name.replace("-", "_").isidentifier()


def named_place(place: str, table: object) -> str:
    """Return a dotted place in a file with the names of entries for their positions in lists.

    Parameters
    ----------
    place : str
        For example ``links.35.between``, which becomes ``links.shaft-housing.between``.
    table : object
        The parsed file. An entry keeps its position if it has no name, nor lies between parts, or
        another is called the same.
    """
    steps = []
    for step in place.split("."):
        if isinstance(table, list) and step.isdecimal() and int(step) < len(table):
            names = [_name_of(entry) for entry in table]
            table, name = table[int(step)], names[int(step)]
            step = name if name and names.count(name) == 1 else step
        else:
            table = table.get(step) if isinstance(table, dict) else None
        steps.append(step)
    return ".".join(steps)


def _name_of(entry: object) -> str:
    if not isinstance(entry, dict):
        return ""
    between = entry.get("between")
    name = entry.get("name", "-".join(map(str, between)) if isinstance(between, list) else "")
    return name if is_item_name(name) else ""


@contextlib.contextmanager
def naming_places(table: dict[str, Any]) -> Iterator[None]:
    """Refuse a file's entries by their names; see `named_place`."""
    try:
        yield
    except BadInput as error:
        place = named_place(error.place, table)
        raise BadInput(error.source, place, error.problem) from None
