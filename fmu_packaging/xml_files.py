"""Common parts of an FMU's XML files."""

from __future__ import annotations

from xml.etree import ElementTree as ET

NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"


def xml_file(root: ET.Element) -> bytes:
    """Return the text of a file, indented, in UTF-8."""
    ET.indent(root)
    body: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return body + b"\n"


def manifest(tag: str, name: str, version: str, description: str) -> ET.Element:
    """Return the root of a layered standard's manifest.

    Parameters
    ----------
    tag : str
        Name of the root in the standard.
    name, version, description : str
        Of the standard.
    """
    ET.register_namespace("fmi-ls", NAMESPACE)
    facts = {"name": name, "version": version, "description": description}
    return ET.Element(tag, {f"{{{NAMESPACE}}}fmi-ls-{key}": fact for key, fact in facts.items()})
