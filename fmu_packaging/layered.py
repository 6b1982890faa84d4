"""FMI-LS-REF: an FMU that contains its own reference run, so that any importer can repeat it.

The layered standard (github.com/modelica/fmi-ls-ref) lists files and their roles in a manifest; the
run itself is in the Modelica Association's experiments format (modelica/ma-hs-experiments).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from xml.etree import ElementTree as ET

from fmu_packaging.xml_files import manifest, xml_file

NAME, VERSION = "org.fmi-standard.fmi-ls-ref", "1.0.0-alpha.1"
FOLDER = f"extra/{NAME}"
MANIFEST = f"{FOLDER}/fmi-ls-manifest.xml"
EXPERIMENT = "application/x-ma-hs-experiments"
DESCRIPTION = "Layered Standard providing information on related files included in an FMU."
"""The exact text required by the schema of the manifest."""
MODELS = ("compensator.json", "machine.json")
"""Files from which FMUs are built."""


def reference_files(
    name: str, stop_s: float, step_s: float, inputs: str, result: str, files: Mapping[str, bytes]
) -> dict[str, bytes]:
    """Return the files of an FMU's reference run, by path.

    Parameters
    ----------
    name : str
        Name of the FMU.
    stop_s, step_s : float
        Length and step of the run, which begins at 0 [s].
    inputs, result : str
        The run's inputs and results, CSV.
    files : dict of str to bytes
        Other files in the FMU, by path.

    Returns
    -------
    dict of str to bytes
    """
    ends = {"in": inputs, "ref": result}
    run_files = {f"{FOLDER}/{name}_{end}.csv": text.encode() for end, text in ends.items()}
    run_files[f"{FOLDER}/{name}.exp"] = _experiments(name, stop_s, step_s)
    listed = {
        f"{FOLDER}/{name}.exp": (EXPERIMENT, "experiment/smoke-test", "A run of an hour"),
        f"{FOLDER}/{name}_ref.csv": ("text/csv", "result", "Results of that run"),
    }
    for path in sorted(files):
        if path.rpartition("/")[2] in MODELS:
            listed[path] = ("application/json", "model", "The file that the FMU was made from")
    return run_files | {MANIFEST: _manifest(listed, {**files, **run_files})}


def _experiments(name: str, stop_s: float, step_s: float) -> bytes:
    root = ET.Element("Experiments", {"name": name})
    experiment = ET.SubElement(root, "Experiment", {"name": "reference"})
    times = {"startTime": "0.0", "stopTime": repr(stop_s), "stepSize": repr(step_s)}
    ET.SubElement(experiment, "TransientSimulation", times)
    ET.SubElement(experiment, "Stimuli", {"source": f"{name}_in.csv"})
    ET.SubElement(experiment, "References", {"source": f"{name}_ref.csv"})
    return xml_file(root)


def _manifest(listed: Mapping[str, tuple[str, str, str]], files: Mapping[str, bytes]) -> bytes:
    root = manifest("fmiReferences", NAME, VERSION, DESCRIPTION)
    for path, (kind, role, description) in listed.items():
        inside = path.startswith(f"{FOLDER}/")
        facts = {
            "type": kind,
            "source": path.removeprefix(f"{FOLDER}/") if inside else f"../../{path}",
            "role": role,
            "description": description,
            "checksum": hashlib.sha3_256(files[path]).hexdigest(),
        }
        ET.SubElement(root, "Related", facts)
    return xml_file(root)
