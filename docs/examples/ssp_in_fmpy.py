"""An .ssp of SSP 2.0 in fmpy: python ssp_in_fmpy.py FILE.ssp STEP_S STOP_S OUT.csv.

Its FMUs must be FMI 3.0, as C99 FMUs are in SSP 2.0. All outputs are passed on, then all FMUs step.
"""

import sys
import tempfile
import zipfile
from xml.etree import ElementTree as ET

import fmpy
import pandas as pd
from fmpy.fmi3 import FMU3Slave

WANTED = {
    "plant": ["error_X", "error_Y", "error_Z", "drift_Z", "T1"],
    "compensator": ["dX", "dY", "dZ"],
}
SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"


class Part:
    """A component of the system: its FMU, and the values set before the start."""

    def __init__(self, element, folder):
        path = f"{folder}/{element.get('source')}"
        description = fmpy.read_model_description(path)
        self.refs = {entry.name: entry.valueReference for entry in description.modelVariables}
        self.fmu = FMU3Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmpy.extract(path, f"{folder}/{element.get('name')}"),
            instanceName=element.get("name"),
        )
        self.fmu.instantiate()
        for parameter in element.iter(f"{SSV}Parameter"):
            (value,) = parameter
            kind = value.tag.removeprefix(SSV)
            number = float if kind == "Float64" else int
            ref = self.refs[parameter.get("name")]
            getattr(self.fmu, f"set{kind}")([ref], [number(value.get("value"))])

    def give(self, values):
        """Set real inputs by name."""
        self.fmu.setFloat64([self.refs[name] for name in values], list(values.values()))

    def take(self, names):
        """Return real outputs by name."""
        found = self.fmu.getFloat64([self.refs[name] for name in names])
        return dict(zip(names, found, strict=True))


def hand_on(starts, ends):
    """Pass the outputs of some FMUs to the inputs of others, along the connections."""
    given = {end: {} for end in ends}
    for wire in wires:
        if wire["startElement"] in starts and wire["endElement"] in ends:
            (value,) = parts[wire["startElement"]].take([wire["startConnector"]]).values()
            given[wire["endElement"]][wire["endConnector"]] = value
    for end, values in given.items():
        parts[end].give(values)


folder = tempfile.TemporaryDirectory()
with zipfile.ZipFile(sys.argv[1]) as archive:
    archive.extractall(folder.name)
root = ET.parse(f"{folder.name}/SystemStructure.ssd").getroot()
parts = {entry.get("name"): Part(entry, folder.name) for entry in root.iter(f"{SSD}Component")}
wires = [entry.attrib for entry in root.iter(f"{SSD}Connection")]
step, stop = float(sys.argv[2]), float(sys.argv[3])
# Each starts with the outputs of those before it: first the FMU that plays the signals.
order = ["signals", "plant", "compensator"]
for place, name in enumerate(order):
    parts[name].fmu.enterInitializationMode(startTime=0.0)
    hand_on(order[:place], [name])
    parts[name].fmu.exitInitializationMode()

rows = []
for k in range(round(stop / step) + 1):
    found = {"time": k * step}
    for name, wanted in WANTED.items():
        found |= parts[name].take(wanted)
    rows.append(found)
    hand_on(parts, parts)
    for part in parts.values():
        part.fmu.doStep(k * step, step)
pd.DataFrame(rows).to_csv(sys.argv[4], index=False)
