"""A page, read and checked for fit of its parts, in the terms of the drawing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from measurement.errors import BadInput, checked, one_of, shown
from plant_model.drawing.bearing_table import Bearing, by_designation, known_designations
from plant_model.drawing.cells import SHORTEST
from plant_model.drawing.coolants import ALLOWED, coolant
from plant_model.drawing.form import (
    BearingForm,
    HousingForm,
    MotorForm,
    PageForm,
    PatchForm,
    ShaftForm,
    StretchForm,
)
from plant_model.drawing.known import Known
from plant_model.drawing.materials import MATERIALS, Material

TOUCH = 0.01
"""Stretches touch if their ends are nearer than this [mm]: set on no data."""

ENCLOSURE = "enclosure"


@dataclass(frozen=True)
class Seat:
    """A bearing set on the shaft.

    Attributes
    ----------
    form : BearingForm
    bearing : Bearing
        One of its bearings.
    spans : tuple of (float, float)
        Start and end of each bearing of the set [mm].
    """

    form: BearingForm
    bearing: Bearing
    spans: tuple[tuple[float, float], ...]


class Drawing:
    """A page with all its parts found and checked.

    Parameters
    ----------
    table : dict
        The parsed page.
    source : path
        The file, for refusals.

    Raises
    ------
    BadInput
        For the first error, in one line.
    """

    def __init__(self, table: dict[str, Any], source: str | Path) -> None:
        self.source = source
        self.form = checked(PageForm, table, source)
        self.materials = dict(MATERIALS) | self._own_materials()
        self._names()
        self._inputs()
        self._stretches("shaft", self.form.shaft)
        self._stretches("housing", self.form.housing)
        self._shaft_in_housing()
        self.seats = [self._seat(i, entry) for i, entry in enumerate(self.form.bearings)]
        self._seats_together()
        self._motor()
        self._jackets()
        self._carriers()
        self._tool()

    def refuse(self, place: str, problem: str) -> BadInput:
        """Return the refusal of a place.

        Parameters
        ----------
        place : str
            In the page, dotted: ``bearings.0.at``.
        problem : str
            The value and what is allowed.

        Returns
        -------
        BadInput
            For the caller to raise.
        """
        return BadInput(self.source, place, problem)

    def one_of(self, place: str, name: object, known: Iterable[str]) -> str:
        """Return the name if it is known, else refuse it and list the known ones.

        Parameters
        ----------
        place : str
            Place of the name in the page, dotted.
        name : object
            The value there.
        known : iterable of str
            Allowed names.

        Raises
        ------
        BadInput
            If it is not a text or not one of them; the closest is suggested.
        """
        return one_of(self.source, place, name, known)

    def span_of(self, part: str) -> tuple[float, float]:
        """Return start and end of the ``shaft`` or the ``housing`` [mm].

        Parameters
        ----------
        part : {"shaft", "housing"}

        Returns
        -------
        start, end : float
            From the rear to the nose, along the axis [mm].
        """
        stretches = getattr(self.form, part).stretches
        return stretches[0].start, stretches[-1].end

    def stretch_at(self, part: str, place: float) -> StretchForm:
        """Return the stretch of shaft or housing at a place; at a step, the one towards the nose.

        Parameters
        ----------
        part : {"shaft", "housing"}
        place : float
            Along the axis [mm].
        """
        stretches: Sequence[StretchForm] = getattr(self.form, part).stretches
        return next((s for s in reversed(stretches) if s.start <= place), stretches[0])

    def material(self, stretch: StretchForm, part: str) -> Material:
        """Return the material of a stretch.

        Parameters
        ----------
        stretch : StretchForm
        part : {"shaft", "housing"}
            Its material is used if the stretch names none.
        """
        name: str = stretch.material or getattr(self.form, part).material
        return self.materials[name]

    @property
    def highest_speed(self) -> float:
        """The highest speed that the page's inputs allow [r/min]."""
        speed = self.form.inputs["speed"]
        return max(speed.high, -speed.low)

    @property
    def located(self) -> Seat:
        """The bearing set that locates the shaft."""
        return next(seat for seat in self.seats if seat.form.locates)

    def air_names(self) -> list[str]:
        """Return the names of the air that surfaces may face."""
        air = [name for name, entry in self.form.inputs.items() if entry.unit == "degC"]
        return [*air, ENCLOSURE] if self.form.enclosure else air

    def _own_materials(self) -> dict[str, Material]:
        materials = {}
        for name, entry in self.form.materials.items():
            heat = entry.density * entry.specific_heat
            materials[name] = Material(
                name,
                Known(heat, 0.92 * heat, 1.08 * heat, "J/(m3 K)", f"page, material {name}"),
                entry.conductivity.known("W/(m K)"),
                entry.expansion.known("1e-6/K", 0.1),
                entry.density,
            )
        return materials

    def _names(self) -> None:
        form = self.form
        for place, names in (
            ("bearings", [entry.name for entry in form.bearings]),
            ("jackets", [entry.name for entry in form.jackets]),
            ("carriers", [entry.name for entry in form.carriers]),
        ):
            for i, name in enumerate(names):
                if name in names[:i]:
                    raise self.refuse(f"{place}.{i}.name", f"the name {name} stands twice")

    def _inputs(self) -> None:
        inputs = self.form.inputs
        for name, unit in (("speed", "rpm"), ("ambient", "degC")):
            if name not in inputs:
                raise self.refuse("inputs", f"{name} is missing: an input in {unit} of this name")
            if inputs[name].unit != unit:
                raise self.refuse(f"inputs.{name}.unit", f"{inputs[name].unit!r} must be {unit}")
        if not self.highest_speed > 0.0:
            low, high = inputs["speed"].low, inputs["speed"].high
            raise self.refuse("inputs.speed", f"{low:g} to {high:g} rpm is no range to turn in")

    def _stretches(self, part: str, form: ShaftForm | HousingForm) -> None:
        self.one_of(f"{part}.material", form.material, self.materials)
        before: StretchForm | None = None
        for i, stretch in enumerate(form.stretches):
            place = f"{part}.stretches.{i}"
            if stretch.material is not None:
                self.one_of(f"{place}.material", stretch.material, self.materials)
            if not stretch.start + SHORTEST <= stretch.end:
                raise self.refuse(
                    place,
                    f"from {stretch.start:g} to {stretch.end:g} mm: must be {SHORTEST:g} mm or more"
                    " long",
                )
            if not stretch.inner < stretch.outer:
                raise self.refuse(
                    f"{place}.inner", f"{stretch.inner:g} mm must be below outer {stretch.outer:g}"
                )
            if before is not None and abs(stretch.start - before.end) > TOUCH:
                what = "overlaps" if stretch.start < before.end else "leaves a gap to"
                raise self.refuse(
                    f"{place}.from",
                    f"{stretch.start:g} mm {what} the stretch before, which ends at"
                    f" {before.end:g}: stretches must touch, from the rear to the nose",
                )
            before = stretch
        if part == "shaft":
            self._inside("shaft.gauge_line", self.form.shaft.gauge_line, "shaft")

    def _inside(self, place: str, at: float, part: str) -> None:
        low, high = self.span_of(part)
        if not low - TOUCH <= at <= high + TOUCH:
            raise self.refuse(
                place, f"{at:g} mm is outside the {part}, which is from {low:g} to {high:g} mm"
            )

    def _shaft_in_housing(self) -> None:
        for i, shaft in enumerate(self.form.shaft.stretches):
            for housing in self.form.housing.stretches:
                both = min(shaft.end, housing.end) - max(shaft.start, housing.start)
                if both > TOUCH and not shaft.outer < housing.inner:
                    raise self.refuse(
                        f"shaft.stretches.{i}.outer",
                        f"{shaft.outer:g} mm does not fit into the housing, which is"
                        f" {housing.inner:g} mm inside",
                    )

    def _seat(self, i: int, form: BearingForm) -> Seat:
        place = f"bearings.{i}"
        bearing = self._bearing(place, form)
        spacing = form.spacing or bearing.width
        if spacing < bearing.width - TOUCH:
            raise self.refuse(
                f"{place}.spacing",
                f"{spacing:g} mm is below the bearing's width of {bearing.width:g}",
            )
        rear = form.at - spacing * (form.count - 1) / 2.0
        middles = [rear + spacing * k for k in range(form.count)]
        spans = tuple((at - bearing.width / 2.0, at + bearing.width / 2.0) for at in middles)
        first, last = spans[0][0], spans[-1][1]
        for part in ("shaft", "housing"):
            low, high = self.span_of(part)
            if first < low - TOUCH or last > high + TOUCH:
                raise self.refuse(
                    f"{place}.at",
                    f"at {form.at:g} mm it sits from {first:g} to {last:g} mm, which is outside the"
                    f" {part}: that is from {low:g} to {high:g} mm",
                )
        self._sleeve(f"{place}.sleeve", form, bearing, (first, last))
        return Seat(form, bearing, spans)

    def _sleeve(
        self, place: str, form: BearingForm, bearing: Bearing, seats: tuple[float, float]
    ) -> None:
        sleeve = form.sleeve
        if sleeve is None:
            return
        for end in (sleeve.start, sleeve.end):
            self._inside(place, end, "housing")
        if sleeve.start > seats[0] + TOUCH or sleeve.end < seats[1] - TOUCH:
            raise self.refuse(
                place,
                f"{sleeve.start:g} to {sleeve.end:g} mm does not hold the bearings, which sit at"
                f" {seats[0]:g} to {seats[1]:g} mm",
            )
        self.one_of(f"{place}.material", sleeve.material, self.materials)
        if sleeve.outer is not None and not bearing.outside < sleeve.outer:
            raise self.refuse(
                f"{place}.outer",
                f"{sleeve.outer:g} mm must be above the bearing's outside of {bearing.outside:g}",
            )

    def _bearing(self, place: str, form: BearingForm) -> Bearing:
        in_table: Bearing | None = None
        if form.designation is not None:
            in_table = by_designation(form.designation)
            if in_table is None:
                raise self.refuse(
                    f"{place}.designation",
                    f"{shown(form.designation)} is not known; known are {known_designations()};"
                    " else give bore, outside and width",
                )
        bore, outside, width = (
            given if given is not None else getattr(in_table, key, None)
            for key, given in (
                ("bore", form.bore),
                ("outside", form.outside),
                ("width", form.width),
            )
        )
        if bore is None or outside is None or width is None:
            raise self.refuse(f"{place}.designation", "is missing: or bore, outside and width [mm]")
        if not bore < outside:
            raise self.refuse(f"{place}.bore", f"{bore:g} mm must be below outside {outside:g}")
        kind = in_table.kind if in_table else ("roller" if form.rollers else "ball")
        return Bearing(form.designation or "own numbers", kind, bore, outside, width)

    def _seats_together(self) -> None:
        located = [seat.form.name for seat in self.seats if seat.form.locates]
        if len(located) != 1:
            raise self.refuse(
                "bearings",
                f"{len(located)} of them locate the shaft: exactly one must say locates = true",
            )
        spans = sorted((span, seat.form.name) for seat in self.seats for span in seat.spans)
        for (first, name), (second, other) in pairwise(spans):
            if second[0] < first[1] - TOUCH:
                raise self.refuse(
                    "bearings",
                    f"{name} and {other} overlap: one ends at {first[1]:g} mm, the next begins at"
                    f" {second[0]:g}",
                )

    def _motor(self) -> None:
        motor = self.form.motor
        if motor is None:
            return
        if not motor.start < motor.end:
            raise self.refuse("motor", f"from {motor.start:g} must be below to {motor.end:g} mm")
        for key, end in (("from", motor.start), ("to", motor.end)):
            for part in ("shaft", "housing") if motor.drive == "built-in" else ("shaft",):
                self._inside(f"motor.{key}", end, part)
        if motor.loss is None and motor.drive == "built-in":
            plate = (motor.power, motor.efficiency, motor.rated_speed)
            if None in plate:
                raise self.refuse(
                    "motor.loss",
                    "is missing: W/(1000 r/min), or power [kW], efficiency and rated_speed",
                )
        if motor.drive == "belt":
            self.one_of("motor.into", motor.into, [c.name for c in self.form.carriers])
        else:
            self._motor_fits(motor)

    def _motor_fits(self, motor: MotorForm) -> None:
        shaft = self.stretch_at("shaft", (motor.start + motor.end) / 2.0)
        housing = self.stretch_at("housing", (motor.start + motor.end) / 2.0)
        if motor.rotor_outer is None:
            raise self.refuse("motor.rotor_outer", "is missing: the rotor's diameter [mm]")
        sizes = [
            ("shaft", shaft.outer),
            ("rotor_outer", motor.rotor_outer),
            ("stator_outer", motor.stator_outer or housing.inner),
            ("the housing's inside", housing.inner + TOUCH),
        ]
        for (name, size), (other, larger) in pairwise(sizes):
            if not size < larger:
                raise self.refuse(
                    "motor.rotor_outer" if name == "shaft" else f"motor.{name}",
                    f"{name} {size:g} mm must be below {other} {larger:g}",
                )

    def _jackets(self) -> None:
        names: list[str] = []
        for i, jacket in enumerate(self.form.jackets):
            place = f"jackets.{i}"
            self._patch(place, jacket, self.form.jackets[:i])
            if coolant(jacket.fluid) is None:
                raise self.refuse(
                    f"{place}.fluid",
                    f"{shown(jacket.fluid)} is not one of {ALLOWED}",
                )
            if jacket.after is not None:
                self.one_of(f"{place}.after", jacket.after, names)
            elif self.form.inputs.get(jacket.inlet) is None:
                raise self.refuse(f"{place}.inlet", f"there is no input {jacket.inlet}")
            elif self.form.inputs[jacket.inlet].unit != "degC":
                raise self.refuse(f"{place}.inlet", f"the input {jacket.inlet} is not in degC")
            names.append(jacket.name)

    def _patch(self, place: str, patch: PatchForm, beside: Iterable[PatchForm] = ()) -> None:
        """Refuse a patch that is not on the housing, or overlaps one *beside* it."""
        if not patch.start < patch.end:
            raise self.refuse(place, f"from {patch.start:g} must be below to {patch.end:g} mm")
        for key, end in (("from", patch.start), ("to", patch.end)):
            self._inside(f"{place}.{key}", end, "housing")
        for other in beside:
            if patch.overlaps(other, TOUCH):
                raise self.refuse(
                    place,
                    f"from {patch.start:g} to {patch.end:g} mm overlaps the one from"
                    f" {other.start:g} to {other.end:g} mm: its heat would count twice",
                )

    def _carriers(self) -> None:
        names = [carrier.name for carrier in self.form.carriers]
        held: list[PatchForm] = []
        for i, carrier in enumerate(self.form.carriers):
            place = f"carriers.{i}"
            self.one_of(f"{place}.material", carrier.material, self.materials)
            if carrier.on is not None:
                self.one_of(f"{place}.on", carrier.on, [n for n in names if n != carrier.name])
            if carrier.holds is not None:
                self._patch(f"{place}.holds", carrier.holds, held)
                held.append(carrier.holds)
            if carrier.air is not None:
                self.one_of(f"{place}.air", carrier.air, self.air_names())
            for j, bend in enumerate(carrier.bends):
                self.one_of(f"{place}.bends.{j}.against", bend.against, names)
            if carrier.feed is not None:
                self.one_of(f"{place}.feed.input", carrier.feed.input, self.form.inputs)
        if self.form.housing.air is not None:
            self.one_of("housing.air", self.form.housing.air, self.air_names())
        for i, face in enumerate(self.form.housing.faces):
            place = f"housing.faces.{i}"
            self._patch(place, face, self.form.housing.faces[:i])
            if face.air is not None:
                self.one_of(f"{place}.air", face.air, self.air_names())

    def _tool(self) -> None:
        if self.form.tool is not None:
            self.one_of("tool.material", self.form.tool.material, self.materials)
