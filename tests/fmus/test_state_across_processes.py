"""A state goes on bit for bit in a process that has never seen the FMU, and a reset starts over."""

from pathlib import Path

import pytest

from tests.fmu_packaging.apart import apart

CODE = """
import math
path, kept = sys.argv[1:]
fmu, HALF = opened(path), 60
given = [v for v in fmpy.read_model_description(path).modelVariables
         if v.causality == "input" and v.valueReference in fmu.ins]
names = ("getFMUstate serializeFMUstate deSerializeFMUstate setFMUstate" if fmu.two else
         "getFMUState serializeFMUState deserializeFMUState setFMUState")
take, to_bytes, of_bytes, put_back = (getattr(fmu, name) for name in names.split())

def steps(first, last):
    rows = []
    for k in range(first, last):
        values = {v.name: float(v.start) + 0.3 * math.sin(k / 7.0 + place)
                  for place, v in enumerate(given)}
        values["speed"] += 4000.0 + 100.0 * math.sin(k / 7.0)
        if "T4" in values and 40 <= k < 80:
            values["T4"] = math.nan
        fmu.put(fmu.ins, list(values.values()))
        fmu.doStep(10.0 * k, 10.0)
        rows.append([value.hex() for value in fmu.get(fmu.outs)])
    return rows

def start():
    if "noise_seed" in fmu.refs:
        (fmu.setInteger if fmu.two else fmu.setInt32)([fmu.refs["noise_seed"]], [5])
    started(fmu)
"""
SAVES = """
start()
first = steps(0, HALF)
with open(kept, "wb") as file:
    file.write(to_bytes(take()))
rows = steps(HALF, 2 * HALF)
fmu.reset()
if fmu.two:
    fmu.setupExperiment(startTime=0.0)
start()
assert steps(0, HALF) == first != rows
show(rows)
"""
GOES_ON = """
with open(kept, "rb") as file:
    put_back(of_bytes(file.read()))
show(steps(HALF, 2 * HALF))
"""


@pytest.mark.long
@pytest.mark.parametrize("role", ["plant", "compensator"])
@pytest.mark.parametrize(
    ("folder", "form"),
    [("shipped", ""), ("shipped_in_c", "_native"), ("shipped_in_fmi3", "_native_fmi3")],
)
def test_a_fresh_process_goes_on_and_a_reset_starts_over(folder, form, role, tmp_path, request):
    path: Path = request.getfixturevalue(folder) / f"{role}{form}.fmu"
    wanted, found = (apart(CODE + part, path, tmp_path / "state") for part in (SAVES, GOES_ON))
    assert len({tuple(row) for row in wanted}) == len(wanted) == 60
    assert found == wanted
