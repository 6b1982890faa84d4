"""modelDescription.xml from the variables that a slave declares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree as ET

from fmu_packaging.bus_terminal import BusTerminal, SignalTerminal
from fmu_packaging.slave import DriftSlave
from fmu_packaging.units import BASES, DISPLAY, base_unit, fmi_name, quantity
from fmu_packaging.variables import ZERO, Value, Variable
from fmu_packaging.xml_files import xml_file

PINNED_DATE = "2024-01-01T00:00:00Z"
"""The same content must give the same bytes, so this is not the date of the build."""

CAPABILITIES = {
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
KINDS = {
    "ModelExchange": {},
    "CoSimulation": {
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false",
        "maxOutputDerivativeOrder": "0",
        "canRunAsynchronuously": "false",
    },
}
"""Interface types of FMI, and the capabilities of each in addition to `CAPABILITIES`."""


@dataclass(frozen=True)
class Program:
    """The program that runs the FMU.

    Attributes
    ----------
    tool : str
        Generating tool, in addition to this project.
    needs_host : bool
        Whether the host must provide more than the FMU contains.
    sources : tuple of str
        Source files, by path in the source folder.
    variables : dict of str to Variable
        Replacements of the slave's variables of the same name, and additional ones.
    categories : dict of str to str
        Categories of its messages, and their descriptions.
    bus : BusTerminal or SignalTerminal, optional
        A bus terminal; FMI 3.0 only.
    array : bool
        Whether the temperatures are one array; FMI 3.0 only.
    derivatives : bool
        Whether it provides directional derivatives and, in FMI 3.0, adjoint ones.
    """

    tool: str
    needs_host: bool
    sources: tuple[str, ...] = ()
    variables: Mapping[str, Variable] = field(default_factory=dict)
    categories: Mapping[str, str] = field(default_factory=lambda: DriftSlave.log_categories)
    bus: BusTerminal | SignalTerminal | None = None
    array: bool = False
    derivatives: bool = False


PYTHON = Program("pythonfmu", needs_host=True)
"""The slave itself, run by the host's Python."""


@dataclass(frozen=True)
class Identity:
    """The identity of an FMU.

    Attributes
    ----------
    name : str
        Model identifier and model name; a C identifier.
    title, description : str
        Description in a few words, and in a sentence.
    version : str
        Version of the project.
    stop_s, step_s : float
        The default experiment [s].
    """

    name: str
    title: str
    description: str
    version: str
    stop_s: float
    step_s: float
    author: str = "spindle-drift"
    licence: str = "MIT"
    copyright: str = "Copyright the spindle-drift authors"


def model_description(
    slave: DriftSlave, identity: Identity, guid: str, program: Program = PYTHON
) -> bytes:
    """Return modelDescription.xml.

    Parameters
    ----------
    slave : DriftSlave
        An instance; its variables are described.
    identity : Identity
    guid : str
    program : Program
        Runs the FMU.

    Raises
    ------
    UnitError
        For a variable with an unknown unit.
    """
    variables = described(slave, program)
    root = head(identity, program, "2.0", "guid", guid)
    root.set("numberOfEventIndicators", "0")
    for kind in interfaces(variables):
        _interface(root, kind, identity, program)
    unit_definitions(root, variables)
    type_definitions(root, slave, variables)
    log_categories(root, program)
    experiment(root, identity)
    listed = ET.SubElement(root, "ModelVariables")
    names = [variable.name for variable in variables]
    for reference, variable in enumerate(variables):
        listed.append(_scalar_variable(variable, reference, type_of(slave, variable)))
    for place, derivative in enumerate(variables):
        if derivative.derivative_of is not None:
            state = names.index(derivative.derivative_of) + 1
            listed[place][0].set("derivative", str(state))
    root.append(_structure(variables))
    return xml_file(root)


def head(identity: Identity, program: Program, fmi: str, key: str, guid: str) -> ET.Element:
    """Return the root of a description; *key* is the name of the GUID in this version of FMI."""
    return ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": fmi,
            "modelName": identity.name,
            key: guid,
            "description": identity.description,
            "author": identity.author,
            "version": identity.version,
            "copyright": identity.copyright,
            "license": identity.licence,
            "generationTool": f"spindle-drift {identity.version} with {program.tool}",
            "generationDateAndTime": PINNED_DATE,
            "variableNamingConvention": "structured",
        },
    )


def described(slave: DriftSlave, program: Program) -> list[Variable]:
    """Return the variables of an FMU in the order of their value references.

    Parameters
    ----------
    slave : DriftSlave
    program : Program
        Its variables replace the slave's of the same name; others follow at the end.
    """
    by_name = {variable.name: variable for variable in slave.variables}
    return list((by_name | dict(program.variables)).values())


def interfaces(variables: Sequence[Variable]) -> list[str]:
    """Return the FMU's interface types: co-simulation, and model exchange if it has derivatives."""
    exchanged = any(variable.derivative_of is not None for variable in variables)
    return [kind for kind in KINDS if exchanged or kind != "ModelExchange"]


def initial_unknowns(variables: Sequence[Variable]) -> list[Variable]:
    """Return the variables computed at the start: outputs, then states and their derivatives."""
    unknowns = [variable for variable in variables if variable.is_computed and not variable.clock]
    return sorted(unknowns, key=lambda v: v.causality == "local")


def _interface(root: ET.Element, kind: str, identity: Identity, program: Program) -> None:
    attributes = {
        "modelIdentifier": identity.name,
        "needsExecutionTool": number(program.needs_host),
        **CAPABILITIES,
        **KINDS[kind],
        "providesDirectionalDerivative": number(program.derivatives),
    }
    element = ET.SubElement(root, kind, attributes)
    if program.sources:
        listed = ET.SubElement(element, "SourceFiles")
        for path in program.sources:
            ET.SubElement(listed, "File", {"name": path})


def log_categories(root: ET.Element, program: Program) -> None:
    """Add the categories of messages."""
    categories = ET.SubElement(root, "LogCategories")
    for name, text in program.categories.items():
        ET.SubElement(categories, "Category", {"name": name, "description": text})


def type_of(slave: DriftSlave, variable: Variable) -> str:
    """Return the name of a variable's own type; empty if it has none."""
    name = variable.name.capitalize()
    return name if name in slave.enumerations else ""


def type_definitions(
    root: ET.Element, slave: DriftSlave, variables: Sequence[Variable], fmi: int = 2
) -> None:
    """Add the types of integers with named codes: range, and meaning of each code.

    They are not enumerations, because those of FMI 3.0 have 64 bits and those of Modelica no gaps.
    """
    typed = [variable for variable in variables if type_of(slave, variable)]
    definitions = ET.SubElement(root, "TypeDefinitions") if typed else root
    for variable in typed:
        name = type_of(slave, variable)
        meanings = slave.enumerations[name].items()
        said = "; ".join(f"{code}: {text}" for code, text in meanings)
        text = {"name": name, "description": said}
        if fmi == 2:
            simple = ET.SubElement(definitions, "SimpleType", text)
            ET.SubElement(simple, "Integer", bounds(variable))
        else:
            ET.SubElement(definitions, "Int32Type", text | bounds(variable))


def bounds(variable: Variable) -> dict[str, str]:
    """Return the attributes for a variable's range."""
    attributes = {}
    for key, value in (("min", variable.low), ("max", variable.high)):
        if value is not None and variable.kind in {"real", "integer"}:
            attributes[key] = number(value if variable.kind == "real" else int(value))
    return attributes


def measure(variable: Variable) -> dict[str, str]:
    """Return the attributes for the quantity and unit of a real variable."""
    shown = variable.display_unit or (variable.unit if variable.unit in DISPLAY else "")
    attributes = {
        "quantity": quantity(variable.unit) if variable.unit else "",
        "unit": fmi_name(variable.unit) if variable.unit else "",
        "displayUnit": shown,
        "nominal": "" if variable.nominal is None else number(variable.nominal),
    }
    return {key: text for key, text in attributes.items() if text}


def experiment(root: ET.Element, identity: Identity) -> None:
    """Add the default experiment."""
    attributes = {
        "startTime": "0",
        "stopTime": number(identity.stop_s),
        "stepSize": number(identity.step_s),
    }
    ET.SubElement(root, "DefaultExperiment", attributes)


def unit_definitions(
    root: ET.Element, variables: Sequence[Variable], always: Sequence[str] = ()
) -> None:
    """Add the units of the variables, and those required in any case."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    used = {variable.unit for variable in variables if variable.kind == "real" and variable.unit}
    for name in sorted(used.union(always)):
        unit = ET.SubElement(definitions, "Unit", {"name": fmi_name(name)})
        base = base_unit(fmi_name(name))
        attributes = {power: str(base.powers[power]) for power in BASES if power in base.powers}
        if base.factor != 1.0:
            attributes["factor"] = number(base.factor)
        if base.offset:
            attributes["offset"] = number(base.offset)
        ET.SubElement(unit, "BaseUnit", attributes)
        others = DISPLAY.get(name, {})
        for shown, (factor, offset) in ({name: (1.0, 0.0)} | others if others else {}).items():
            display = {"name": shown, "factor": number(factor)}
            if offset:
                display["offset"] = number(offset)
            ET.SubElement(unit, "DisplayUnit", display)


def named(variable: Variable, reference: int) -> dict[str, str]:
    """Return the attributes that every variable has."""
    return {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": str(variable.variability),
    }


def start_of(variable: Variable) -> str:
    """Return a variable's start value; zero, false or empty if it has none."""
    return number(ZERO[variable.kind] if variable.start is None else variable.start)


def _scalar_variable(variable: Variable, reference: int, kind: str) -> ET.Element:
    element = ET.Element(
        "ScalarVariable",
        {
            **named(variable, reference),
            # An input has no such attribute: its start value is always exact.
            **({"initial": "calculated"} if variable.is_computed else {}),
            **({"initial": "exact"} if variable.is_parameter else {}),
        },
    )
    attributes = {"declaredType": kind} if kind else {}
    if variable.kind == "real":
        attributes |= measure(variable)
    attributes |= bounds(variable)
    if not variable.is_computed:
        attributes["start"] = start_of(variable)
    ET.SubElement(element, variable.kind.capitalize(), attributes)
    return element


def _structure(variables: Sequence[Variable]) -> ET.Element:
    """Return the ModelStructure.

    In co-simulation, outputs are computed in a step from inputs held during it, so at a
    communication point no output depends on an input. In model exchange, and before the first step,
    each depends on what its variable declares. Parameters are knowns only at the start.
    """
    structure = ET.Element("ModelStructure")
    positions = {variable.name: number for number, variable in enumerate(variables, start=1)}
    inputs = {v.name: positions[v.name] for v in variables if not v.is_parameter}
    for tag, unknowns in {
        "Outputs": [variable for variable in variables if variable.is_output],
        "Derivatives": [variable for variable in variables if variable.derivative_of is not None],
        "InitialUnknowns": initial_unknowns(variables),
    }.items():
        group = ET.SubElement(structure, tag) if unknowns else structure
        for variable in unknowns:
            attributes = {"index": str(positions[variable.name])}
            start = tag == "InitialUnknowns"
            attributes |= dependencies(variable, positions if start else inputs, at_start=start)
            ET.SubElement(group, "Unknown", attributes)
    return structure


def dependencies(
    variable: Variable, places: Mapping[str, int], *, at_start: bool
) -> dict[str, str]:
    """Return the attribute for a variable's dependencies; none: it may depend on everything."""
    names = variable.depends_at_start if at_start else variable.depends
    if names is None:
        return {}
    # FMI 2.0 has no variable for the time.
    return {"dependencies": " ".join(map(str, sorted({places[n] for n in names if n in places})))}


def number(value: Value) -> str:
    """Return a value as in XML, floats with all digits."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and value != value:
        return "NaN"
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    return str(value)
