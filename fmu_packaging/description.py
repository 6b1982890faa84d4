"""modelDescription.xml from the variables that a slave declares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree as ET

from fmu_packaging.slave import DriftSlave
from fmu_packaging.units import BASES, DISPLAY, base_unit
from fmu_packaging.variables import ZERO, Value, Variable

PINNED_DATE = "2024-01-01T00:00:00Z"
"""The same content must give the same bytes, so the date says nothing about the day of a build."""

CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "maxOutputDerivativeOrder": "0",
    "canRunAsynchronuously": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "false",
}


@dataclass(frozen=True)
class Program:
    """What runs the FMU.

    Attributes
    ----------
    tool : str
        What made it, beside this project.
    needs_host : bool
        Whether the host must provide more than the FMU carries.
    sources : tuple of str
        Source files, by path in the folder of sources.
    variables : dict of str to Variable
        Those that stand in for the slave's of the same name.
    """

    tool: str
    needs_host: bool
    sources: tuple[str, ...] = ()
    variables: Mapping[str, Variable] = field(default_factory=dict)


PYTHON = Program("pythonfmu", needs_host=True)
"""The slave itself, in the Python that the host provides."""


@dataclass(frozen=True)
class Identity:
    """Who an FMU is.

    Attributes
    ----------
    name : str
        Model identifier and model name; a C identifier.
    title, description : str
        What it is, in a few words and in a sentence.
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
        What does the slave's work.

    Raises
    ------
    UnitError
        For a variable with a unit that is not understood.
    """
    variables = described(slave, program)
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": identity.name,
            "guid": guid,
            "description": identity.description,
            "author": identity.author,
            "version": identity.version,
            "copyright": identity.copyright,
            "license": identity.licence,
            "generationTool": f"spindle-drift {identity.version} with {program.tool}",
            "generationDateAndTime": PINNED_DATE,
            "variableNamingConvention": "structured",
            "numberOfEventIndicators": "0",
        },
    )
    _co_simulation(root, identity, program)
    unit_definitions(root, variables)
    type_definitions(root, slave)
    log_categories(root, slave)
    experiment(root, identity)
    listed = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        listed.append(_scalar_variable(variable, reference))
    root.append(_structure(variables))
    ET.indent(root)
    body: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return body + b"\n"


def described(slave: DriftSlave, program: Program) -> list[Variable]:
    """Return the variables of an FMU in the order of their value references.

    Parameters
    ----------
    slave : DriftSlave
    program : Program
        Its own variables take the place of the slave's of the same name.
    """
    return [program.variables.get(variable.name, variable) for variable in slave.variables]


def _co_simulation(root: ET.Element, identity: Identity, program: Program) -> None:
    attributes = {
        "modelIdentifier": identity.name,
        "needsExecutionTool": number(program.needs_host),
        **CAPABILITIES,
    }
    element = ET.SubElement(root, "CoSimulation", attributes)
    if program.sources:
        listed = ET.SubElement(element, "SourceFiles")
        for path in program.sources:
            ET.SubElement(listed, "File", {"name": path})


def log_categories(root: ET.Element, slave: DriftSlave) -> None:
    """Add the categories of messages."""
    categories = ET.SubElement(root, "LogCategories")
    for name, text in slave.log_categories.items():
        ET.SubElement(categories, "Category", {"name": name, "description": text})


def type_definitions(root: ET.Element, slave: DriftSlave, fmi: int = 2) -> None:
    """Add the enumerations that say what codes mean; the variables stay integers."""
    definitions = ET.SubElement(root, "TypeDefinitions") if slave.enumerations else root
    for name, meanings in slave.enumerations.items():
        if fmi == 2:
            simple = ET.SubElement(definitions, "SimpleType", {"name": name})
            listed = ET.SubElement(simple, "Enumeration")
        else:
            listed = ET.SubElement(definitions, "EnumerationType", {"name": name})
        for code, text in meanings.items():
            ET.SubElement(listed, "Item", {"name": text, "value": str(code)})


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
    """Add the units of the variables, and those that are wanted in any case."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    used = {variable.unit for variable in variables if variable.kind == "real"}
    for name in sorted(used.union(always)):
        unit = ET.SubElement(definitions, "Unit", {"name": name})
        base = base_unit(name)
        attributes = {power: str(base.powers[power]) for power in BASES if power in base.powers}
        if base.factor != 1.0:
            attributes["factor"] = number(base.factor)
        if base.offset:
            attributes["offset"] = number(base.offset)
        ET.SubElement(unit, "BaseUnit", attributes)
        for shown, (factor, offset) in DISPLAY.get(name, {}).items():
            display = {"name": shown, "factor": number(factor)}
            if offset:
                display["offset"] = number(offset)
            ET.SubElement(unit, "DisplayUnit", display)


def _scalar_variable(variable: Variable, reference: int) -> ET.Element:
    element = ET.Element(
        "ScalarVariable",
        {
            "name": variable.name,
            "valueReference": str(reference),
            "description": variable.description,
            "causality": variable.causality,
            "variability": str(variable.variability),
            # An input has no such attribute: its start value is always exact.
            **({"initial": "calculated"} if variable.is_output else {}),
            **({"initial": "exact"} if variable.is_parameter else {}),
        },
    )
    attributes: dict[str, str] = {}
    if variable.kind == "real":
        attributes["unit"] = variable.unit
        if variable.display_unit:
            attributes["displayUnit"] = variable.display_unit
    for key, value in (("min", variable.low), ("max", variable.high)):
        if value is not None and variable.kind in {"real", "integer"}:
            attributes[key] = number(value if variable.kind == "real" else int(value))
    if variable.nominal is not None and variable.kind == "real":
        attributes["nominal"] = number(variable.nominal)
    if not variable.is_output:
        attributes["start"] = number(
            ZERO[variable.kind] if variable.start is None else variable.start
        )
    ET.SubElement(element, variable.kind.capitalize(), attributes)
    return element


def _structure(variables: Sequence[Variable]) -> ET.Element:
    """Return the ModelStructure.

    Outputs are computed in a step from inputs held during it, so at a communication point no
    output depends on an input: the list of dependencies is empty. Before the first step each
    depends on what its variable declares.
    """
    structure = ET.Element("ModelStructure")
    positions = {variable.name: number for number, variable in enumerate(variables, start=1)}
    outputs = [variable for variable in variables if variable.is_output]
    for tag in ("Outputs", "InitialUnknowns") if outputs else ():
        group = ET.SubElement(structure, tag)
        for variable in outputs:
            attributes = {"index": str(positions[variable.name])}
            if tag == "Outputs":
                attributes["dependencies"] = ""
            elif variable.depends_at_start is not None:
                known = sorted(positions[name] for name in variable.depends_at_start)
                attributes["dependencies"] = " ".join(map(str, known))
            ET.SubElement(group, "Unknown", attributes)
    return structure


def number(value: Value) -> str:
    """Return a value as XML writes it; floats in full."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    return str(value)
