"""The outer forms of a machine file, checked by pydantic; the page of a drawing shares some."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from measurement.rig import AxisOfColumn, FivePointRig, Sign, SimulatedRig

NAME = r"^[A-Za-z][A-Za-z0-9_]*$"
"""What may name a part, a sensor or an input."""

Name = Annotated[str, StringConstraints(pattern=NAME, max_length=60)]
SignalUnit = Literal["degC", "rpm", "mm_min", "Nm", "W", "lpm"]
Number = Annotated[float, Field(allow_inf_nan=False)]

MOST_NODES = 500
"""Lumps that a machine file may have."""


class Form(BaseModel):
    """Base of all forms: nothing unknown, nothing converted."""

    model_config = ConfigDict(extra="forbid", strict=True)


class ParameterForm(Form):
    """A number with its range and source."""

    value: Number
    unit: str
    low: Number
    high: Number
    source: str = Field(min_length=1)
    calibrate: bool = False


class TiedForm(Form):
    """A number that follows a named one."""

    number: str
    factor: Number | None = None
    unit: str | None = None


class InputForm(Form):
    """What drives the machine."""

    unit: SignalUnit
    column: str = Field(min_length=1)
    low: Number
    high: Number
    default: Number | None = None


class NodeForm(Form):
    """A lump."""

    name: Name
    capacity: dict[str, Any]
    start: str = "ambient"
    start_share: Number = Field(default=1.0, ge=0.0, le=2.0)


class SensorForm(Form):
    """A thermometer."""

    name: Name
    of: str
    noise: Number = Field(default=0.0, ge=0.0, le=10.0)
    resolution: Number = Field(default=0.0, ge=0.0, le=10.0)


class AxisForm(Form):
    """How the control applies offsets."""

    slew_um_per_s: Number = Field(default=10.0, gt=0.0, le=1e5)
    limit_um: Number = Field(default=300.0, gt=0.0, le=1e5)
    resolution_um: Number = Field(default=0.1, ge=0.0, le=100.0)


class FiveForm(FivePointRig):
    """A five-point rig; its sensors are variables of the plant FMU, and its signs must be said."""

    kind: Literal["five_point"]
    near_x: Name
    near_y: Name
    distal_x: Name
    distal_y: Name
    axial: Name
    axial_sign: Sign


class DirectForm(SimulatedRig):
    """A rig of direct displacements; unlike where a compensator is fitted, axes may come twice."""

    kind: Literal["direct"]
    axes: dict[Name, AxisOfColumn] = Field(min_length=1)


class FileForm(Form):
    """A whole machine file."""

    format: Literal[1]
    name: Name
    title: str
    description: str = ""
    references: dict[Name, str] = Field(default_factory=dict)
    numbers: dict[Name, ParameterForm] = Field(default_factory=dict)
    inputs: dict[Name, InputForm] = Field(min_length=1)
    nodes: list[NodeForm] = Field(min_length=1, max_length=MOST_NODES)
    links: list[dict[str, Any]] = Field(default_factory=list, max_length=5000)
    sources: list[dict[str, Any]] = Field(default_factory=list, max_length=500)
    structure: list[dict[str, Any]] = Field(default_factory=list, max_length=500)
    sensors: list[SensorForm] = Field(default_factory=list, max_length=500)
    rig: FiveForm | DirectForm = Field(discriminator="kind")
    axis: AxisForm = Field(default_factory=AxisForm)
    effects: dict[str, dict[str, Any]]
