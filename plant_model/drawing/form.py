"""Forms of a page, checked by pydantic: one form for each of its tables.

Lengths are in mm, masses in kg; the unit of every other number is given with it here. A number may
be a table of value, low, high, source and calibrate.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from plant_model.drawing.known import BY_DATA_SHEET, Known, within
from plant_model.machine_forms import (
    AxisForm,
    DirectForm,
    FiveForm,
    Form,
    InputForm,
    Name,
    Number,
)

Side = Literal["X+", "X-", "Y+", "Y-"] | Number
"""A direction around the spindle: a side's name, or degrees from X+ towards Y+."""

ANGLES = {"X+": 0.0, "Y+": 90.0, "X-": 180.0, "Y-": 270.0}


def degrees(side: str | float) -> float:
    """Return a side as degrees from X+ towards Y+, 0 to 360.

    Parameters
    ----------
    side : str or float
        ``X+``, ``X-``, ``Y+``, ``Y-``, or an angle from X+ towards Y+ [deg].
    """
    return (ANGLES[side] if isinstance(side, str) else float(side)) % 360.0


class Quantity(Form):
    """A number of the page; a bare number is its value."""

    value: Number
    low: Number | None = None
    high: Number | None = None
    source: str | None = None
    calibrate: bool | None = None

    @model_validator(mode="before")
    @classmethod
    def _bare(cls, given: Any) -> Any:
        if isinstance(given, (int, float)) and not isinstance(given, bool):
            return {"value": float(given)}
        if not isinstance(given, dict):
            raise ValueError("a number, or a table of value, low, high and source")
        return given

    @model_validator(mode="after")
    def _ascends(self) -> Quantity:
        low = self.value if self.low is None else self.low
        high = self.value if self.high is None else self.high
        if not low <= self.value <= high:
            raise ValueError(f"low {low:g}, value {self.value:g}, high {high:g} must ascend")
        return self

    @property
    def is_known(self) -> bool:
        """Whether the page says how well it is known, or whether calibration may move it."""
        return not (self.low is self.high is self.calibrate is None)

    def known(self, unit: str, share: float = BY_DATA_SHEET, *, free: bool = True) -> Known:
        """Return it with a range, by default *share* to both sides; *free* holds if not given."""
        usual = within(share, self.value, unit, self.source or "page")
        return Known(
            self.value,
            usual.low if self.low is None else self.low,
            usual.high if self.high is None else self.high,
            unit,
            usual.source,
            free if self.calibrate is None else self.calibrate,
        )


def _between(low: float, high: float, unit: str) -> AfterValidator:
    def check(given: Any) -> Any:
        ends = [given.low, given.high] if isinstance(given, Quantity) else []
        value = given.value if isinstance(given, Quantity) else given
        for number in (value, *(end for end in ends if end is not None)):
            if not low <= number <= high:
                raise ValueError(f"{low:g} to {high:g} {unit} can be")
        return given

    return AfterValidator(check)


Place = Annotated[Number, _between(-5000.0, 5000.0, "mm")]
Diameter = Annotated[Number, _between(5.0, 2000.0, "mm")]
Bore = Annotated[Number, _between(0.0, 1900.0, "mm")]
Length = Annotated[Number, _between(1.0, 10000.0, "mm")]
Conductance = Annotated[Quantity, _between(0.01, 2e4, "W/K")]


class _Span(Form):
    start: Place = Field(alias="from")
    end: Place = Field(alias="to")


class PatchForm(_Span):
    """A stretch of the housing, all around or on one side over the angle *width*."""

    side: Side | None = None
    """Middle of a part on one side; if left out, all around."""
    width: Annotated[Number, _between(1.0, 360.0, "degrees")] = 90.0
    """Angle that it covers."""

    @property
    def around(self) -> float:
        """Share of the circumference that it covers [1]."""
        return 1.0 if self.side is None else self.width / 360.0

    def apart(self, angle: float) -> float:
        """Return the angle between a direction and its middle [deg], 0 to 180; 0 if all around.

        Parameters
        ----------
        angle : float
            From X+ towards Y+ [deg].
        """
        if self.side is None:
            return 0.0
        return abs((degrees(self.side) - angle + 180.0) % 360.0 - 180.0)

    def reaches(self, angle: float, width: float = 0.0) -> bool:
        """Return whether it covers some of an angle *width* [deg] around a direction [deg]."""
        return self.apart(angle) <= 180.0 * self.around + width / 2.0

    def overlaps(self, other: PatchForm, touch: float) -> bool:
        """Return whether it shares more than *touch* [mm, deg] with another patch."""
        both = min(self.end, other.end) - max(self.start, other.start)
        width = 360.0 * other.around - 2.0 * touch
        return both > touch and self.reaches(degrees(other.side or 0.0), width)


class StretchForm(_Span):
    """A piece of shaft or housing with one outer and one inner diameter."""

    outer: Diameter
    inner: Bore = 0.0
    material: str | None = None
    """By default that of the whole shaft or housing."""
    even: bool = False
    """Not divided around the axis."""


class ShaftForm(Form):
    """The shaft; positions count from the mounting face towards the nose."""

    material: str = "steel"
    gauge_line: Place
    """From the mounting face."""
    stretches: list[StretchForm] = Field(min_length=1, max_length=100)


class FaceForm(PatchForm):
    """A part of the housing's outside that is in other air than the rest, or is blown on."""

    air: str | None = None
    """An input, or the enclosure."""
    film: Annotated[Quantity, _between(0.5, 1000.0, "W/(m2 K)")] | None = None
    """By default that of still air."""


class HousingForm(Form):
    """The housing; *even* stretches are not divided around the axis."""

    material: str = "steel"
    air: str | None = None
    """``ambient``, unless another input or the enclosure."""
    faces: list[FaceForm] = Field(default_factory=list, max_length=20)
    stretches: list[StretchForm] = Field(min_length=1, max_length=100)


class SleeveForm(_Span):
    """The sleeve that holds a bearing set and conducts its heat to the housing.

    With an outer diameter it is a separate part between bearings and housing.
    """

    outer: Diameter | None = None
    """If given, the sleeve is a separate part between bearings and housing."""
    material: str = "steel"


class BearingForm(Form):
    """A set of equal bearings around one place."""

    name: Name
    at: Place
    """Middle of the set."""
    designation: str | None = None
    """70, 719, 72, 60, 62, N10 or NN30 with two digits of bore code; or *bore*, *outside* and
    *width*."""
    count: int = Field(default=1, ge=1, le=8)
    """Bearings in the set."""
    spacing: Length | None = None
    """By default side by side."""
    sleeve: SleeveForm | None = None
    locates: bool = False
    """Holds the shaft along its axis."""
    lubrication: Literal["oil-air", "grease", "oil"] = "grease"
    grade: Annotated[Number, _between(10.0, 320.0, "mm2/s at 40 degC")] = 32.0
    """ISO VG."""
    viscosity_index: Annotated[Number, _between(50.0, 200.0, "")] = 95.0
    running_temperature: Annotated[Quantity, _between(0.0, 120.0, "degC")] | None = None
    """Of the lubricant; 45 degC by default."""
    bore: Diameter | None = None
    outside: Diameter | None = None
    width: Length | None = None
    rollers: bool = False
    """Whether a bearing without a designation has rollers."""
    f0: Annotated[Quantity, _between(0.1, 20.0, "")] | None = None
    """Class value."""
    f1: Annotated[Quantity, _between(0.0, 0.01, "")] | None = None
    """Class value."""
    preload: Annotated[Quantity, _between(0.0, 50000.0, "N")] | None = None
    """Class value."""
    conductance: Conductance | None = None
    """Of one bearing, inner to outer ring; class value."""
    seat: Annotated[Quantity, _between(100.0, 100000.0, "W/(m2 K)")] | None = None
    """Of its joints; class value."""


class MotorForm(_Span):
    """A built-in motor, or the pulley of a belt."""

    drive: Literal["built-in", "belt"] = "built-in"
    rotor_outer: Diameter | None = None
    """Of a built-in motor, like *stator_outer* and *gap*."""
    stator_outer: Diameter | None = None
    """The housing's bore."""
    gap: Annotated[Number, _between(0.1, 10.0, "mm")] = 0.7
    loss: Annotated[Quantity, _between(0.0, 2000.0, "W/(1000 r/min)")] | None = None
    """Or *power*, *efficiency* and *rated_speed*."""
    power: Annotated[Number, _between(0.1, 500.0, "kW")] | None = None
    efficiency: Annotated[Number, _between(0.3, 0.995, "(share, not per cent)")] | None = None
    rated_speed: Annotated[Number, _between(10.0, 1e5, "r/min")] | None = None
    rotor_share: Annotated[Quantity, _between(0.0, 1.0, "")] | None = None
    """Class value."""
    joint: Annotated[Quantity, _between(50.0, 50000.0, "W/(m2 K)")] | None = None
    """On shaft and in housing; class value."""
    pulley_outer: Diameter | None = None
    """Of a belt."""
    into: str | None = None
    """The carrier heated by the rest of a belt's loss."""


class ChannelForm(Form):
    """The channel of a jacket."""

    width: Annotated[Number, _between(1.0, 200.0, "mm")] = 15.0
    depth: Annotated[Number, _between(1.0, 50.0, "mm")] = 6.0
    turns: Annotated[Number, _between(0.5, 200.0, "turns")] | None = None
    """By default as many as fit side by side."""


class JacketForm(PatchForm):
    """A cooling jacket around a stretch of the housing, or on one side of it."""

    name: Name
    fluid: str = "water"
    """``water``, ``glycol 30 %``, ``oil 10``."""
    flow: Annotated[Quantity, _between(0.05, 200.0, "l/min")]
    inlet: str = "coolant_inlet"
    """An input."""
    after: str | None = None
    """A jacket, in series."""
    channel: ChannelForm = Field(default_factory=ChannelForm)
    wall: Conductance | None = None
    """By default from the channel."""
    inlet_side: Side | None = None
    """Coldest side; if left out, all sides alike."""
    unevenness: Annotated[Quantity, _between(0.0, 1.0, "(share)")] | None = None
    """How much less the far side is cooled; class value."""


class HoldForm(PatchForm):
    """The stretch of the housing held by a carrier."""


class BendForm(Form):
    """A tilt by the temperature difference between two carriers."""

    against: str
    """The other carrier, on the cool side."""
    width: Length
    """From the middle of the carrier to the middle of *against*, in the plane of bending."""
    length: Annotated[Quantity, _between(1.0, 10000.0, "mm")]
    """Over which the two are side by side and bend each other: the height of the joint."""
    lever: Annotated[Number, _between(-10000.0, 10000.0, "mm")]
    """Along the spindle, from the middle of *length* to the gauge line; positive towards the
    nose."""
    yaw: Annotated[Number, _between(-1.0, 1.0, "")] = 0.0
    """Like *pitch*, but for X."""
    pitch: Annotated[Number, _between(-1.0, 1.0, "")] = 0.0
    """1 if a warmer carrier moves the tool's end towards +Y, -1 if towards -Y; in an oblique plane,
    *yaw* and *pitch* are its cosine and sine."""


OneWay = Annotated[Quantity, _between(-5000.0, 5000.0, "mm")]
"""A length whose sign is a direction."""


class GrowForm(Form):
    """Lengths of a carrier whose growth moves the nose along the axes; z: towards the table."""

    x: OneWay | None = None
    """Length whose growth moves the nose along X."""
    y: OneWay | None = None
    """Along Y."""
    z: OneWay | None = None
    """Towards the table."""

    def lengths(self) -> dict[str, Quantity]:
        """Return the lengths that are not 0, by axis."""
        by_axis = {"x": self.x, "y": self.y, "z": self.z}
        return {
            axis: length for axis, length in by_axis.items() if length is not None and length.value
        }


class FeedForm(Form):
    """A feed axis that heats the part."""

    input: str
    """Feed speed."""
    loss: Annotated[Quantity, _between(0.0, 2000.0, "W/(m/min)")] | None = None
    """Class value."""


class CarrierForm(Form):
    """A part that carries the spindle, or another carrier."""

    name: Name
    material: str = "cast_iron"
    """A material."""
    mass: Annotated[Quantity, _between(0.05, 50000.0, "kg")]
    surface: Annotated[Number, _between(0.0, 200.0, "m2")]
    holds: HoldForm | None = None
    on: str | None = None
    """The carrier that holds it."""
    joint: Conductance | None = None
    """To the part that it holds, else to the one that it stands on; class value."""
    air: str | None = None
    """``ambient``, unless another input or the enclosure."""
    grows: GrowForm = Field(default_factory=GrowForm)
    bends: list[BendForm] = Field(default_factory=list, max_length=10)
    feed: FeedForm | None = None


class ToolForm(Form):
    """The tool or test bar in the spindle."""

    length: Length
    diameter: Diameter
    material: str = "steel"
    joint: Conductance | None = None
    """Class value."""


class EnclosureForm(Form):
    """A closed space with its own air."""

    volume: Annotated[Number, _between(0.01, 500.0, "m3")]
    wall: Annotated[Number, _between(0.1, 500.0, "m2")]
    """Its own walls towards the hall, without the parts inside."""
    film: Annotated[Quantity, _between(0.5, 50.0, "W/(m2 K)")] | None = None
    """From the air inside through the wall to the hall; class value."""


class ThermometerForm(Form):
    """A thermometer by part, place along the axis and side."""

    name: Name
    part: str
    """``housing``, ``shaft``, ``rotor``, ``stator``, ``tool``, ``enclosure``, ``front.outer`` (a
    bearing's ring, or its ``sleeve``), ``jacket.front``, a carrier, an input.
    In the bore beside a bearing it reads the ring: the wall may be 10 K colder further out."""
    at: Place | None = None
    side: Side | None = None
    noise: Number = Field(default=0.05, ge=0.0, le=10.0)
    """[K]"""
    resolution: Number = Field(default=0.01, ge=0.0, le=10.0)
    """[K]"""


class MaterialForm(Form):
    """A material defined in the page."""

    density: Annotated[Number, _between(100.0, 25000.0, "kg/m3")]
    """A material of your own. Known: steel, cast_iron, lamination, aluminium, mineral_casting,
    invar, carbide, granite."""
    specific_heat: Annotated[Number, _between(50.0, 5000.0, "J/(kg K)")]
    conductivity: Annotated[Quantity, _between(0.01, 500.0, "W/(m K)")]
    expansion: Annotated[Quantity, _between(0.0, 40.0, "1e-6/K")]


class CellsForm(Form):
    """Size of the cells; by default the thermometers' sides determine *sectors*."""

    longest: Annotated[Number, _between(2.0, 500.0, "mm")] = 40.0
    """Of a cell along the axis."""
    sectors: Literal[1, 4, 8, 12, 16] | None = None
    """By default the lowest number from 4 on with every thermometer in the middle of a sector."""


class PageForm(Form):
    """A whole page."""

    format: Literal[1]
    kind: Literal["drawing"]
    name: Name
    title: str
    description: str = ""
    inputs: dict[Name, InputForm] = Field(min_length=1)
    cells: CellsForm = Field(default_factory=CellsForm)
    materials: dict[Name, MaterialForm] = Field(default_factory=dict)
    shaft: ShaftForm
    housing: HousingForm
    bearings: list[BearingForm] = Field(min_length=1, max_length=20)
    motor: MotorForm | None = None
    jackets: list[JacketForm] = Field(default_factory=list, max_length=20)
    carriers: list[CarrierForm] = Field(default_factory=list, max_length=50)
    enclosure: EnclosureForm | None = None
    tool: ToolForm | None = None
    thermometers: list[ThermometerForm] = Field(default_factory=list, max_length=500)
    rig: FiveForm | DirectForm = Field(discriminator="kind")
    axis: AxisForm = Field(default_factory=AxisForm)
    effects: dict[str, dict[str, Any]] = Field(default_factory=dict)
