"""``SystemStructure.ssd``: components, connections by equal names, start values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal
from xml.etree import ElementTree as ET

from fmu_packaging.units import BASES
from scenarios.version import PROGRAM, version

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}
FMU = "application/x-fmu-sharedlibrary"
OSP = "com.opensimulationplatform"
Ssp = Literal[1, 2]


@dataclass(frozen=True)
class Component:
    """An FMU in the system.

    Attributes
    ----------
    name : str
        Its name in the system and of its file ``resources/<name>.fmu``.
    description : object
        The FMU's model description as fmpy reads it.
    starts : dict of str to number
        Values set before the start, by variable.
    """

    name: str
    description: Any
    starts: Mapping[str, float] = field(default_factory=dict)

    @property
    def variables(self) -> dict[str, Any]:
        """The FMU's variables by name."""
        return {variable.name: variable for variable in self.description.modelVariables}


@dataclass(frozen=True)
class Connection:
    """Connects one component's outputs to another's inputs of the same names."""

    start: str
    end: str
    names: tuple[str, ...]


def structure(
    title: str,
    components: Sequence[Component],
    connections: Sequence[Connection],
    stop_s: float,
    step_s: float,
    ssp: Ssp = 1,
) -> bytes:
    """Return the text of ``SystemStructure.ssd``.

    Every component has its outputs and connected inputs as connectors with type and unit. The step
    is in an annotation that libcosim reads; SSP itself has no place for it.

    Parameters
    ----------
    title : str
    components : sequence of Component
    connections : sequence of Connection
    stop_s, step_s : float
        The default experiment [s].
    ssp : {1, 2}
        SSP version; the first does not support FMI 3.0.
    """
    for prefix, address in NAMESPACES.items():
        ET.register_namespace(prefix, address)
    facts = {"name": title, "version": f"{ssp}.0", "generationTool": f"{PROGRAM} {version()}"}
    root = ET.Element(_tag("ssd:SystemStructureDescription"), facts)
    system = _inside(root, "ssd:System", name="system")
    elements = _inside(system, "ssd:Elements")
    for component in components:
        _component(elements, component, connections, ssp)
    wires = _inside(system, "ssd:Connections")
    for connection in connections:
        for name in connection.names:
            _inside(
                wires,
                "ssd:Connection",
                startElement=connection.start,
                startConnector=name,
                endElement=connection.end,
                endConnector=name,
            )
    _units(root, components)
    experiment = _inside(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(stop_s))
    annotation = _inside(_inside(experiment, "ssd:Annotations"), "ssc:Annotation", type=OSP)
    algorithm = _inside(annotation, "osp:Algorithm")
    _inside(algorithm, "osp:FixedStepAlgorithm", baseStepSize=repr(step_s))
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


def _tag(name: str) -> str:
    prefix, _, local = name.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"


def _inside(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, _tag(tag), attributes)


def _component(
    elements: ET.Element, component: Component, connections: Iterable[Connection], ssp: Ssp
) -> None:
    name = component.name
    element = _inside(
        elements, "ssd:Component", name=name, type=FMU, source=f"resources/{name}.fmu"
    )
    taken = {entry for wire in connections if wire.end == name for entry in wire.names}
    connectors = _inside(element, "ssd:Connectors")
    for variable in component.variables.values():
        # Strings are left out: no input takes them, and some tools refuse connectors of that type.
        if (variable.causality == "output" and variable.type != "String") or variable.name in taken:
            connector = _inside(
                connectors, "ssd:Connector", name=variable.name, kind=variable.causality
            )
            unit = {"unit": variable.unit} if variable.unit else {}
            _inside(connector, f"ssc:{variable.type}", **unit)
    if not component.starts:
        return
    binding = _inside(_inside(element, "ssd:ParameterBindings"), "ssd:ParameterBinding")
    values = _inside(binding, "ssd:ParameterValues")
    table = _inside(values, "ssv:ParameterSet", version=f"{ssp}.0", name="scenario")
    parameters = _inside(table, "ssv:Parameters")
    for entry, value in component.starts.items():
        parameter = _inside(parameters, "ssv:Parameter", name=entry)
        _inside(parameter, f"ssv:{component.variables[entry].type}", value=_text(value))


def _text(value: float) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _units(root: ET.Element, components: Iterable[Component]) -> None:
    used = {
        unit.name: unit
        for component in components
        for unit in component.description.unitDefinitions
        if unit.baseUnit is not None
    }
    units = _inside(root, "ssd:Units")
    for name in sorted(used):
        base = used[name].baseUnit
        powers = {key: str(getattr(base, key)) for key in BASES if getattr(base, key)}
        unit = _inside(units, "ssc:Unit", name=name)
        _inside(unit, "ssc:BaseUnit", **powers, factor=repr(base.factor), offset=repr(base.offset))
