"""A bus terminal in an FMU's description, after FMI-LS-BUS: network abstraction ("low cut"), whose
variables hold bus operations, or physical signal abstraction ("high cut"), with one variable per
signal.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from fmu_packaging.xml_files import manifest, xml_file

NAME, VERSION = "org.fmi-standard.fmi-ls-bus", "1.0.0"
FOLDER = f"extra/{NAME}"
MANIFEST = f"{FOLDER}/fmi-ls-manifest.xml"
DESCRIPTION = (
    "Layered Standard for the simulation of bus communication on a Physical Signal Abstraction or "
    "Network Abstraction based level."
)
"""The exact text required by the schema of the manifest."""
LARGEST_FRAME = 2048
"""Bytes of operations passed at once: given by ``bus.h``, where it was set on no data."""
KIND = "org.fmi-ls-bus.network-terminal"
MEMBERS = ("Rx_Clock", "Tx_Clock", "Rx_Data", "Tx_Data")
FRAME_KIND, PDU_KIND = "org.fmi-ls-bus.frame-terminal", "org.fmi-ls-bus.pdu-terminal"


@dataclass(frozen=True)
class BusTerminal:
    """A low-cut bus terminal.

    Attributes
    ----------
    name : str
        Name of the network, and prefix of its variables' names.
    bus : str
        Kind of bus as in the MIME type: ``can``.
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
        data: list[ET.Element] = []
        way = {"Rx": ("input", "come in"), "Tx": ("output", "are sent")}
        for side, (causality, what) in way.items():
            facts = {
                "name": f"{self.name}.{side}_Data",
                "valueReference": refs[f"{side}_Data"],
                "description": f"Operations of the bus that {what}",
                "causality": causality,
                "variability": "discrete",
                "clocks": refs[f"{side}_Clock"],
                "mimeType": f'application/{NAME}.{self.bus}; version="{VERSION}"',
                "maxSize": str(LARGEST_FRAME),
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
        return data

    @property
    def notifications(self) -> str:
        """Name of the parameter for whether the bus confirms frames."""
        return f"{self.name}.BusNotifications"

    def unknowns(self, first: int) -> list[ET.Element]:
        """Return the entries of the model structure for ``Tx_Data``.

        Parameters
        ----------
        first : int
            Value reference of the first variable.
        """
        facts = {"valueReference": str(first + 3), "dependencies": str(first + 1)}
        return [ET.Element("Output", facts)]

    def terminal(self) -> ET.Element:
        """Return the terminal with its four members and the nested parameter."""
        facts = {"name": self.name, "terminalKind": KIND}
        facts["matchingRule"] = "org.fmi-ls-bus.transceiver"
        terminal = ET.Element("Terminal", facts)
        for member in MEMBERS:
            terminal.append(_member(f"{self.name}.{member}", member))
        facts = {"name": "Configuration", "terminalKind": f"{KIND}.configuration"}
        inner = ET.SubElement(terminal, "Terminal", facts | {"matchingRule": "bus"})
        inner.append(_member(self.notifications, "BusNotifications"))
        return terminal

    def files(self) -> dict[str, bytes]:
        """Return the files of the layered standard, by path."""
        return {MANIFEST: _manifest()}


@dataclass(frozen=True)
class BusFrame:
    """A frame whose signals are variables of the FMU.

    Attributes
    ----------
    name : str
    signals : tuple of str
    received : bool
        Whether it is received rather than sent.
    """

    name: str
    signals: tuple[str, ...]
    received: bool


@dataclass(frozen=True)
class SignalTerminal:
    """A high-cut bus terminal.

    Attributes
    ----------
    network : Path
        File that describes the network; its name is the prefix of the variables' names.
    node : str
        The FMU's node in that file.
    frames : tuple of BusFrame
        Received frames, then sent frames.
    """

    network: Path
    node: str
    frames: tuple[BusFrame, ...]

    def clock(self, frame: str) -> str:
        """Return the name of a frame's clock."""
        return f"{self.network.stem}.{frame}_Clock"

    def signal(self, frame: str, signal: str) -> str:
        """Return the name of a signal's variable; CAN has no PDUs, so the frame stands for one."""
        return f"{self.network.stem}.{frame}.{frame}.{signal}"

    def variables(self, first: int) -> list[ET.Element]:
        """Return the frames' clocks.

        Parameters
        ----------
        first : int
            Value reference of the first.
        """
        clocks = []
        for place, frame in enumerate(self.frames):
            done = "received" if frame.received else "sent"
            facts = {
                "name": self.clock(frame.name),
                "valueReference": str(first + place),
                "description": f"Ticks when {frame.name} is {done}",
                "causality": "input" if frame.received else "output",
                "intervalVariability": "triggered",
            }
            clocks.append(ET.Element("Clock", facts))
        return clocks

    def unknowns(self, first: int) -> list[ET.Element]:
        """Return the entries of the model structure for the clocks that tick by themselves.

        Parameters
        ----------
        first : int
            Value reference of the first clock.
        """
        refs = [first + place for place, frame in enumerate(self.frames) if not frame.received]
        facts = [{"valueReference": str(ref), "dependencies": ""} for ref in refs]
        return [ET.Element(tag, fact) for tag in ("Output", "InitialUnknown") for fact in facts]

    def terminal(self) -> ET.Element:
        """Return the terminal with a nested one per frame, which contains one for its signals."""
        facts = {"name": self.network.stem, "terminalKind": KIND, "matchingRule": "bus"}
        terminal = ET.Element("Terminal", facts)
        for frame in self.frames:
            facts = {"name": frame.name, "matchingRule": "bus"}
            outer = ET.SubElement(terminal, "Terminal", facts | {"terminalKind": FRAME_KIND})
            outer.append(_member(self.clock(frame.name), "Clock"))
            inner = ET.SubElement(outer, "Terminal", facts | {"terminalKind": PDU_KIND})
            inner.extend(_member(self.signal(frame.name, s), s) for s in frame.signals)
        notes = ET.SubElement(terminal, "Annotations")
        ET.SubElement(notes, "Annotation", {"type": self.node})
        return terminal

    def files(self) -> dict[str, bytes]:
        """Return the files of the layered standard, by path."""
        return {MANIFEST: _manifest(), f"{FOLDER}/{self.network.name}": self.network.read_bytes()}


def _member(variable: str, member: str) -> ET.Element:
    facts = {"variableName": variable, "memberName": member, "variableKind": "signal"}
    return ET.Element("TerminalMemberVariable", facts)


def _manifest() -> bytes:
    """Return the manifest of the layered standard."""
    root = manifest("fmiLayeredStandardManifest", NAME, VERSION, DESCRIPTION)
    root.set("isBusSimulationFMU", "false")
    return xml_file(root)
