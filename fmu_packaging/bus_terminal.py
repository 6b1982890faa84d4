"""A bus terminal in an FMU's description: FMI-LS-BUS, network abstraction ("low cut")."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET

from fmu_packaging.xml_files import manifest, xml_file

NAME, VERSION = "org.fmi-standard.fmi-ls-bus", "1.0.0"
MANIFEST = f"extra/{NAME}/fmi-ls-manifest.xml"
DESCRIPTION = (
    "Layered Standard for the simulation of bus communication on a Physical Signal Abstraction or "
    "Network Abstraction based level."
)
"""As the schema of the manifest wants it, word for word."""
LARGEST = 2048
"""Bytes of operations that are passed at once, as in ``bus.h``."""
NOTIFICATIONS = "BusNotifications"
KIND = "org.fmi-ls-bus.network-terminal"
MEMBERS = ("Rx_Data", "Tx_Data", "Rx_Clock", "Tx_Clock")


@dataclass(frozen=True)
class BusTerminal:
    """A terminal of a bus.

    Attributes
    ----------
    name : str
        Of the network; what its variables' names begin with.
    bus : str
        Its kind, as the MIME type names it: ``can``.
    """

    name: str
    bus: str

    def variables(self, first: int) -> list[ET.Element]:
        """Return its variables, in the order of ``bus.h``.

        Parameters
        ----------
        first : int
            Value reference of the first.
        """
        refs = {member: str(first + place) for place, member in enumerate(MEMBERS)}
        data, way = [], {"Rx": ("input", "come in"), "Tx": ("output", "are sent")}
        for side, (causality, what) in way.items():
            facts = {
                "name": f"{self.name}.{side}_Data",
                "valueReference": refs[f"{side}_Data"],
                "description": f"Operations of the bus that {what}",
                "causality": causality,
                "variability": "discrete",
                "clocks": refs[f"{side}_Clock"],
                "mimeType": f'application/{NAME}.{self.bus}; version="{VERSION}"',
                "maxSize": str(LARGEST),
            }
            facts["initial"] = "exact" if side == "Rx" else "calculated"
            data.append(ET.Element("Binary", facts))
        ET.SubElement(data[0], "Start", {"value": ""})
        for side, interval in {"Rx": "triggered", "Tx": "countdown"}.items():
            facts = {
                "name": f"{self.name}.{side}_Clock",
                "valueReference": refs[f"{side}_Clock"],
                "description": f"Ticks with {side}_Data",
                "causality": "input",
                "intervalVariability": interval,
            }
            data.append(ET.Element("Clock", facts))
        facts = {
            "name": f"{self.name}.{NOTIFICATIONS}",
            "valueReference": str(first + len(MEMBERS)),
            "description": "Whether the bus confirms frames; this node does not wait for that",
            "causality": "parameter",
            "variability": "fixed",
            "initial": "exact",
            "start": "false",
        }
        return [*data, ET.Element("Boolean", facts)]

    def output(self, first: int) -> ET.Element:
        """Return what the model structure says of ``Tx_Data``.

        Parameters
        ----------
        first : int
            Value reference of the first variable.
        """
        facts = {"valueReference": str(first + 1), "dependencies": str(first + 3)}
        return ET.Element("Output", facts)

    def terminal(self) -> ET.Element:
        """Return the terminal with its four members, and the parameter inside."""
        facts = {"name": self.name, "terminalKind": KIND}
        facts["matchingRule"] = "org.fmi-ls-bus.transceiver"
        terminal = ET.Element("Terminal", facts)
        for member in MEMBERS:
            terminal.append(self._member(member))
        facts = {"name": "Configuration", "terminalKind": f"{KIND}.configuration"}
        inner = ET.SubElement(terminal, "Terminal", facts | {"matchingRule": "bus"})
        inner.append(self._member(NOTIFICATIONS))
        return terminal

    def _member(self, member: str) -> ET.Element:
        facts = {"variableName": f"{self.name}.{member}", "memberName": member}
        return ET.Element("TerminalMemberVariable", facts | {"variableKind": "signal"})


def bus_manifest() -> bytes:
    """Return the manifest of the layered standard."""
    root = manifest("fmiLayeredStandardManifest", NAME, VERSION, DESCRIPTION)
    root.set("isBusSimulationFMU", "false")
    return xml_file(root)
