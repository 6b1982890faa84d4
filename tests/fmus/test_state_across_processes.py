"""A state goes on bit for bit in a process that has never seen the FMU, and a reset starts over."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.patience import PATIENCE_S

HALF = 60
CODE = """
import json, math, sys
import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

path, kept, folder, role = sys.argv[1:]
described = fmpy.read_model_description(path)
three = described.fmiVersion.startswith("3")
fmu = (FMU3Slave if three else FMU2Slave)(
    guid=described.guid, unzipDirectory=fmpy.extract(path, folder),
    modelIdentifier=described.coSimulation.modelIdentifier)

def refs(causality, *kinds):
    return [v.valueReference for v in described.modelVariables
            if v.causality == causality and v.type in kinds]

given, seen = refs("input", "Real", "Float64"), refs("output", "Real", "Float64")
starts = [float(v.start) for v in described.modelVariables if v.valueReference in given
          and v.causality == "input" and v.type in ("Real", "Float64")]
names = [v.name for v in described.modelVariables if v.causality == "input"
         and v.type in ("Real", "Float64")]
write, read = (fmu.setFloat64, fmu.getFloat64) if three else (fmu.setReal, fmu.getReal)

def steps(first, last):
    rows = []
    for k in range(first, last):
        values = [start + math.sin(k / 7.0 + place) * (100.0 if name == "speed" else 0.3)
                  for place, (name, start) in enumerate(zip(names, starts))]
        if "speed" in names:
            values[names.index("speed")] += 4000.0
        if "T4" in names and 40 <= k < 80:
            values[names.index("T4")] = math.nan
        write(given, values)
        fmu.doStep(10.0 * k, 10.0)
        rows.append([value.hex() for value in map(float, read(seen))])
    return rows

def start():
    if not three:
        fmu.setupExperiment(startTime=0.0)
    for v in described.modelVariables:
        if v.name == "noise_seed":
            (fmu.setInt32 if three else fmu.setInteger)([v.valueReference], [5])
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()

fmu.instantiate()
if role == "saves":
    start()
    first = steps(0, HALF)
    state = fmu.getFMUState() if three else fmu.getFMUstate()
    data = fmu.serializeFMUState(state) if three else fmu.serializeFMUstate(state)
    with open(kept, "wb") as file:
        file.write(data)
else:
    with open(kept, "rb") as file:
        data = file.read()
    if three:
        fmu.setFMUState(fmu.deserializeFMUState(data))
    else:
        fmu.setFMUstate(fmu.deSerializeFMUstate(data))
rows = steps(HALF, 2 * HALF)
if role == "saves":
    fmu.reset()
    start()
    assert steps(0, HALF) == first != rows
print(json.dumps(rows))
""".replace("HALF", str(HALF))


@pytest.fixture(
    scope="session", params=["shipped", "shipped_in_c", "shipped_in_fmi3"], ids=["py", "c", "c3"]
)
def folder(request: pytest.FixtureRequest) -> tuple[Path, str]:
    """A folder of shipped FMUs, and how the names of one form of them end."""
    endings = {"shipped": "", "shipped_in_c": "_native", "shipped_in_fmi3": "_native_fmi3"}
    return request.getfixturevalue(request.param), endings[request.param]


@pytest.mark.parametrize("role", ["plant", "compensator"])
def test_a_fresh_process_goes_on_and_a_reset_starts_over(folder, role, tmp_path):
    path = folder[0] / f"{role}{folder[1]}.fmu"
    found = []
    for part in ("saves", "goes_on"):
        done = subprocess.run(
            [sys.executable, "-P", "-c", CODE, path, tmp_path / "state", tmp_path / part, part],
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        found.append(json.loads(done.stdout.splitlines()[-1]))
    assert len({tuple(row) for row in found[0]}) == HALF
    assert found[0] == found[1]
