"""Reading machine files: TOML in, a checked :class:`~plant_model.machine.Machine` out.

`plant_model.machine_forms` declares the general form; the form of each kind of link, source or part
is declared by the effect that defines its law. A refusal names the file, the place, the value and
what is allowed.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import zip_longest
from pathlib import Path
from typing import Any

from measurement.errors import BadInput, checked, near, one_of, shown
from measurement.files import read_toml
from plant_model.drawing.expand import expanded, is_page
from plant_model.effects import Effect, ItemSpec, catalogue, item_kinds
from plant_model.effects.base import possible
from plant_model.item_forms import NumberSpec
from plant_model.limits import CAPACITY
from plant_model.machine import FAMILIES, FIVE_POINT, REST, Axis, Input, Item, Machine, Node, Sensor
from plant_model.machine_forms import (
    DirectForm,
    FileForm,
    InputForm,
    ParameterForm,
    TiedForm,
    is_item_name,
    naming_places,
)
from plant_model.parameters import NUMBERS, Parameter

KINDS_OF_AXES = ("d", "drift_", "offset_", "error_")
RESERVED = {"time", "tool_length", "noise_seed", REST}.union(
    f"{kind}{axis}" for kind in KINDS_OF_AXES for axis in "XYZ"
)
"""Names of the plant's other signals, and the keyword of ``start``."""

SHIPPED = Path(__file__).parent / "machines"


def shipped_machines() -> list[str]:
    """Return the names of the machines shipped with the package."""
    return sorted(path.stem for path in SHIPPED.glob("*.toml"))


def machine_path(name_or_path: str | Path) -> Path:
    """Return the file of a shipped machine, or the path as given.

    Parameters
    ----------
    name_or_path : str or path
        With the ending ``.toml`` it is a file, or a shipped one if it names no folder.

    Raises
    ------
    BadInput
        If there is neither such a file nor such a machine.
    """
    path = Path(name_or_path)
    if path.suffix == ".toml" or path.is_file():
        if not path.is_file():
            inside = SHIPPED / path.name
            if str(path) == path.name and inside.is_file():
                return inside
            raise BadInput(path, "", "there is no such file")
        return path
    shipped = shipped_machines()
    if str(name_or_path) in shipped:
        return SHIPPED / f"{name_or_path}.toml"
    problem = f"is neither a file nor one of the machines {', '.join(shipped)}"
    raise BadInput(str(name_or_path), "", problem + near(name_or_path, shipped))


def read_machine(name_or_path: str | Path) -> Machine:
    """Read a machine file in lumps, a page of a drawing, or a shipped machine by name.

    Parameters
    ----------
    name_or_path : str or path
        For example ``jig_borer`` or ``my_machine.toml``.

    Returns
    -------
    Machine

    Raises
    ------
    BadInput
        For the first thing wrong in it, in one line.
    """
    path = machine_path(name_or_path)
    return machine_from_table(machine_table(path), path)


def machine_table(path: Path) -> dict[str, Any]:
    """Return a machine file's table, with a page of a drawing expanded.

    Raises
    ------
    BadInput
        If the file cannot be read, or for the first error in a page.
    """
    table = read_toml(path)
    return expanded(table, path) if is_page(table) else table


def machine_from_table(table: dict[str, Any], source: str | Path) -> Machine:
    """Check a machine given as a parsed TOML table; see :func:`read_machine`.

    Parameters
    ----------
    table : dict
        In lumps; a page must be expanded first.
    source : str or path
        The file, for refusals.

    Returns
    -------
    Machine

    Raises
    ------
    BadInput
        For the first thing wrong in it, in one line.
    """
    with naming_places(table):
        return _Reader(checked(FileForm, table, source), source).machine()


class _Reader:
    """Turns the checked outer form into a machine and checks its references."""

    def __init__(self, form: FileForm, source: str | Path) -> None:
        self.form, self.source = form, source
        self.inputs = list(form.inputs)
        self.boundaries = [name for name, entry in form.inputs.items() if entry.unit == "degC"]
        self.nodes = [node.name for node in form.nodes]
        self.numbers = {
            name: self._in_range(f"numbers.{name}", entry) for name, entry in form.numbers.items()
        }

    def refuse(self, place: str, problem: str) -> BadInput:
        return BadInput(self.source, place, problem)

    def machine(self) -> Machine:
        form = self.form
        self._unique("nodes", self.nodes)
        clash = set(self.nodes) & set(self.inputs)
        if clash:
            raise self.refuse("nodes", f"{min(clash)} is the name of an input as well")
        items = [item for family in FAMILIES for item in self._items(family)]
        sensors = self._sensors()
        warm = [*self.boundaries, *(sensor.name for sensor in sensors)]
        nodes = tuple(
            Node(
                node.name,
                self._parameter(f"nodes.{i}.capacity", node.capacity, CAPACITY),
                self._one_of(f"nodes.{i}.start", node.start, [*warm, REST]),
                node.start_share,
            )
            for i, node in enumerate(form.nodes)
        )
        effects = self._effects([*(sensor.name for sensor in sensors), *self._displacements()])
        machine = Machine(
            name=form.name,
            title=form.title,
            description=form.description,
            inputs=tuple(
                self._input(f"inputs.{name}", name, entry) for name, entry in form.inputs.items()
            ),
            nodes=nodes,
            items=tuple(items),
            sensors=sensors,
            rig=form.rig.model_dump(),
            axis=Axis(**form.axis.model_dump()),
            effects=effects,
            references=form.references,
            numbers=self.numbers,
        )
        self._cross_checks(machine)
        return machine

    def _unique(self, place: str, names: Iterable[str]) -> None:
        seen: set[str] = set()
        for name in names:
            if name in seen:
                raise self.refuse(place, f"the name {name} stands twice")
            seen.add(name)

    def _free(self, place: str, name: str, taken: Iterable[str] = ()) -> None:
        """Refuse a name that another signal of the plant has."""
        if name in RESERVED or name in taken:
            raise self.refuse(
                place,
                f"{shown(name)} is not allowed: it is the name of an input, an output or the time",
            )

    def _one_of(self, place: str, name: object, known: Iterable[str]) -> str:
        return one_of(self.source, place, name, known)

    def _input(self, place: str, name: str, entry: InputForm) -> Input:
        self._free(place, name)
        if not entry.low < entry.high:
            raise self.refuse(place, f"low {entry.low:g} must be below high {entry.high:g}")
        if entry.default is not None and not entry.low <= entry.default <= entry.high:
            raise self.refuse(
                f"{place}.default",
                f"{entry.default:g} is outside {entry.low:g}..{entry.high:g} {entry.unit}",
            )
        if not entry.column.endswith(f"_{entry.unit}"):
            raise self.refuse(f"{place}.column", f"{entry.column} does not end in _{entry.unit}")
        return Input(name, entry.unit, entry.column, entry.low, entry.high, entry.default)

    def _sensors(self) -> tuple[Sensor, ...]:
        sensors = []
        for i, entry in enumerate(self.form.sensors):
            of = self._one_of(f"sensors.{i}.of", entry.of, [*self.nodes, *self.boundaries])
            sensors.append(Sensor(entry.name, "degC", of, entry.noise, entry.resolution))
        names = [*(sensor.name for sensor in sensors), *self._displacements()]
        self._unique("sensors and rig", names)
        places = [f"sensors.{i}.name" for i in range(len(sensors))]
        for place, name in zip_longest(places, names, fillvalue="rig"):
            self._free(place, name, self.inputs)
        return tuple(sensors)

    def _displacements(self) -> list[str]:
        rig = self.form.rig
        if isinstance(rig, DirectForm):
            return list(rig.axes)
        return [getattr(rig, role) for role in FIVE_POINT]

    def _parameter(self, place: str, table: object, spec: NumberSpec) -> Parameter:
        if not isinstance(table, dict):
            raise self.refuse(
                place, f"{shown(table)} is not a table of value, unit, low, high and source"
            )
        if "number" in table:
            return self._tied(place, table, spec)
        form = checked(ParameterForm, table, self.source, place)
        if form.unit != spec.unit:
            raise self.refuse(
                f"{place}.unit", f"{shown(form.unit)} is not allowed: it is {spec.unit}"
            )
        if not spec.low <= form.low <= form.high <= spec.high:
            raise self.refuse(
                place,
                f"the range {form.low:g}..{form.high:g} must ascend and lie in"
                f" {spec.low:g}..{spec.high:g} {spec.unit}",
            )
        return self._in_range(place, form)

    def _in_range(self, place: str, form: ParameterForm) -> Parameter:
        if not form.low <= form.high:
            raise self.refuse(place, f"the range {form.low:g}..{form.high:g} must ascend")
        if not form.low <= form.value <= form.high:
            raise self.refuse(
                f"{place}.value",
                f"{form.value:g} is outside its range {form.low:g}..{form.high:g} {form.unit}",
            )
        return Parameter(**form.model_dump())

    def _tied(self, place: str, table: dict[str, Any], spec: NumberSpec) -> Parameter:
        """Return a parameter that follows a named number by a factor."""
        form = checked(TiedForm, table, self.source, place)
        name = self._one_of(f"{place}.number", form.number, self.numbers)
        number = self.numbers[name]
        if form.unit not in {None, spec.unit}:
            raise self.refuse(
                f"{place}.unit", f"{shown(form.unit)} is not allowed: it is {spec.unit}"
            )
        if form.factor is None and number.unit != spec.unit:
            raise self.refuse(
                f"{place}.factor", f"is missing: {name} is in {number.unit}, this in {spec.unit}"
            )
        factor = 1.0 if form.factor is None else form.factor
        ends = sorted((number.low * factor, number.high * factor))
        if not spec.low <= ends[0] <= ends[1] <= spec.high:
            raise self.refuse(
                place,
                f"{name} makes it {ends[0]:g}..{ends[1]:g}, outside"
                f" {spec.low:g}..{spec.high:g} {spec.unit}",
            )
        tied = Parameter(
            0.0, spec.unit, 0.0, 0.0, number.source, tied=f"{NUMBERS}{name}", factor=factor
        )
        return tied.following(number.value)

    def _items(self, family: str) -> list[Item]:
        kinds = {kind: spec for (of, kind), (_, spec) in item_kinds().items() if of == family}
        items = []
        for i, table in enumerate(getattr(self.form, family)):
            place = f"{family}.{i}"
            if "kind" not in table:
                raise self.refuse(f"{place}.kind", "is missing")
            kind = self._one_of(f"{place}.kind", table["kind"], sorted(kinds))
            items.append(self._item(place, family, kind, kinds[kind], table))
        self._unique(family, (item.name for item in items))
        return items

    def _item(
        self, place: str, family: str, kind: str, spec: ItemSpec, table: dict[str, Any]
    ) -> Item:
        for key in table:
            if key not in {"kind", "name", *spec.refs, *spec.numbers}:
                raise self.refuse(f"{place}.{key}", "is not a known field")
        refs = {}
        for role, form in spec.refs.items():
            if role not in table:
                raise self.refuse(f"{place}.{role}", "is missing")
            refs[role] = self._refs(f"{place}.{role}", table[role], form)
        name = table.get("name", "-".join(refs.get("between", ())) or kind)
        if not is_item_name(name):
            raise self.refuse(f"{place}.name", f"{shown(name)} is not a name")
        numbers = {}
        for key, number in spec.numbers.items():
            if key in table:
                numbers[key] = self._parameter(f"{place}.{key}", table[key], number)
            elif number.default is not None:
                value = number.default
                numbers[key] = Parameter(value, number.unit, value, value, "default of the kind")
            else:
                raise self.refuse(f"{place}.{key}", "is missing")
        return Item(family, name, kind, refs, numbers)

    def _refs(self, place: str, given: object, form: str) -> tuple[str, ...]:
        driving = [name for name in self.inputs if name not in self.boundaries]
        groups = {"node": self.nodes, "boundary": self.boundaries, "input": driving}

        def allowed(part: str) -> list[str]:
            return [name for group in part.split("|") for name in groups[group]]

        if form.endswith("*"):
            names = given if isinstance(given, list) else [given]
            if not names:
                raise self.refuse(place, "at least one name is needed")
            return tuple(
                self._one_of(f"{place}.{i}", name, allowed(form[:-1]))
                for i, name in enumerate(names)
            )
        parts = form.split(",")
        names = given if isinstance(given, list) and len(parts) > 1 else [given]
        if len(names) != len(parts):
            raise self.refuse(place, f"{shown(given)} is not a list of {len(parts)} names")
        refs = tuple(
            self._one_of(place, name, allowed(part))
            for name, part in zip(names, parts, strict=True)
        )
        if len(set(refs)) < len(refs):
            raise self.refuse(place, f"{shown(given)} joins something to itself")
        return refs

    def _effects(self, channels: list[str]) -> dict[str, dict[str, Parameter]]:
        effects_by_name = catalogue()
        effects = {}
        for key, table in self.form.effects.items():
            name, _, channel = key.partition(":")
            effect = effects_by_name[self._one_of(f"effects.{key}", name, effects_by_name)]
            if effect.on_channel:
                self._one_of(f"effects.{key}", channel, channels)
            given = {}
            for parameter, entry in table.items():
                place = f"effects.{key}.{parameter}"
                nominal = effect.parameters[self._one_of(place, parameter, effect.parameters)]
                spec = NumberSpec(nominal.unit, *possible(effect, parameter))
                given[parameter] = self._parameter(place, entry, spec)
            effects[key] = dict(effect.parameters) | given
        return effects

    def _cross_checks(self, machine: Machine) -> None:
        self._only_one(machine)
        for item in machine.items:
            needed = item_kinds()[item.family, item.kind][0]
            if needed not in machine.effects:
                raise self.refuse(
                    f"{item.family}.{item.name}",
                    f"is a {item.kind}, but the effect {needed} is not in force",
                )
            if item.kind in {"shaft", "housing", "ring"} and not any(
                other.kind == "located" for other in machine.items
            ):
                raise self.refuse("structure", f"a {item.kind} needs one item of kind located")
        for key in machine.effects:
            effect = self._of_key(machine, key)
            for needed in effect.conductance_inputs:
                if needed not in self.inputs:
                    raise self.refuse(f"effects.{key}", f"needs an input called {needed}")
            for needed in effect.needs:
                if needed not in machine.effects:
                    raise self.refuse(f"effects.{key}", f"needs the effect {needed} in force")

    def _of_key(self, machine: Machine, key: str) -> type[Effect]:
        """Return the effect that a key names, after checking its driver on this machine."""
        name, _, driver = key.partition(":")
        effect = catalogue()[name]
        if driver and not effect.on_channel:
            drivers = effect.drivers(machine)
            if not drivers:
                problem = f"{name} does not act on one sensor, and nothing else can drive it here"
                raise self.refuse(f"effects.{key}", problem)
            self._one_of(f"effects.{key}", driver, drivers)
        return effect

    def _only_one(self, machine: Machine) -> None:
        for (family, kind), (_, spec) in item_kinds().items():
            if spec.only_one and len(machine.of_kind(family, kind)) > 1:
                raise self.refuse(family, spec.only_one)
