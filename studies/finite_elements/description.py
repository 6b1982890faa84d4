"""The description file of a finite-element spindle: parts, gaps, jackets, surfaces, heat."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from measurement.errors import checked, shown
from measurement.files import read_toml

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1, max_length=60)]
Number = Annotated[float, Field(allow_inf_nan=False)]
MOST_ELEMENTS = 40_000
"""Most elements, because more would take too long: set on no data."""


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Material(_Table):
    """Conductivity [W/(m K)], density [kg/m3], specific heat [J/(kg K)], modulus [GPa], 1e-6/K."""

    conductivity: Positive
    density: Positive
    specific_heat: Positive
    modulus: Positive
    poisson: Annotated[float, Field(ge=0.0, lt=0.5)]
    expansion: NotNegative


class Rectangle(_Table):
    """A rectangle in the half plane: r from the axis and z along it [mm]."""

    r: tuple[NotNegative, NotNegative]
    z: tuple[Number, Number]

    @field_validator("r", "z")
    @classmethod
    def _ascending(cls, value: tuple[float, float], info: ValidationInfo) -> tuple[float, float]:
        if not value[0] < value[1]:
            raise ValueError("must be two numbers, the smaller first")
        return value


class Part(Rectangle):
    """A part of one material."""

    name: Name
    material: Name


class Gap(Rectangle):
    """An annular air gap between a rotating and a stationary surface."""

    name: Name


class Jacket(Rectangle):
    """A cooled region with its conductance to the coolant [W/K]."""

    name: Name
    conductance: NotNegative


class Surface(Rectangle):
    """Free surfaces in air; *diameter_mm* is used in the film correlations."""

    name: Name
    kind: Literal["still", "turning"]
    diameter_mm: Positive


class Bearings(_Table):
    """A bearing set whose friction heats its parts."""

    name: Name
    parts: Annotated[list[Name], Field(min_length=1)]
    count: Annotated[int, Field(ge=1, le=20)]
    mean_diameter_mm: Positive
    f0: NotNegative
    f1: NotNegative
    preload_n: NotNegative
    viscosity_mm2_s: Positive


class Motor(_Table):
    """A loss proportional to speed, shared between parts."""

    name: Name
    watts_per_1000rpm: NotNegative
    shares: Annotated[dict[str, NotNegative], Field(min_length=1)]


class Ring(_Table):
    """A ring in a plane across the axis: its position and radii [mm]."""

    z: Number
    r: tuple[NotNegative, NotNegative]


class Inputs(_Table):
    """Names of the sensors for air and coolant, if a run has them."""

    air: Name | None = None
    coolant: Name | None = None


class Description(_Table):
    """A spindle for finite elements; the shipped file explains each table."""

    format: Literal[1]
    name: Name
    title: str = ""
    element_mm: Annotated[float, Field(gt=0.2, le=100.0)] = 9.0
    inputs: Inputs = Inputs()
    mount: Ring
    nose: Ring
    materials: dict[str, Material]
    parts: Annotated[list[Part], Field(min_length=1)]
    gaps: list[Gap] = []
    jackets: list[Jacket] = []
    surfaces: list[Surface] = []
    bearings: list[Bearings] = []
    motors: list[Motor] = []

    @model_validator(mode="after")
    def _names_exist(self) -> Description:
        for part in self.parts:
            if part.material not in self.materials:
                raise ValueError(f"part {part.name}: {shown(part.material)} is not a material")
        parts = {part.name for part in self.parts}
        for source, used in self._sources():
            for name in used:
                if name not in parts:
                    raise ValueError(f"{source}: {shown(name)} is not a part")
        return self

    @model_validator(mode="after")
    def _heat_comes_and_goes(self) -> Description:
        if not self.surfaces and not self.jackets:
            raise ValueError("no surface and no jacket: the spindle could not get rid of its heat")
        names = [source for source, _ in self._sources()]
        if not names:
            raise ValueError("neither bearings nor motors: nothing would warm the spindle")
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"{shown(name)} names two sources of heat")
        for motor in self.motors:
            if sum(motor.shares.values()) == 0.0:
                raise ValueError(f"{motor.name}: the shares must not all be 0")
        return self

    def _sources(self) -> list[tuple[str, list[str]]]:
        named = [(bearings.name, list(bearings.parts)) for bearings in self.bearings]
        return [*named, *((motor.name, list(motor.shares)) for motor in self.motors)]


def read_description(source: str | Path = "jig_borer") -> Description:
    """Read a description file, or the shipped one with this name.

    Parameters
    ----------
    source : str or path
        A shipped name, or a file that ends in ``.toml``.

    Returns
    -------
    Description
        Checked against sensible ranges.

    Raises
    ------
    BadInput
        One line naming the file, the place in it, the value and what is allowed.
    """
    path = Path(source)
    shipped = Path(__file__).parent / f"{source}.toml"
    if path.suffix != ".toml" and shipped.is_file():
        path = shipped
    return checked(Description, read_toml(path), path)
