"""Writes the tables of the documentation that come from the code: ``python -m docs.make_tables``.

A table stands between two comments, ``<!-- begin NAME: ... -->`` and ``<!-- end NAME -->``; what is
between them is replaced. A test compares the pages with what this script would write.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from build_fmu import DEFAULT_MACHINE, DEFAULT_MODEL
from docs.form_tables import meanings, merged, plain, rows
from fmu_compensator.runtime import fmi_slave as compensator_slave
from fmu_compensator.runtime.checks import Sensor
from fmu_compensator.runtime.gaussian import Gaussian
from fmu_compensator.runtime.limits import Limits
from fmu_compensator.runtime.modelfile import Model, load_model
from fmu_compensator.runtime.spare import Spare
from fmu_packaging.variables import Variable
from gateway.busload import frame_bits
from gateway.mapfile import InputMap, MapFile, OutputMap
from gateway.mapping import read_database
from gateway.page import load_text, named_rows
from measurement.files import write_atomically
from measurement.units import UNITS
from plant_model import fmi_slave as plant_slave
from plant_model.drawing.form import PageForm
from plant_model.effects import Effect, catalogue, item_kinds
from plant_model.item_forms import NumberSpec
from plant_model.machine import FAMILIES, Machine
from plant_model.machine_file import read_machine
from plant_model.machine_forms import FileForm
from plant_model.parameters import Parameter
from scenarios.scenario import Settings
from scenarios.signals import kinds as kinds_of_signals

DOCS = Path(__file__).resolve().parent
PAGES = ("drawing.md", "effects.md", "fmu.md", "formats.md", "gateway.md", "gateway_maps.md")
MARKS = re.compile(r"(<!-- begin (\w+): [^\n]* -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(map(_cell, row))} |" for row in lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def code(text: str) -> str:
    """Return *text* as code."""
    return f"`{text}`"


def with_unit(value: str, unit: str) -> str:
    """Return a value and its unit; a pure number has none."""
    return value if unit == "1" else f"{value} {unit}"


def described(parameter: Parameter) -> str:
    """Return a parameter's nominal value and range."""
    span = f"{parameter.value:g} ({parameter.low:g} to {parameter.high:g})"
    return with_unit(span, parameter.unit)


def effects() -> str:
    """Return the catalogue of effects."""
    shipped = read_machine(DEFAULT_MACHINE)
    rows = [_effect_row(effect, shipped) for effect in catalogue().values()]
    head = ("Effect", "What it is", "Amplitude: nominal (range)", "Other parameters", "Remarks")
    return table(head, rows)


def _effect_row(effect: type[Effect], shipped: Machine) -> list[str]:
    name, drivers = effect.name, effect.drivers(shipped)
    others = [
        f"{code(key)} {described(value)}"
        for key, value in effect.parameters.items()
        if key != effect.amplitude
    ]
    amplitude = f"{code(effect.amplitude)} {described(effect.parameters[effect.amplitude])}"
    remarks = []
    if name in shipped.effects:
        remarks.append(f"in force in {code(DEFAULT_MACHINE)}")
    if effect.on_channel:
        remarks.append(f'on one thermometer: `[effects."{name}:T1"]`')
    if drivers:
        remarks.append(f"drivers in {code(DEFAULT_MACHINE)}: {', '.join(map(code, drivers))}")
    if effect.needs:
        remarks.append(f"needs {', '.join(map(code, effect.needs))}")
    if effect.conductance_inputs:
        remarks.append(f"needs an input {', '.join(map(code, effect.conductance_inputs))}")
    what = f"**{effect.title}.** {effect.explanation}"
    return [code(name), what, amplitude, "; ".join(others), "; ".join(remarks)]


def kinds() -> str:
    """Return the kinds of links, sources and parts of the structure."""
    rows = []
    for family in FAMILIES:
        for (of, kind), (effect, spec) in sorted(item_kinds().items()):
            if of == family:
                refs = [f"{code(role)}: {_form(form)}" for role, form in spec.refs.items()]
                numbers = [_number(key, number) for key, number in spec.numbers.items()]
                cells = [code(family), code(kind), "; ".join(refs), "; ".join(numbers)]
                rows.append([*cells, spec.law, code(effect)])
    head = ("Table", "`kind`", "What it joins", "Numbers", "Law", "Effect that must be in force")
    return table(head, rows)


def _form(form: str) -> str:
    parts = [part.removesuffix("*").replace("|", " or ") for part in form.split(",")]
    if form.endswith("*"):
        return f"one {parts[0]} or a list of them"
    return f"[{', '.join(parts)}]" if len(parts) > 1 else parts[0]


def _number(key: str, number: NumberSpec) -> str:
    span = with_unit(f"{number.low:g} to {number.high:g}", number.unit)
    usual = "" if number.default is None else f", {number.default:g} if left out"
    return f"{code(key)} {span}{usual}"


def units() -> str:
    """Return the units of run-file columns."""
    rows = [
        [
            code(f"_{unit.suffix}"),
            unit.quantity,
            f"{unit.low:g} to {unit.high:g}",
            "holds its last value" if unit.switches else "straight line",
        ]
        for unit in UNITS.values()
    ]
    return table(("Ending", "Quantity", "Allowed", "Between two samples"), rows)


def compensator_variables() -> str:
    """Return the variables of the shipped compensator FMU."""
    return _variables(compensator_slave.variables(load_model(DEFAULT_MODEL)))


def plant_variables() -> str:
    """Return the variables of the shipped plant FMU, without the machine's parameters."""
    declared = plant_slave.variables(read_machine(DEFAULT_MACHINE))
    return _variables(
        entry for entry in declared if not entry.is_parameter or "." not in entry.name
    )


def _variables(declared: Iterable[Variable]) -> str:
    rows = []
    for entry in declared:
        numbers = (entry.low, entry.high)
        span = "" if None in numbers else f"{entry.low:g} to {entry.high:g}"
        unit = entry.unit if entry.kind == "real" else ""
        start = "" if entry.is_output or entry.start is None else _shown(entry.start)
        facts = [entry.causality, entry.kind, unit, span, start]
        rows.append(([entry.name], facts, entry.description.split(" ")))
    merged = rows[:1]
    for names, facts, words in rows[1:]:
        before = merged[-1]
        alike = before[1] == facts and _stem(before[0][-1]) == _stem(names[0])
        if alike and len(before[2]) == len(words):
            shared = [a if a == b else "…" for a, b in zip(before[2], words, strict=True)]
            merged[-1] = ([*before[0], *names], facts, shared)
        else:
            merged.append((names, facts, words))
    return table(
        ("Variable", "Causality", "Type", "Unit", "Range", "Start", "Meaning"),
        ([_span_of(names), *facts, " ".join(words)] for names, facts, words in merged),
    )


def _stem(name: str) -> str:
    """Return what variables have in common that differ by a number or an axis."""
    return re.sub(r"\d+$|(?<=^d)[XYZ]|[XYZ]$", "", name)


def _span_of(names: Sequence[str]) -> str:
    if len(names) < 4:
        return ", ".join(map(code, names))
    return f"{code(names[0])} to {code(names[-1])}"


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


FIELDS = ("Field", "Allowed", "If left out", "Meaning")


def machine_fields() -> str:
    """Return the fields of a machine file."""
    return table(FIELDS, merged(rows(FileForm)))


def page_fields() -> str:
    """Return the fields of a drawing's page that a machine file has not."""
    return table(FIELDS, merged(rows(PageForm, without=FileForm.model_fields)))


def scenario_fields() -> str:
    """Return the fields of a scenario file."""
    return table(FIELDS, merged(rows(Settings)))


def map_fields() -> str:
    """Return the keys of a map of the gateway; an output's only where an input has none such."""
    found = [
        *rows(MapFile, without=("inputs", "outputs")),
        *rows(InputMap, "inputs.NAME."),
        *rows(OutputMap, "outputs.NAME.", without=InputMap.model_fields),
    ]
    return table(FIELDS, merged(found))


def signals() -> str:
    """Return the kinds of signals and their fields."""
    found = []
    for name, kind in sorted(kinds_of_signals().items()):
        fields = [
            f"{field} {allowed}" + ("" if default[:1] == "*" else f" ({default or 'optional'})")
            for field, allowed, default, _ in rows(kind, without=("kind",))
        ]
        told = plain((kind.__doc__ or "").partition(": ")[2])
        found.append([code(name), "; ".join(fields), told[:1].upper() + told[1:]])
    return table(("Signal `kind`", "Fields", "Meaning"), found)


def compensator_fields() -> str:
    """Return the fields of a compensator file, as the classes that read it describe them."""
    found = []
    for place, form, names in COMPENSATOR:
        told = meanings(form)
        found += [
            [code(f"{place}{name}"), told[name].replace("None", "null")] for name in names or told
        ]
    return table(("Field", "Meaning"), merged(found))


def bus_frames() -> str:
    """Return the frames of the bus and its load."""
    database = read_database()
    rows = [
        (
            frame.name,
            f"0x{frame.frame_id:03X}",
            frame.sender,
            "on demand" if frame.event else f"{frame.cycle_s * 1e3:g} ms",
            " " if frame.event else f"{frame.timeout_s * 1e3:g} ms",
            f"0x{frame.data_id:04X}",
            str(frame_bits(frame.size)),
        )
        for frame in database.frames
    ]
    head = ("Frame", "Id", "From", "Every", "Late after", "Data id", "Bits, worst")
    return f"{table(head, rows)}\n\n{load_text(database)}"


def bus_values() -> str:
    """Return the values with names of the bus's signals."""
    return table(("Signal", "Values"), named_rows(read_database()))


SPARE = ("precision", "growth", "memory_s", "usual_start", "sensitivity")
COMPENSATOR: tuple[tuple[str, type, tuple[str, ...]], ...] = (
    ("", Model, ("name", "title", "created", "input_form", "provenance")),
    ("sensors[].", Sensor, ()),
    ("limits.", Limits, ()),
    ("gaussian.", Gaussian, ()),
    ("spare.", Spare, SPARE),
)
"""Where the classes stand in the file, and which of their fields do; all, where none is named."""

TABLES: dict[str, Callable[[], str]] = {
    "effects": effects,
    "kinds": kinds,
    "units": units,
    "compensator_variables": compensator_variables,
    "plant_variables": plant_variables,
    "machine_fields": machine_fields,
    "page_fields": page_fields,
    "scenario_fields": scenario_fields,
    "signals": signals,
    "compensator_fields": compensator_fields,
    "map_fields": map_fields,
    "bus_frames": bus_frames,
    "bus_values": bus_values,
}


def renewed(text: str) -> str:
    """Return a page with its tables made anew."""
    return MARKS.sub(lambda found: f"{found[1]}{TABLES[found[2]]()}\n{found[3]}", text)


def main() -> None:
    """Write the pages that have changed."""
    for name in PAGES:
        page = DOCS / name
        old = page.read_text(encoding="utf-8")
        new = renewed(old)
        if new != old:
            write_atomically(page, new)
            print(f"{page.name} is written anew")


if __name__ == "__main__":
    main()
