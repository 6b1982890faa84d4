"""modelDescription.xml of FMI 3.0, from the same variables as for FMI 2.0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree as ET

from fmu_packaging.arrays import NAME as ARRAY
from fmu_packaging.arrays import OFFSETS, in_array, temperatures
from fmu_packaging.description import (
    Identity,
    Program,
    bounds,
    dependencies,
    described,
    experiment,
    head,
    initial_unknowns,
    interfaces,
    log_categories,
    measure,
    named,
    number,
    start_of,
    type_definitions,
    type_of,
    unit_definitions,
)
from fmu_packaging.slave import DriftSlave
from fmu_packaging.variables import Variable
from fmu_packaging.xml_files import xml_file

TYPES = {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "string": "String"}
TIME = "time"
SPINDLE = ("speed", "tool_length")
MEASURED = "measured"
EXACT = "-ffp-contract=off"
"""Contracted multiply-adds would round once, while the Python twin rounds twice."""

CAPABILITIES = {
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "canBeInstantiatedOnlyOncePerProcess": "false",
}
DERIVATIVES = ("providesDirectionalDerivatives", "providesAdjointDerivatives")
KINDS = {
    "ModelExchange": {"needsCompletedIntegratorStep": "true"},
    "CoSimulation": {"canHandleVariableCommunicationStepSize": "true", "hasEventMode": "false"},
}


def model_description3(
    slave: DriftSlave, identity: Identity, token: str, program: Program
) -> bytes:
    """Return modelDescription.xml of FMI 3.0.

    The value references are those of FMI 2.0, followed by the time, which FMI 3.0 requires as a
    variable.

    Parameters
    ----------
    slave : DriftSlave
        An instance; its variables are described.
    identity : Identity
    token : str
        The instantiation token.
    program : Program
        Runs the FMU.

    Raises
    ------
    UnitError
        For a variable with an unknown unit.
    """
    scalars = described(slave, program)
    references = {variable.name: reference for reference, variable in enumerate(scalars)}
    references[TIME] = len(scalars)
    variables = in_array(scalars) if program.array else scalars
    if program.array:
        # A variable that depends on one of them depends on the array.
        members = [variable.name for variable in temperatures(scalars)]
        references |= dict.fromkeys([ARRAY, *members], references[members[0]])
    root = head(identity, program, "3.0", "instantiationToken", token)
    attributes = {"needsExecutionTool": number(program.needs_host), **CAPABILITIES}
    derived = dict.fromkeys(DERIVATIVES, number(program.derivatives))
    for kind in interfaces(variables):
        facts = {"modelIdentifier": identity.name, **attributes, **KINDS[kind], **derived}
        if program.bus is not None and kind == "CoSimulation":
            facts["hasEventMode"] = "true"
        ET.SubElement(root, kind, facts)
    unit_definitions(root, variables, always=("s",))
    type_definitions(root, slave, variables, 3)
    log_categories(root, program)
    experiment(root, identity)
    listed = ET.SubElement(root, "ModelVariables")
    ports = [] if program.bus is None else program.bus.variables(references[TIME] + 1)
    references |= {port.get("name", ""): int(port.get("valueReference", "")) for port in ports}
    for variable in variables:
        element = _variable(variable, references[variable.name], type_of(slave, variable))
        if variable.derivative_of is not None:
            element.set("derivative", str(references[variable.derivative_of]))
        if variable.clock:
            element.set("clocks", str(references[variable.clock]))
        listed.append(element)
    listed.extend([_time(references[TIME]), *ports])
    structure = _structure(variables, references)
    if program.bus is not None:
        # Outputs come before initial unknowns.
        structure.extend(program.bus.unknowns(references[TIME] + 1))
        structure[:] = sorted(structure, key=lambda unknown: unknown.tag, reverse=True)
    root.append(structure)
    return xml_file(root)


def build_description(identity: Identity, program: Program) -> bytes:
    """Return sources/buildDescription.xml, which describes how to compile the sources.

    Parameters
    ----------
    identity : Identity
    program : Program
        Its sources are given by their paths.
    """
    root = ET.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = ET.SubElement(root, "BuildConfiguration", {"modelIdentifier": identity.name})
    options = {"language": "C99", "compiler": "gcc", "compilerOptions": EXACT}
    sources = ET.SubElement(configuration, "SourceFileSet", options)
    for path in program.sources:
        ET.SubElement(sources, "SourceFile", {"name": path})
    ET.SubElement(configuration, "Library", {"name": "m", "external": "true"})
    return xml_file(root)


def terminals(slave: DriftSlave, program: Program) -> bytes:
    """Return terminalsAndIcons.xml: groups of variables that a tool can connect by name at once.

    ``temperatures`` are those that one FMU reads and the other uses, ``offsets`` dX, dY and dZ,
    ``spindle`` the speed and tool length given to both, ``measured`` the values of a probe.

    Parameters
    ----------
    slave : DriftSlave
    program : Program
        Its bus is an additional terminal.
    """
    root = ET.Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    listed = ET.SubElement(root, "Terminals")
    ports = [variable for variable in slave.variables if not variable.is_parameter]
    array = [variable for variable in in_array(ports) if variable.elements] if program.array else []
    groups = {
        ARRAY: array or temperatures(ports),
        "offsets": [variable for variable in ports if variable.name in OFFSETS],
        "spindle": [v for v in ports if v.name in SPINDLE],
        "measured": [v for v in ports if v.name.partition("_")[0] == MEASURED],
    }
    for name, members in groups.items():
        if not members:
            continue
        terminal = ET.SubElement(listed, "Terminal", {"name": name, "matchingRule": "bus"})
        for variable in members:
            facts = {"variableName": variable.name, "memberName": variable.name}
            ET.SubElement(terminal, "TerminalMemberVariable", facts | {"variableKind": "signal"})
    if program.bus is not None:
        listed.append(program.bus.terminal())
    return xml_file(root)


def _variable(variable: Variable, reference: int, kind: str) -> ET.Element:
    attributes = named(variable, reference)
    if variable.causality != "input":
        attributes["initial"] = "calculated" if variable.is_computed else "exact"
    if kind:
        attributes["declaredType"] = kind
    if variable.kind == "real":
        attributes |= measure(variable)
    attributes |= bounds(variable)
    element = ET.Element(TYPES[variable.kind], attributes)
    if variable.elements:
        ET.SubElement(element, "Dimension", {"start": str(variable.elements)})
    if not variable.is_computed:
        start = start_of(variable)
        if variable.kind == "string":
            ET.SubElement(element, "Start", {"value": start})
        else:
            element.set("start", " ".join([start] * max(variable.elements, 1)))
    return element


def _time(reference: int) -> ET.Element:
    return ET.Element(
        TYPES["real"],
        {
            "name": TIME,
            "valueReference": str(reference),
            "description": "The time that has been reached",
            "causality": "independent",
            "variability": "continuous",
            "unit": "s",
        },
    )


def _structure(variables: Sequence[Variable], references: Mapping[str, int]) -> ET.Element:
    """Return the ModelStructure; parameters are always knowns."""
    structure = ET.Element("ModelStructure")
    for tag, unknowns in {
        "Output": [variable for variable in variables if variable.is_output],
        "ContinuousStateDerivative": [v for v in variables if v.derivative_of is not None],
        "InitialUnknown": initial_unknowns(variables),
    }.items():
        for variable in unknowns:
            attributes = {"valueReference": str(references[variable.name])}
            attributes |= dependencies(variable, references, at_start=tag == "InitialUnknown")
            ET.SubElement(structure, tag, attributes)
    return structure
